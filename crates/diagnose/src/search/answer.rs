//! The answer of a diagnosis, as it is printed, drawn and written as JSON.

use serde::Serialize;
use std::collections::BTreeMap;

/// The closed list of verdicts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    NoEffect,
    Cause,
    Causes,
    Partial,
    Unknown,
    Tolerance,
    NotTestable,
    BadData,
}

impl Verdict {
    /// The word of the answer.
    pub fn name(self) -> &'static str {
        match self {
            Self::NoEffect => "no_effect",
            Self::Cause => "cause",
            Self::Causes => "causes",
            Self::Partial => "partial",
            Self::Unknown => "unknown",
            Self::Tolerance => "tolerance",
            Self::NotTestable => "not_testable",
            Self::BadData => "bad_data",
        }
    }
}

/// Multiple of a turning rate.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Order {
    pub of: String,
    pub n: u32,
}

/// Where the model and the rides part.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Where {
    pub equation: String,
    pub band_hz: Option<[f64; 2]>,
    pub order: Option<Order>,
    pub time_s: Option<[f64; 2]>,
    pub ride: Option<String>,
    pub p_value: f64,
    /// What it goes with.
    pub with: Option<String>,
}

/// A parameter with its interval.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Value {
    pub value: f64,
    pub ci95: [f64; 2],
}

/// One cause.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Cause {
    pub mechanism: String,
    pub confirmed: bool,
    pub parameters: BTreeMap<String, Value>,
    /// Everything that the data cannot tell apart from it, itself included.
    pub set: Vec<String>,
    /// Null without held-out data.
    pub held_out_gain_nats: Option<f64>,
    /// z of the mean gain over held-out blocks.
    pub held_out_z: Option<f64>,
}

/// How well one channel is predicted, on held-out data.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ChannelGain {
    pub nominal_vaf: Option<f64>,
    pub calibrated_vaf: Option<f64>,
    pub extended_vaf: Option<f64>,
    pub ceiling_vaf: Option<f64>,
    /// Nominal, calibrated, extended.
    pub rmse_by_horizon_s: BTreeMap<String, Option<[f64; 3]>>,
}

/// The experiment that would tell more.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct NextExperiment {
    pub what: String,
    pub separates: Vec<String>,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct NotTestable {
    pub mechanism: String,
    pub why: String,
}

/// One mechanism's test in the first round.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ScoreLine {
    pub p_value: f64,
    pub statistic: f64,
    /// Linear estimate of the first parameter's size, in its unit, away from null.
    pub size: f64,
}

/// A candidate that was refitted, for the ranking.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Candidate {
    pub mechanism: String,
    pub fit_gain_nats: f64,
    pub held_out_gain_nats: Option<f64>,
    pub held_out_error_nats: Option<f64>,
}

/// What is wrong with the data.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Fault {
    pub channel: String,
    pub ride: Option<String>,
    pub reason: String,
}

/// A latent force: how much a nameless slow torque would gain.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LatentForce {
    pub equation: String,
    pub sd_nm: f64,
    pub time_s: f64,
    /// Null without held-out rides.
    pub held_out_gain_nats: Option<f64>,
    /// The quantity with which it correlates most, if it does with any.
    pub goes_with: Option<String>,
    pub correlation: Option<f64>,
}

/// Everything that a diagnosis says.
#[derive(Clone, Debug, Serialize)]
pub struct Answer {
    pub schema_version: u32,
    pub tool: String,
    pub thresholds: String,
    pub study: String,
    pub verdict: Verdict,
    #[serde(rename = "where")]
    pub places: Vec<Where>,
    pub causes: Vec<Cause>,
    pub gain: BTreeMap<String, ChannelGain>,
    pub next_experiment: Option<NextExperiment>,
    pub not_testable: Vec<NotTestable>,
    /// Smallest size that would be seen, away from null, in the parameter's unit.
    pub detection_limits: BTreeMap<String, BTreeMap<String, f64>>,
    pub extended_plant: Option<String>,
    /// First-round tests on the fit rides.
    pub scores: BTreeMap<String, ScoreLine>,
    pub candidates: Vec<Candidate>,
    /// Fitted calibration parameters of the baseline, by symbol.
    pub calibration: BTreeMap<String, f64>,
    /// Parameters that stand at the end of their declared tolerance.
    pub out_of_tolerance: Vec<String>,
    /// Whether tolerances twice as wide as declared explain the rides as well as causes would.
    pub tolerances_too_small: bool,
    /// Mechanisms that fit best at an end of their range: they stand in for something else, and are
    /// no causes.
    pub refused: Vec<String>,
    /// Outputs that the extended model fails on held-out rides, so that nothing is confirmed.
    pub unpredicted: Vec<String>,
    pub faults: Vec<Fault>,
    pub latent_force: Option<LatentForce>,
    /// What was found, in words; the first is the verdict.
    pub statements: Vec<String>,
    #[serde(skip)]
    pub pictures: super::pictures::Pictures,
    #[serde(skip)]
    pub plant: Option<twinhub_linear::Bicycle>,
}
