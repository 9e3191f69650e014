//! What: the steer sensor stands askew.
//!
//! Equation: reading = steer + b.
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
pub struct SteerSensorBias;

static CARD: Card = Card {
    name: "steer_sensor_bias",
    family: Family::Sensor,
    equations: &[Equation::Sensor],
    claim: "the steer sensor stands askew",
    equation: "reading = steer + b",
    source: "own, elementary",
    parameters: &[Param {
        name: "rad",
        null: 0.0,
        least: -0.3,
        most: 0.3,
        probe: 0.002,
        starts: &[],
        about: "offset of the reading",
    }],
    requires: &[Requirement::Output(Quantity::Steer)],
    confounded_with: &["cross_slope"],
    separated_by: "a static log with the wheel straight",
};

impl Mechanism for SteerSensorBias {
    fn card(&self) -> &'static Card {
        &CARD
    }
    fn sensor(&self, p: &[f64], quantity: Quantity, model: &mut SensorModel) {
        if quantity == Quantity::Steer {
            model.offset += p[0];
        }
    }
}
