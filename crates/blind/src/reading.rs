//! What the suite reads of a diagnosis: its public JSON, nothing else.

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// The answer of a diagnosis.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Reading {
    pub verdict: String,
    #[serde(rename = "where", default)]
    pub places: Vec<Located>,
    #[serde(default)]
    pub causes: Vec<Cause>,
    #[serde(default)]
    pub next_experiment: Option<NextExperiment>,
    #[serde(default)]
    pub not_testable: Vec<NotTestable>,
    #[serde(default)]
    pub detection_limits: BTreeMap<String, BTreeMap<String, f64>>,
    /// First-round p-value of each mechanism.
    #[serde(default)]
    pub scores: BTreeMap<String, Score>,
}

/// Multiple of the rate of a part that turns.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Order {
    pub of: String,
    pub n: u32,
}

#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Located {
    pub equation: String,
    #[serde(default)]
    pub band_hz: Option<[f64; 2]>,
    #[serde(default)]
    pub order: Option<Order>,
}

#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Cause {
    pub mechanism: String,
    #[serde(default)]
    pub confirmed: bool,
    #[serde(default)]
    pub parameters: BTreeMap<String, Estimate>,
    #[serde(default)]
    pub set: Vec<String>,
    #[serde(default)]
    pub held_out_gain_nats: Option<f64>,
}

#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Estimate {
    pub value: f64,
    #[serde(default)]
    pub ci95: Option<[f64; 2]>,
}

#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct NextExperiment {
    #[serde(default)]
    pub what: String,
    #[serde(default)]
    pub separates: Vec<String>,
}

#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct NotTestable {
    pub mechanism: String,
    #[serde(default)]
    pub why: String,
}

#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Score {
    #[serde(default)]
    pub p_value: Option<f64>,
}

impl Reading {
    /// Whether it says that something is wrong with the model or the data.
    pub fn detects(&self) -> bool {
        !matches!(self.verdict.as_str(), "no_effect" | "not_testable")
    }

    /// Whether it names a cause, provisionally or confirmed.
    pub fn names_a_cause(&self) -> bool {
        matches!(self.verdict.as_str(), "cause" | "causes" | "partial") && !self.causes.is_empty()
    }

    /// Whether a set of causes holds this one.
    pub fn covers(&self, mechanism: &str) -> bool {
        self.causes.iter().any(|c| c.holds(mechanism))
    }

    /// Gain on held-out data of all causes together.
    pub fn gain_nats(&self) -> f64 {
        self.causes
            .iter()
            .filter_map(|c| c.held_out_gain_nats)
            .sum()
    }

    /// Smallest size of a mechanism that could be seen, in its parameter.
    pub fn limit(&self, mechanism: &str, parameter: &str) -> Option<f64> {
        let limits = self.detection_limits.get(mechanism)?;
        let value = limits.get(parameter).or_else(|| limits.values().next())?;
        (value.is_finite() && *value != 0.0).then(|| value.abs())
    }
}

impl Cause {
    pub fn holds(&self, mechanism: &str) -> bool {
        self.mechanism == mechanism || self.set.iter().any(|m| m == mechanism)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The example of an answer, as the interface is published.
    #[test]
    fn the_published_example_is_read() {
        let text = r#"{"schema_version": 1, "verdict": "cause",
            "where": [{"equation": "steer", "band_hz": [0.5, 1.0], "order": null, "p_value": 1e-9}],
            "causes": [{"mechanism": "steer_coulomb_friction", "confirmed": true,
              "parameters": {"torque_nm": {"value": 0.31, "ci95": [0.27, 0.36]}},
              "set": ["steer_coulomb_friction"], "held_out_gain_nats": 41.2}],
            "next_experiment": {"what": "two steering amplitudes at one speed", "separates": ["steer_coulomb_friction", "steer_damping"]},
            "not_testable": [{"mechanism": "front_motor_lag", "why": "no front motor torque in any ride"}],
            "detection_limits": {"steer_coulomb_friction": {"torque_nm": 0.06}}}"#;
        let found: Reading = serde_json::from_str(text).unwrap();
        assert!(found.detects() && found.names_a_cause() && found.covers("steer_coulomb_friction"));
        assert_eq!(
            found.limit("steer_coulomb_friction", "torque_nm"),
            Some(0.06)
        );
        assert_eq!(found.limit("front_motor_lag", "time_constant_s"), None);
        assert_eq!(found.gain_nats(), 41.2);
    }
}
