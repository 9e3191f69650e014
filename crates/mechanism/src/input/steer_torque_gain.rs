//! What: the steer torque sensor is scaled wrongly.
//!
//! Equation: true torque = gain times reading.
//!
//! Source: own, elementary.
//!
//! Assumes and ignores: linear.
//!
//! Valid for: small angles.
//!
//! Checked by: the registry's conformance tests.

use crate::card::{Card, Equation, Family, Param, Requirement};
use crate::hooks::{InputModel, Mechanism};
use crate::quantity::Quantity;

/// See the module.
#[derive(Debug)]
pub struct SteerTorqueGain;

static CARD: Card = Card {
    name: "steer_torque_gain",
    family: Family::Sensor,
    equations: &[Equation::Steer],
    claim: "the steer torque sensor is scaled wrongly",
    equation: "true torque = gain times reading",
    source: "own, elementary",
    parameters: &[Param {
        name: "gain",
        null: 1.0,
        least: 0.2,
        most: 5.0,
        probe: 0.02,
        starts: &[],
        about: "true torque per reading",
    }],
    requires: &[Requirement::Input(Quantity::SteerTorque)],
    confounded_with: &["arm_inertia", "arm_damping"],
    separated_by: "a known weight on the bar at standstill",
};

impl Mechanism for SteerTorqueGain {
    fn card(&self) -> &'static Card {
        &CARD
    }
    fn input(&self, p: &[f64], quantity: Quantity, model: &mut InputModel) {
        if quantity == Quantity::SteerTorque {
            model.gain *= p[0];
        }
    }
}
