//! What an experiment can see: smallest sizes, and pairs that it cannot tell apart.

use super::Options;
use super::answer::NotTestable;
use super::fitting::{Baseline, calibrated};
use super::levels::start;
use super::limits;
use super::rides::prepare;
use super::run::{DiagnoseError, library, split};
use super::score::{Bench, Score, correlation};
use super::testable::obstacle;
use super::thresholds::{self, THRESHOLDS};
use crate::data::RideData;
use crate::study::Study;
use serde::Serialize;

/// A mechanism that the rides can show.
#[derive(Clone, Debug, Serialize)]
pub struct Visible {
    pub mechanism: String,
    pub parameter: String,
    /// Away from the value at which the mechanism is absent, in the parameter's unit.
    pub smallest: f64,
}

/// Two mechanisms whose effects are nearly the same in these rides.
#[derive(Clone, Debug, Serialize)]
pub struct Pair {
    pub mechanisms: [String; 2],
    /// Of their effects, calibration taken out.
    pub correlation: f64,
    /// The experiment that would part them.
    pub separated_by: String,
}

/// Everything about an experiment.
#[derive(Clone, Debug, Serialize)]
pub struct Experiment {
    pub schema_version: u32,
    pub tool: String,
    pub thresholds: String,
    pub study: String,
    pub visible: Vec<Visible>,
    pub not_testable: Vec<NotTestable>,
    pub pairs: Vec<Pair>,
    /// Experiments that part pairs, the one that parts most first, with the pairs.
    pub proposals: Vec<Proposal>,
}

/// One experiment and the pairs that it parts.
#[derive(Clone, Debug, Serialize)]
pub struct Proposal {
    pub what: String,
    pub separates: Vec<[String; 2]>,
}

/// Says what the rides of a study could show. Readings serve only to find the noise levels and the
/// path along which effects are compared.
pub fn experiment(
    study: &Study,
    data: &[RideData],
    progress: &mut dyn FnMut(&str),
) -> Result<Experiment, DiagnoseError> {
    let name = study.file.display().to_string();
    let Some(bicycle) = &study.bicycle else {
        return Err(DiagnoseError::Model { study: name });
    };
    if data.is_empty() {
        return Err(DiagnoseError::NoRide { study: name });
    }
    let (mut fit, held, free) = split(data).map_err(DiagnoseError::from)?;
    fit.extend(held);
    let mut result = Experiment {
        schema_version: 1,
        tool: format!("twinhub {}", env!("CARGO_PKG_VERSION")),
        thresholds: thresholds::hash(),
        study: study.name.clone(),
        visible: vec![],
        not_testable: vec![],
        pairs: vec![],
        proposals: vec![],
    };
    let mut testable = vec![];
    for mechanism in library(&Options::default())? {
        match obstacle(mechanism.card(), &fit, data) {
            Some(why) => result.not_testable.push(NotTestable {
                mechanism: mechanism.card().name.to_owned(),
                why,
            }),
            None => testable.push(mechanism),
        }
    }
    let nominal = start(bicycle, &free);
    let plant = nominal
        .plant()
        .map_err(|e| DiagnoseError::Bicycle(Box::new(e)))?;
    let rides = prepare(fit, &plant);
    let not_finite = || DiagnoseError::NotFinite {
        study: name.clone(),
    };
    let baseline = Baseline::fit(&rides, &free, nominal, calibrated(study, bicycle), progress)
        .ok_or_else(not_finite)?;
    let bench = Bench::new(&rides, &baseline).ok_or_else(not_finite)?;
    progress("effects of every mechanism");
    let mut scores: Vec<Score> = vec![];
    for mechanism in testable {
        match bench.score(mechanism) {
            Some(score) => scores.push(score),
            None => result.not_testable.push(NotTestable {
                mechanism: mechanism.card().name.to_owned(),
                why: limits::SAME_AS_TOLERANCE.to_owned(),
            }),
        }
    }
    for score in &scores {
        let card = score.mechanism.card();
        result.visible.push(Visible {
            mechanism: card.name.to_owned(),
            parameter: card.parameters[0].name.to_owned(),
            // Half of the rides' time is taken as held out.
            smallest: limits::limit(score, 1.0, rides.clock_s()),
        });
    }
    for (i, a) in scores.iter().enumerate() {
        for b in &scores[..i] {
            let rho = correlation(a, b);
            if rho > THRESHOLDS.pair_correlation {
                let (p, q) = (b.mechanism.card(), a.mechanism.card());
                let card = if q.confounded_with.contains(&p.name)
                    && !p.confounded_with.contains(&q.name)
                {
                    q
                } else {
                    p
                };
                result.pairs.push(Pair {
                    mechanisms: [p.name.to_owned(), q.name.to_owned()],
                    correlation: rho,
                    separated_by: card.separated_by.to_owned(),
                });
            }
        }
    }
    result
        .pairs
        .sort_by(|a, b| b.correlation.total_cmp(&a.correlation));
    for pair in &result.pairs {
        match result
            .proposals
            .iter_mut()
            .find(|p| p.what == pair.separated_by)
        {
            Some(proposal) => proposal.separates.push(pair.mechanisms.clone()),
            None => result.proposals.push(Proposal {
                what: pair.separated_by.clone(),
                separates: vec![pair.mechanisms.clone()],
            }),
        }
    }
    result
        .proposals
        .sort_by_key(|p| std::cmp::Reverse(p.separates.len()));
    Ok(result)
}
