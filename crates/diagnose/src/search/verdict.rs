//! From what the search found to a verdict: what is confirmed, what is taken back, what comes next.

use super::answer::{Answer, ChannelGain, Fault, NextExperiment, Verdict, Where};
use super::greedy::Found;
use super::score::Score;
use super::thresholds::THRESHOLDS;
use super::tolerance;
use twinhub_mechanism::Equation;

/// Verdict, confirmations, next experiment.
pub fn judge(answer: &mut Answer, found: &Found, decided: bool) {
    let dirty: Vec<&str> = found.left.iter().map(|l| l.probe.equation.name()).collect();
    let most_left = found.left.iter().map(|l| l.gain.nats).fold(0.0, f64::max);
    let too_many = found.accepted.len() > THRESHOLDS.most_confirmed;
    for (cause, accepted) in answer.causes.iter_mut().zip(&found.accepted) {
        let own = accepted.mechanism.card().equations;
        // Confirmed is what leaves its own equations clean and explains more than all that is left. What
        // a sensor says depends on all equations: its scale can stand in for what any of them lacks.
        let is_sensor = own.contains(&Equation::Sensor);
        let spoils = |e: &&str| is_sensor || own.iter().any(|own| own.name() == *e);
        cause.confirmed = decided
            && !too_many
            && accepted.gain.nats > most_left
            && !dirty.iter().any(|e| spoils(e));
    }
    for left in found
        .left
        .iter()
        .filter(|l| l.p_value < THRESHOLDS.unknown_p_value)
    {
        answer.places.push(Where {
            equation: left.probe.equation.name().to_owned(),
            band_hz: None,
            order: None,
            time_s: None,
            ride: None,
            p_value: left.p_value,
            with: Some(left.probe.regressor.words().to_owned()),
        });
    }
    if answer.causes.is_empty() && answer.places.is_empty() {
        answer.places.extend(unexplained(found));
    }
    let unknown = !answer.places.is_empty();
    answer.verdict = match answer.causes.len() {
        0 if unknown => Verdict::Unknown,
        0 if answer.tolerances_too_small => Verdict::Tolerance,
        0 => Verdict::NoEffect,
        _ if decided
            && answer
                .causes
                .iter()
                .all(|c| c.mechanism.starts_with(tolerance::PREFIX)) =>
        {
            Verdict::Tolerance
        }
        _ if !answer.causes.iter().all(|c| c.confirmed) => Verdict::Partial,
        1 => Verdict::Cause,
        _ => Verdict::Causes,
    };
    for cause in &answer.causes {
        let Some(mechanism) = twinhub_mechanism::find(&cause.mechanism) else {
            continue;
        };
        let card = mechanism.card();
        let places = Where {
            equation: equation_name(card),
            band_hz: None,
            order: None,
            time_s: None,
            ride: None,
            p_value: answer.scores.get(card.name).map_or(0.0, |s| s.p_value),
            with: Some(card.name.to_owned()),
        };
        answer.places.push(places);
        if cause.set.len() > 1 || answer.next_experiment.is_none() {
            let mut separates = cause.set.clone();
            if separates.len() == 1 {
                separates.extend(card.confounded_with.iter().map(|s| (*s).to_owned()));
            }
            answer.next_experiment = Some(NextExperiment {
                what: card.separated_by.to_owned(),
                separates,
            });
        }
    }
}

/// What the first tests saw beyond doubt, though nothing of it held on rides that were held out: silence
/// would be wrong. What the clocks cannot tell is not beyond doubt, nor what the fit does not bear out: half
/// of the statistic are the nats that it promises.
fn unexplained(found: &Found) -> Option<Where> {
    let is_clock = |s: &&Score| found.within_clock.contains(&s.mechanism.card().name);
    let is_refuted = |s: &&Score| {
        let fits = (found.contenders.iter()).filter(|c| c.0 == s.mechanism.card().name);
        let best = fits.map(|c| c.1).reduce(f64::max);
        best.is_some_and(|nats| nats < 0.5 * THRESHOLDS.refuted_share * s.statistic)
    };
    let strongest = found
        .first
        .iter()
        .filter_map(|t| t.score.as_ref())
        .filter(|s| !is_clock(s) && !is_refuted(s))
        .min_by(|a, b| a.p_value.total_cmp(&b.p_value))
        .filter(|s| s.p_value < THRESHOLDS.unknown_p_value)?;
    let card = strongest.mechanism.card();
    Some(Where {
        equation: equation_name(card),
        band_hz: None,
        order: None,
        time_s: None,
        ride: None,
        p_value: strongest.p_value,
        with: Some(card.name.to_owned()),
    })
}

/// Takes confirmations back where the extended model fails an output that can be predicted.
pub fn withdraw(answer: &mut Answer) {
    let t = &*THRESHOLDS;
    let failed = |gain: &ChannelGain| {
        let (Some(extended), Some(ceiling)) = (gain.extended_vaf, gain.ceiling_vaf) else {
            return false;
        };
        let loss = gain.calibrated_vaf.map_or(0.0, |before| before - extended);
        ceiling > t.foreseeable_vaf && (extended < t.least_vaf || loss > t.most_vaf_loss)
    };
    let failing = answer.gain.iter().filter(|(_, gain)| failed(gain));
    answer.unpredicted = failing.map(|(name, _)| name.clone()).collect();
    if answer.unpredicted.is_empty() {
        return;
    }
    if answer.verdict == Verdict::NoEffect {
        answer.verdict = Verdict::Unknown;
    }
    if answer.causes.iter().all(|c| !c.confirmed) {
        return;
    }
    for cause in &mut answer.causes {
        cause.confirmed = false;
    }
    answer.verdict = Verdict::Partial;
}

/// Rides that want different sizes of the cause called `name`. Where the model explains everything
/// else, they are not rides of one bicycle and the cause is none; where it fails anyway, the name stays
/// provisional.
pub fn disagree(answer: &mut Answer, name: &str, p: f64) {
    let otherwise_sound = answer.unpredicted.is_empty()
        && matches!(
            answer.verdict,
            Verdict::NoEffect | Verdict::Cause | Verdict::Causes | Verdict::Tolerance
        );
    let meaning = if otherwise_sound {
        answer.places.retain(|p| p.with.as_deref() == Some(name));
        answer.causes.clear();
        answer.next_experiment = None;
        answer.verdict = Verdict::Unknown;
        "not one bicycle, inputs that do not belong to the outputs, or a cause that has no name here"
    } else {
        for cause in &mut answer.causes {
            cause.confirmed = false;
        }
        if !answer.causes.is_empty() {
            answer.verdict = Verdict::Partial;
        }
        "its size holds for none of them"
    };
    answer.faults.push(Fault {
        channel: "rides".to_owned(),
        ride: None,
        reason: format!("the rides disagree about {name} (p = {p:.1e}): {meaning}"),
    });
}

/// The word of the answer for a mechanism's first equation.
fn equation_name(card: &twinhub_mechanism::Card) -> String {
    let first = card.equations[0];
    if first != twinhub_mechanism::Equation::Sensor {
        return first.name().to_owned();
    }
    let output = card.requires.iter().find_map(|r| match r {
        twinhub_mechanism::Requirement::Output(q) => Some(q.name()),
        _ => None,
    });
    format!("sensor:{}", output.unwrap_or("speed_m_s"))
}
