//! The answer in sentences.

use super::answer::{Answer, Verdict, Where};

/// The first sentence is the verdict.
pub fn statements(answer: &Answer) -> Vec<String> {
    let mut all = vec![match answer.verdict {
        Verdict::NoEffect => format!(
            "no effect: the bicycle as declared explains the rides; {} mechanisms were tested, sizes below their detection limits may be there",
            answer.scores.len()
        ),
        Verdict::Cause => "one cause, confirmed on held-out rides".to_owned(),
        Verdict::Causes => format!("{} causes, confirmed on held-out rides", answer.causes.len()),
        Verdict::Partial => "part of what the model gets wrong has a provisional name; the rest, or the proof, is missing".to_owned(),
        Verdict::Unknown => "something is missing in the model that no mechanism of the library explains".to_owned(),
        Verdict::Tolerance if answer.tolerances_too_small => format!(
            "the declared tolerances are too small: with twice as much, parameters alone explain the rides; beyond what was declared lie {}",
            answer.out_of_tolerance.join(", ")
        ),
        Verdict::Tolerance => format!(
            "parameters beyond their declared tolerance: {}",
            answer.out_of_tolerance.join(", ")
        ),
        Verdict::NotTestable => "these rides cannot decide anything".to_owned(),
        Verdict::BadData => "the data is bad; nothing was concluded from it".to_owned(),
    }];
    for fault in &answer.faults {
        let ride = fault
            .ride
            .as_ref()
            .map_or(String::new(), |r| format!("{r}: "));
        all.push(format!("{ride}{}: {}", fault.channel, fault.reason));
    }
    for cause in &answer.causes {
        let values: Vec<String> = cause
            .parameters
            .iter()
            .map(|(name, v)| {
                format!(
                    "{name} = {:.4} [{:.4}, {:.4}]",
                    v.value, v.ci95[0], v.ci95[1]
                )
            })
            .collect();
        let state = if cause.confirmed {
            "confirmed"
        } else {
            "provisional"
        };
        let gain = cause
            .held_out_gain_nats
            .map_or("no held-out ride".to_owned(), |g| {
                format!("{g:.1} nats on held-out rides")
            });
        all.push(format!(
            "{} ({state}): {}; {gain}",
            cause.mechanism,
            values.join(", ")
        ));
        if cause.set.len() > 1 {
            all.push(format!(
                "these rides cannot tell apart: {}",
                cause.set.join(", ")
            ));
        }
    }
    let is_told = |p: &&Where| answer.causes.is_empty() || p.order.is_some() && p.with.is_none();
    for place in answer.places.iter().filter(is_told) {
        let band = place
            .band_hz
            .map_or(String::new(), |[a, b]| format!(", {a:.2} to {b:.2} Hz"));
        let order = place.order.as_ref().map_or(String::new(), |o| {
            format!(", order {} of the {}", o.n, o.of)
        });
        let when = place
            .time_s
            .zip(place.ride.as_ref())
            .map_or(String::new(), |([a, b], ride)| {
                format!(", at {a:.0} to {b:.0} s of {ride}")
            });
        let with = place
            .with
            .as_ref()
            .map_or(String::new(), |w| format!(", goes with {w}"));
        all.push(format!(
            "{} equation{band}{order}{when}{with} (p = {:.1e})",
            place.equation, place.p_value
        ));
    }
    if !answer.out_of_tolerance.is_empty() && answer.verdict != Verdict::Tolerance {
        all.push(format!(
            "at the end of their declared tolerance: {}",
            answer.out_of_tolerance.join(", ")
        ));
    }
    if !answer.unpredicted.is_empty() {
        all.push(format!(
            "nothing is confirmed while the model fails on held-out rides: {}",
            answer.unpredicted.join(", ")
        ));
    }
    if !answer.refused.is_empty() {
        all.push(format!(
            "refused, because they fit best at the end of their range: {}",
            answer.refused.join(", ")
        ));
    }
    if let Some(force) = &answer.latent_force {
        let gain = force.held_out_gain_nats.map_or(String::new(), |g| {
            format!("; it would gain {g:.1} nats on held-out rides")
        });
        let with = match (&force.goes_with, force.correlation) {
            (Some(name), Some(r)) => format!("; it goes with {name} (correlation {r:.2})"),
            _ => "; it goes with nothing that was measured".to_owned(),
        };
        all.push(format!(
            "what has no name is like a random {} torque of {:.2} Nm that lasts {:.2} s{gain}{with}",
            force.equation, force.sd_nm, force.time_s
        ));
    }
    if let Some(next) = &answer.next_experiment {
        all.push(format!(
            "next experiment: {} (separates {})",
            next.what,
            next.separates.join(", ")
        ));
    }
    all
}
