//! What: the known feedback acts late.
//!
//! Equation: law torque(t) from the state at t - delay.
//!
//! Source: own, elementary.
//!
//! Assumes and ignores: only where the study declares a law.
//!
//! Valid for: small angles.
//!
//! Checked by: the registry's conformance tests.

use crate::card::{Card, Equation, Family, Param, Requirement};
use crate::hooks::Mechanism;

/// See the module.
#[derive(Debug)]
pub struct RiderDelay;

static CARD: Card = Card {
    name: "rider_delay",
    family: Family::Rider,
    equations: &[Equation::Rider],
    claim: "the known feedback acts late",
    equation: "law torque(t) from the state at t - delay",
    source: "own, elementary",
    parameters: &[Param {
        name: "s",
        null: 0.0,
        least: 0.0,
        most: 0.4,
        probe: 0.01,
        starts: &[0.05, 0.15],
        about: "delay of the law",
    }],
    requires: &[Requirement::Law],
    confounded_with: &["roll_rate_sensor_delay"],
    separated_by: "disturbances to 3 Hz",
};

impl Mechanism for RiderDelay {
    fn card(&self) -> &'static Card {
        &CARD
    }
    fn law_delay_s(&self, p: &[f64]) -> f64 {
        p[0]
    }
}
