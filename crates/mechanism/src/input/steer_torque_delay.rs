//! What: the steer torque reading is late.
//!
//! Equation: true steer torque(t) = reading(t + delay).
//!
//! Source: own, elementary.
//!
//! Assumes and ignores: constant over the study.
//!
//! Valid for: small angles.
//!
//! Checked by: the registry's conformance tests.

use crate::card::{Card, Equation, Family, Param, Requirement};
use crate::hooks::{InputModel, Mechanism};
use crate::quantity::Quantity;

/// See the module.
#[derive(Debug)]
pub struct SteerTorqueDelay;

static CARD: Card = Card {
    name: "steer_torque_delay",
    family: Family::Sensor,
    equations: &[Equation::Steer],
    claim: "the steer torque reading is late",
    equation: "true steer torque(t) = reading(t + delay)",
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
    requires: &[Requirement::Input(Quantity::SteerTorque)],
    confounded_with: &["steer_damping", "tyre_relaxation"],
    separated_by: "a blow on the bar at standstill against the steer sensor",
};

impl Mechanism for SteerTorqueDelay {
    fn card(&self) -> &'static Card {
        &CARD
    }
    fn input(&self, p: &[f64], quantity: Quantity, model: &mut InputModel) {
        if quantity == Quantity::SteerTorque {
            model.delay_s -= p[0];
        }
    }
}
