//! What: the steer sensor is scaled wrongly.
//!
//! Equation: reading = gain times steer.
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
pub struct SteerSensorScale;

static CARD: Card = Card {
    name: "steer_sensor_scale",
    family: Family::Sensor,
    equations: &[Equation::Sensor],
    claim: "the steer sensor is scaled wrongly",
    equation: "reading = gain times steer",
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
    requires: &[Requirement::Output(Quantity::Steer)],
    confounded_with: &["cornering_stiffness"],
    separated_by: "a protractor at standstill; several speeds",
};

impl Mechanism for SteerSensorScale {
    fn card(&self) -> &'static Card {
        &CARD
    }
    fn sensor(&self, p: &[f64], quantity: Quantity, model: &mut SensorModel) {
        if quantity == Quantity::Steer {
            model.gain *= p[0];
        }
    }
}
