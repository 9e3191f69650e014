//! What: the yaw rate reading is late.
//!
//! Equation: reading(t) = yaw rate(t - delay).
//!
//! Source: own, elementary.
//!
//! Assumes and ignores: constant over the study.
//!
//! Valid for: small angles.
//!
//! Checked by: the registry's conformance tests.

use crate::card::{Card, Equation, Family, Param, Requirement};
use crate::hooks::{Mechanism, SensorModel};
use crate::quantity::Quantity;

/// See the module.
#[derive(Debug)]
pub struct YawRateSensorDelay;

static CARD: Card = Card {
    name: "yaw_rate_sensor_delay",
    family: Family::Sensor,
    equations: &[Equation::Sensor],
    claim: "the yaw rate reading is late",
    equation: "reading(t) = yaw rate(t - delay)",
    source: "own, elementary",
    parameters: &[Param {
        name: "s",
        null: 0.0,
        least: 0.0,
        most: 0.2,
        probe: 0.004,
        starts: &[0.02, 0.05],
        about: "delay",
    }],
    requires: &[Requirement::Output(Quantity::YawRate)],
    confounded_with: &["tyre_relaxation"],
    separated_by: "steering to 3 Hz at three speeds: a lag of the tyres falls with speed, a sensor's does not",
};

impl Mechanism for YawRateSensorDelay {
    fn card(&self) -> &'static Card {
        &CARD
    }
    fn sensor(&self, p: &[f64], quantity: Quantity, model: &mut SensorModel) {
        if quantity == Quantity::YawRate {
            model.delay_s += p[0];
        }
    }
}
