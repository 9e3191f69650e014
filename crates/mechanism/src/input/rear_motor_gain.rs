//! What: the rear motor drives more or less than commanded.
//!
//! Equation: true torque = gain times command.
//!
//! Source: own, elementary.
//!
//! Assumes and ignores: does not depend on speed or current.
//!
//! Valid for: small angles.
//!
//! Checked by: the registry's conformance tests.

use crate::card::{Card, Equation, Family, Param, Requirement};
use crate::hooks::{InputModel, Mechanism};
use crate::quantity::Quantity;

/// See the module.
#[derive(Debug)]
pub struct RearMotorGain;

static CARD: Card = Card {
    name: "rear_motor_gain",
    family: Family::Actuator,
    equations: &[Equation::WheelRear, Equation::Longitudinal],
    claim: "the rear motor drives more or less than commanded",
    equation: "true torque = gain times command",
    source: "own, elementary",
    parameters: &[Param {
        name: "gain",
        null: 1.0,
        least: 0.2,
        most: 3.0,
        probe: 0.02,
        starts: &[],
        about: "true torque per command",
    }],
    requires: &[Requirement::Input(Quantity::RearTraction)],
    confounded_with: &["front_motor_gain", "wheel_radius"],
    separated_by: "independent torque profiles for the two motors",
};

impl Mechanism for RearMotorGain {
    fn card(&self) -> &'static Card {
        &CARD
    }
    fn input(&self, p: &[f64], quantity: Quantity, model: &mut InputModel) {
        if quantity == Quantity::RearTraction {
            model.gain *= p[0];
        }
    }
}
