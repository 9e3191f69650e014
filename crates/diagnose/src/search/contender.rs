//! Mechanisms that were refitted in one round of the search, and which of them may be accepted.

use super::decide::{Blocks, Gain};
use super::fitting::Baseline;
use super::limits;
use super::random;
use super::refit::{Refit, polish, refit, refreshed, sketch};
use super::rides::Rides;
use super::score::{Score, correlation};
use super::screen::Guess;
use super::thresholds::THRESHOLDS;
use super::tolerance;
use crate::engine::FreeNoise;
use twinhub_mechanism::{Mechanism, Param};

/// Rides for fitting and rides for deciding.
pub struct Material<'a> {
    pub fit: &'a Rides,
    /// Empty: nothing can be confirmed.
    pub held: &'a Rides,
    pub free: &'a FreeNoise,
}

impl Material<'_> {
    /// Shortest delay that the clocks of all rides can tell, s.
    pub fn clock_s(&self) -> f64 {
        self.fit.clock_s().max(self.held.clock_s())
    }
}

/// What the score test says of one mechanism.
pub struct Tested {
    pub mechanism: &'static dyn Mechanism,
    /// None where the calibration explains all that it could do.
    pub score: Option<Score>,
}

/// A mechanism whose fit has begun.
pub struct Sketch {
    mechanism: &'static dyn Mechanism,
    fit: Baseline,
    /// Nats that the first steps gained on the fit rides.
    pub nats: f64,
}

/// A mechanism that was refitted in one round.
pub struct Contender {
    pub mechanism: &'static dyn Mechanism,
    pub refit: Refit,
    pub fit_nats: f64,
    pub gain: Gain,
    blocks: Option<Blocks>,
}

impl Contender {
    pub fn total(&self) -> f64 {
        self.fit_nats + self.gain.nats
    }
}

pub fn held_blocks(held: &Rides, baseline: &Baseline) -> Option<Blocks> {
    (!held.0.is_empty())
        .then(|| Blocks::new(held, &baseline.model))
        .flatten()
}

impl Sketch {
    fn begun(mechanism: &'static dyn Mechanism, baseline: &Baseline, fit: Baseline) -> Self {
        Self {
            mechanism,
            nats: baseline.cost - fit.cost,
            fit,
        }
    }

    pub fn new(material: &Material<'_>, baseline: &Baseline, score: &Score) -> Option<Self> {
        let fit = sketch(material.fit, baseline, score.mechanism, &score.size)?;
        Some(Self::begun(score.mechanism, baseline, fit))
    }

    /// A random mechanism, which no score can bring up.
    pub fn random(
        material: &Material<'_>,
        baseline: &Baseline,
        mechanism: &'static dyn Mechanism,
    ) -> Option<Self> {
        let fit = random::sketch(material.fit, baseline, mechanism)?;
        Some(Self::begun(mechanism, baseline, fit))
    }

    /// Goes on from a guess, on all of the fit rides.
    pub fn of_guess(material: &Material<'_>, baseline: &Baseline, guess: Guess) -> Option<Self> {
        let there = refreshed(material.fit, guess.fit)?;
        let fit = polish(material.fit, there, 1)?;
        Some(Self::begun(guess.mechanism, baseline, fit))
    }

    pub fn name(&self) -> &'static str {
        self.mechanism.card().name
    }

    /// What the sketch gains on held-out rides.
    pub fn gain(&self, material: &Material<'_>, before: Option<&Blocks>) -> Gain {
        let after = held_blocks(material.held, &self.fit);
        Gain::between(before, after.as_ref()).unwrap_or_default()
    }

    /// Fits to the end and decides.
    pub fn contend(
        self,
        material: &Material<'_>,
        baseline: &Baseline,
        before: Option<&Blocks>,
    ) -> Option<Contender> {
        let refit = refit(material.fit, material.free, self.fit)?;
        let blocks = held_blocks(material.held, &refit.baseline);
        let gain = Gain::between(before, blocks.as_ref()).unwrap_or_default();
        Some(Contender {
            mechanism: self.mechanism,
            fit_nats: baseline.cost - refit.baseline.cost,
            refit,
            gain,
            blocks,
        })
    }
}

/// What a mechanism pays for its parameters and for being one name of a library, nats.
pub fn penalty(mechanism: &dyn Mechanism, blocks: usize, library: usize) -> f64 {
    let parameters = mechanism.card().parameters.len() as f64;
    0.5 * parameters * libm::log(10.0 * blocks as f64) + libm::log(library as f64)
}

/// Whether the fit rides' evidence, penalised for parameters and library, is enough.
pub fn has_evidence(contender: &Contender, blocks: usize, library: usize) -> bool {
    let penalty = penalty(contender.mechanism, blocks, library);
    contender.fit_nats - penalty > THRESHOLDS.evidence_nats
}

/// Whether a fitted size is still at null.
fn is_absent(contender: &Contender) -> bool {
    let Some(active) = contender.refit.baseline.model.active.last() else {
        return true;
    };
    let null = active
        .mechanism
        .null(&contender.refit.baseline.model.bicycle.parameters);
    active.p[0] == null[0]
}

/// Whether a fit ended at an end of its range, null aside: the mechanism stands in for something
/// that it is not.
pub fn is_at_end(contender: &Contender) -> bool {
    let Some(active) = contender.refit.baseline.model.active.last() else {
        return false;
    };
    let parameters = active.mechanism.card().parameters;
    // A random force whose time is at an end is another one.
    let watched = if active.mechanism.is_random() {
        parameters.len()
    } else {
        1
    };
    let is_end = |(param, p): (&Param, &f64)| {
        let margin = 1e-6 * (param.most - param.least);
        margin.is_finite() && (*p <= param.least + margin || *p >= param.most - margin)
    };
    !is_absent(contender) && parameters.iter().zip(&active.p).take(watched).any(is_end)
}

/// Whether held-out rides decide for it. What is random has to act all the time: else it stands in for
/// something that acts now and then.
pub fn is_decided(contender: &Contender) -> bool {
    let gain = &contender.gain;
    gain.is_decisive()
        && (!contender.mechanism.is_random()
            || gain.share_of_blocks > THRESHOLDS.random_share_of_blocks)
}

/// Whether it is a delay that the clocks cannot tell.
pub fn is_within_clock(contender: &Contender, clock_s: f64) -> bool {
    let active = contender.refit.baseline.model.active.last();
    limits::is_delay(contender.mechanism.card().name)
        && active.is_some_and(|a| a.p[0].abs() < clock_s)
}

/// Whether it can be no cause.
pub fn is_degenerate(contender: &Contender) -> bool {
    is_absent(contender) || is_at_end(contender)
}

/// How far a parameter out of tolerance lies from its declared value, in declared standard deviations;
/// nothing for a mechanism.
fn deviation_sd(contender: &Contender) -> Option<f64> {
    let active = contender.refit.baseline.model.active.last()?;
    tolerance::deviation_sd(active.mechanism, active.p[0])
}

/// The first that may be accepted. Where a mechanism and a parameter out of tolerance explain the same,
/// the parameter is believed if it does not lie too far out.
pub fn pick(list: &[Contender], acceptable: impl Fn(&Contender) -> bool) -> Option<usize> {
    let best = list.iter().position(&acceptable)?;
    // Something that lies at its end explains more than all that may be accepted: no name fits.
    let most = list
        .iter()
        .filter(|c| is_at_end(c))
        .map(Contender::total)
        .fold(0.0, f64::max);
    if list[best].total() < THRESHOLDS.set_share * most {
        return None;
    }
    let is_believed =
        |c: &Contender| deviation_sd(c).is_some_and(|z| z.abs() < THRESHOLDS.believed_deviation_sd);
    let same = |c: &&Contender| acceptable(c) && is_close(&list[best], c);
    let is_rival = |c: &Contender| match deviation_sd(&list[best]) {
        Some(_) if is_believed(&list[best]) => false,
        Some(_) => deviation_sd(c).is_none(),
        None => is_believed(c),
    };
    let rival = list.iter().position(|c| same(&c) && is_rival(c));
    rival.or(Some(best))
}

/// Whether held-out blocks, or without them the fit, cannot tell that `other` is worse.
fn is_close(chosen: &Contender, other: &Contender) -> bool {
    let t = &*THRESHOLDS;
    match (&chosen.blocks, &other.blocks) {
        (Some(a), Some(b)) => {
            let difference = Gain::new(b, a);
            let fit = chosen.fit_nats - other.fit_nats;
            (difference.z < t.set_z || difference.nats < t.set_nats)
                && fit < 2.0 * t.set_nats + 0.1 * chosen.fit_nats
        }
        _ => chosen.fit_nats - other.fit_nats < t.set_nats,
    }
}

/// Names that cannot be told apart from the best: they explain about as much on held-out blocks, or
/// their effects are the same.
pub fn confusion(list: &[Contender], best: usize, tested: &[Tested]) -> Vec<&'static str> {
    let t = &*THRESHOLDS;
    let chosen = &list[best];
    let name = |m: &'static dyn Mechanism| m.card().name;
    let mut set = vec![name(chosen.mechanism)];
    for (index, other) in list.iter().enumerate() {
        if index == best || is_degenerate(other) || other.total() < t.set_share * chosen.total() {
            continue;
        }
        if is_close(chosen, other) || other.total() > t.near_share * chosen.total() {
            set.push(name(other.mechanism));
        }
    }
    let of = |m: &str| {
        tested
            .iter()
            .filter_map(|t| t.score.as_ref())
            .find(|s| s.mechanism.card().name == m)
    };
    if let Some(mine) = of(name(chosen.mechanism)) {
        for score in tested.iter().filter_map(|t| t.score.as_ref()) {
            let other = name(score.mechanism);
            // One whose sign is forbidden explains nothing.
            if !set.contains(&other)
                && score.statistic > 0.5 * mine.statistic
                && correlation(mine, score) > t.set_correlation
            {
                set.push(other);
            }
        }
    }
    set
}
