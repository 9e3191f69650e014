//! From a study to an answer.

use super::answer::{Answer, Candidate, Cause, Fault, NotTestable, ScoreLine, Value, Verdict};
use super::contender::Material;
use super::faults;
use super::fitting::{Baseline, calibrated, is_at_end};
use super::greedy::{Found, search};
use super::latent;
use super::levels::start;
use super::limits;
use super::refit::settle;
use super::rides::prepare;
use super::screen::is_strained;
use super::testable::obstacle;
use super::thresholds::{self, THRESHOLDS};
use super::tolerance;
use super::verdict::{disagree, judge, withdraw};
use super::{gain, wide, words};
use crate::data::{DataError, DataFolders, RideData, read_ride};
use crate::engine::{FreeNoise, Refusal, Ride, way};
use crate::study::{Place, Study, Use};
use std::collections::BTreeMap;
use twinhub_mechanism::{ALL, Mechanism};

/// Why a study cannot be diagnosed at all. What is wrong inside the rides is an answer, not an error.
#[non_exhaustive]
#[derive(Debug, thiserror::Error)]
pub enum DiagnoseError {
    #[error(
        "{study}: model = \"multibody\"; accepted: model = \"benchmark\": diagnosis predicts with the benchmark bicycle"
    )]
    Model { study: String },
    #[error(
        "{study}: no [[ride]]; accepted: at least one, for [[modes]] alone hold no input to predict with"
    )]
    NoRide { study: String },
    #[error("{study}: no ride or window with use = \"fit\"; accepted: at least one")]
    NoFit { study: String },
    #[error("{place}: found {found}; accepted: {accepted}")]
    Channel {
        place: Place,
        found: String,
        accepted: String,
    },
    #[error("unknown mechanism `{found}`; accepted: {accepted}")]
    Mechanism { found: String, accepted: String },
    #[error(transparent)]
    Data(#[from] DataError),
    #[error(transparent)]
    Bicycle(#[from] Box<twinhub_linear::BicycleError>),
    #[error("{study}: the rides cannot be predicted: the likelihood is not finite")]
    NotFinite { study: String },
}

impl From<Refusal> for DiagnoseError {
    fn from(r: Refusal) -> Self {
        Self::Channel {
            place: r.place,
            found: r.found,
            accepted: r.accepted,
        }
    }
}

/// What a diagnosis may look for.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// Mechanisms left out of the library.
    pub without: Vec<String>,
    /// If not empty, the whole library.
    pub only: Vec<String>,
}

/// Reads the rides beside the study (or from `$TWINHUB_DATA`) and diagnoses them.
pub fn diagnose(study: &Study, mut progress: impl FnMut(&str)) -> Result<Answer, DiagnoseError> {
    let folders = DataFolders::new(study, None);
    diagnose_in(study, &folders, &Options::default(), &mut progress)
}

/// As [`diagnose`], with folders and options.
pub fn diagnose_in(
    study: &Study,
    folders: &DataFolders,
    options: &Options,
    progress: &mut dyn FnMut(&str),
) -> Result<Answer, DiagnoseError> {
    if study.rides.is_empty() && !study.modes.is_empty() {
        return super::modes::diagnose_modes(study, folders, &library(options)?);
    }
    let mut data = vec![];
    for ride in &study.rides {
        progress(&format!("reading {}", ride.file));
        match read_ride(ride, folders) {
            Ok(ride) => data.push(ride),
            Err(
                error @ (DataError::Row { .. } | DataError::Cell { .. } | DataError::Value { .. }),
            ) => {
                let fault = Fault {
                    channel: channel_of(&error),
                    ride: Some(ride.file.clone()),
                    reason: error.to_string(),
                };
                return Ok(bad_data(study, vec![fault]));
            }
            Err(error) => return Err(error.into()),
        }
    }
    diagnose_data(study, &data, options, progress)
}

fn channel_of(error: &DataError) -> String {
    match error {
        DataError::Cell { column, .. } => column.clone(),
        DataError::Value { found, .. } => found.clone(),
        _ => "time".to_owned(),
    }
}

/// An answer with nothing in it yet.
pub(super) fn empty(study: &Study, verdict: Verdict) -> Answer {
    Answer {
        schema_version: 1,
        tool: format!("twinhub {}", env!("CARGO_PKG_VERSION")),
        thresholds: thresholds::hash(),
        study: study.name.clone(),
        verdict,
        places: vec![],
        causes: vec![],
        gain: BTreeMap::new(),
        next_experiment: None,
        not_testable: vec![],
        detection_limits: BTreeMap::new(),
        extended_plant: None,
        scores: BTreeMap::new(),
        candidates: vec![],
        calibration: BTreeMap::new(),
        out_of_tolerance: vec![],
        tolerances_too_small: false,
        refused: vec![],
        unpredicted: vec![],
        faults: vec![],
        latent_force: None,
        statements: vec![],
        pictures: super::pictures::Pictures::default(),
        plant: None,
    }
}

fn bad_data(study: &Study, faults: Vec<Fault>) -> Answer {
    let mut answer = empty(study, Verdict::BadData);
    answer.faults = faults;
    answer.statements = words::statements(&answer);
    answer
}

/// The library that options leave.
pub fn library(options: &Options) -> Result<Vec<&'static dyn Mechanism>, DiagnoseError> {
    for name in options.without.iter().chain(&options.only) {
        if twinhub_mechanism::find(name).is_none() {
            return Err(DiagnoseError::Mechanism {
                found: name.clone(),
                accepted: twinhub_mechanism::names().collect::<Vec<_>>().join(", "),
            });
        }
    }
    let has =
        |list: &[String], m: &&'static dyn Mechanism| list.iter().any(|name| name == m.card().name);
    let all = ALL.iter().copied();
    Ok(all
        .filter(|m| !has(&options.without, m))
        .filter(|m| options.only.is_empty() || has(&options.only, m))
        .collect())
}

/// Rides by use, and the noise levels that are free.
pub fn split(data: &[RideData]) -> Result<(Vec<Ride>, Vec<Ride>, FreeNoise), Refusal> {
    let mut free = FreeNoise::default();
    let (mut fit, mut held) = (vec![], vec![]);
    for ride in data {
        fit.extend(Ride::new(ride, Use::Fit, &mut free)?);
    }
    for ride in data {
        held.extend(Ride::new(ride, Use::HeldOut, &mut free)?);
    }
    way::set(&mut fit, &mut held, data);
    Ok((fit, held, free))
}

/// Diagnoses rides that were read.
pub fn diagnose_data(
    study: &Study,
    data: &[RideData],
    options: &Options,
    progress: &mut dyn FnMut(&str),
) -> Result<Answer, DiagnoseError> {
    let name = study.file.display().to_string();
    let Some(bicycle) = &study.bicycle else {
        return Err(DiagnoseError::Model { study: name });
    };
    if data.is_empty() {
        return Err(DiagnoseError::NoRide { study: name });
    }
    let all = library(options)?;
    let faults = faults::before_fit(bicycle, data);
    if !faults.is_empty() {
        return Ok(bad_data(study, faults));
    }
    let (fit, held, free) = split(data)?;
    if fit.is_empty() {
        return Err(DiagnoseError::NoFit { study: name });
    }
    let mut answer = empty(study, Verdict::NoEffect);
    let mut testable = vec![];
    for mechanism in all {
        match obstacle(mechanism.card(), &fit, data) {
            Some(why) => answer.not_testable.push(NotTestable {
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
    let (fit, held) = (prepare(fit, &plant), prepare(held, &plant));
    if fit.0.iter().all(|r| r.course.readings.is_empty()) {
        answer.verdict = Verdict::NotTestable;
        answer.statements = words::statements(&answer);
        return Ok(answer);
    }
    let not_finite = || DiagnoseError::NotFinite {
        study: name.clone(),
    };
    let parameters = calibrated(study, bicycle);
    let mut baseline =
        Baseline::fit(&fit, &free, nominal, parameters, progress).ok_or_else(not_finite)?;
    // As far as every contender will be fitted: else its gain is that of more steps. A calibration that is
    // pulled away by something it lacks is not to follow it farther.
    if !is_strained(&baseline) {
        baseline = settle(&fit, &free, baseline).ok_or_else(not_finite)?;
    }
    for (c, z) in baseline.all.iter().zip(&baseline.z) {
        answer
            .calibration
            .insert(c.symbol.to_owned(), c.value + z * c.sd);
        if is_at_end(*z) {
            answer.out_of_tolerance.push(c.symbol.to_owned());
            testable.push(tolerance::candidate(c));
        }
    }
    answer.faults = faults::dead_inputs(&fit, &baseline);
    if !answer.faults.is_empty() {
        answer.verdict = Verdict::BadData;
        answer.statements = words::statements(&answer);
        return Ok(answer);
    }
    let material = Material {
        fit: &fit,
        held: &held,
        free: &free,
    };
    let calibrated_model = baseline.model.clone();
    let mut found =
        search(&material, baseline.clone(), &testable, progress).ok_or_else(not_finite)?;
    if let Some(wide) = wide::rival(&material, &baseline, &found, testable.len(), progress) {
        testable.retain(|m| !tolerance::is_candidate(*m));
        answer.out_of_tolerance = wide.beyond(THRESHOLDS.calibration_box_sd / wide::FACTOR);
        answer.tolerances_too_small = true;
        found = search(&material, wide, &testable, progress).ok_or_else(not_finite)?;
    }
    fill(&mut answer, &found, &held);
    limits::fill(&mut answer, &found, &material);
    judge(&mut answer, &found, !held.0.is_empty());
    progress("gains on held-out rides");
    let nominal = crate::engine::Model {
        bicycle: bicycle.clone(),
        ..calibrated_model.clone()
    };
    let extended = &found.baseline.model;
    gain::fill(&mut answer, &held, &nominal, &calibrated_model, extended);
    withdraw(&mut answer);
    if let Some((name, p)) = found.disagreement {
        disagree(&mut answer, name, p);
        if answer.causes.is_empty() {
            // Nothing was extended.
            gain::fill(
                &mut answer,
                &held,
                &nominal,
                &calibrated_model,
                &calibrated_model,
            );
        }
    }
    progress("what has no name");
    latent::fill(&mut answer, &material, &found.baseline);
    super::locate::fill(&mut answer, &fit, &calibrated_model, &found);
    answer.plant = plant_file(study, &answer, &found);
    answer.statements = words::statements(&answer);
    Ok(answer)
}

/// Scores, candidates and causes.
fn fill(answer: &mut Answer, found: &Found, held: &crate::search::rides::Rides) {
    for tested in &found.first {
        let card = tested.mechanism.card();
        match &tested.score {
            Some(score) => {
                answer.scores.insert(
                    card.name.to_owned(),
                    ScoreLine {
                        p_value: score.p_value,
                        statistic: score.statistic,
                        size: score.first_size(),
                    },
                );
            }
            None if tested.mechanism.is_random() => {}
            None => answer.not_testable.push(NotTestable {
                mechanism: card.name.to_owned(),
                why: limits::SAME_AS_TOLERANCE.to_owned(),
            }),
        }
    }
    answer.refused = found.at_end.iter().map(|s| (*s).to_owned()).collect();
    let decided = !held.0.is_empty();
    for (name, fit, gain) in &found.contenders {
        answer.candidates.push(Candidate {
            mechanism: name.clone(),
            fit_gain_nats: *fit,
            held_out_gain_nats: decided.then_some(gain.nats),
            held_out_error_nats: decided.then_some(gain.error_nats),
        });
    }
    for (index, accepted) in found.accepted.iter().enumerate() {
        let active = &found.baseline.model.active[index];
        let sd = found.refit.as_ref().and_then(|r| r.sd.get(index));
        let card = active.mechanism.card();
        let parameters = card.parameters.iter().enumerate().map(|(k, param)| {
            let half = 1.96 * sd.and_then(|s| s.get(k)).copied().unwrap_or(f64::NAN);
            let value = active.p[k];
            (
                param.name.to_owned(),
                Value {
                    value,
                    ci95: [value - half, value + half],
                },
            )
        });
        answer.causes.push(Cause {
            mechanism: card.name.to_owned(),
            confirmed: false,
            parameters: parameters.collect(),
            set: accepted.set.iter().map(|s| (*s).to_owned()).collect(),
            held_out_gain_nats: accepted.decided.then_some(accepted.gain.nats),
            held_out_z: accepted.decided.then_some(accepted.gain.z),
        });
    }
}

fn plant_file(study: &Study, answer: &Answer, found: &Found) -> Option<twinhub_linear::Bicycle> {
    if answer.causes.is_empty() {
        return None;
    }
    let active = found.baseline.model.active.iter().enumerate();
    let causes: Vec<twinhub_mechanism::Accepted> = active
        .map(|(index, a)| twinhub_mechanism::Accepted {
            mechanism: a.mechanism,
            confirmed: answer.causes.get(index).is_some_and(|c| c.confirmed),
            p: a.p.clone(),
            sd: found
                .refit
                .as_ref()
                .and_then(|r| r.sd.get(index).cloned())
                .unwrap_or_default(),
        })
        .collect();
    let rides: Vec<&str> = study.rides.iter().map(|r| r.file.as_str()).collect();
    let source = format!(
        "{}, thresholds {}, study \"{}\" on {}, rides {}",
        answer.tool,
        answer.thresholds,
        study.name,
        study.parameters,
        rides.join(", ")
    );
    let name = format!("{}_extended", study.parameters);
    twinhub_mechanism::extended::extended(&found.baseline.model.bicycle, &name, &source, &causes)
        .ok()
}
