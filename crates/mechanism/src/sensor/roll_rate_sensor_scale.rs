//! What: the roll rate sensor is scaled wrongly.
//!
//! Equation: reading = gain times roll rate.
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
pub struct RollRateSensorScale;

static CARD: Card = Card {
    name: "roll_rate_sensor_scale",
    family: Family::Sensor,
    equations: &[Equation::Sensor],
    claim: "the roll rate sensor is scaled wrongly",
    equation: "reading = gain times roll rate",
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
    requires: &[Requirement::Output(Quantity::RollRate)],
    confounded_with: &[],
    separated_by: "a slow roll of the bicycle by hand through a known angle",
};

impl Mechanism for RollRateSensorScale {
    fn card(&self) -> &'static Card {
        &CARD
    }
    fn sensor(&self, p: &[f64], quantity: Quantity, model: &mut SensorModel) {
        if quantity == Quantity::RollRate {
            model.gain *= p[0];
        }
    }
}
