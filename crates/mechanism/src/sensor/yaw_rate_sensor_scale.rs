//! What: the yaw rate sensor is scaled wrongly.
//!
//! Equation: reading = gain times yaw rate.
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
pub struct YawRateSensorScale;

static CARD: Card = Card {
    name: "yaw_rate_sensor_scale",
    family: Family::Sensor,
    equations: &[Equation::Sensor],
    claim: "the yaw rate sensor is scaled wrongly",
    equation: "reading = gain times yaw rate",
    source: "own, elementary",
    parameters: &[Param {
        name: "gain",
        null: 1.0,
        least: 0.3,
        most: 3.0,
        probe: 0.01,
        starts: &[],
        about: "reading per truth",
    }],
    requires: &[Requirement::Output(Quantity::YawRate)],
    confounded_with: &["cornering_stiffness", "speed_scale"],
    separated_by: "a full turn of the bicycle by hand",
};

impl Mechanism for YawRateSensorScale {
    fn card(&self) -> &'static Card {
        &CARD
    }
    fn sensor(&self, p: &[f64], quantity: Quantity, model: &mut SensorModel) {
        if quantity == Quantity::YawRate {
            model.gain *= p[0];
        }
    }
}
