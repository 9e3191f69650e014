//! What: the front motor follows its command late.
//!
//! Equation: tau T' + T = command.
//!
//! Source: own, elementary.
//!
//! Assumes and ignores: first order.
//!
//! Valid for: small angles.
//!
//! Checked by: the registry's conformance tests.

use crate::card::{Card, Equation, Family, Param, Requirement};
use crate::hooks::{InputModel, Mechanism};
use crate::quantity::Quantity;

/// See the module.
#[derive(Debug)]
pub struct FrontMotorLag;

static CARD: Card = Card {
    name: "front_motor_lag",
    family: Family::Actuator,
    equations: &[
        Equation::WheelFront,
        Equation::Longitudinal,
        Equation::Steer,
    ],
    claim: "the front motor follows its command late",
    equation: "tau T' + T = command",
    source: "own, elementary",
    parameters: &[Param {
        name: "time_constant_s",
        null: 0.0,
        least: 0.0,
        most: 0.6,
        probe: 0.01,
        starts: &[0.03, 0.1],
        about: "time constant",
    }],
    requires: &[Requirement::Input(Quantity::FrontBrake)],
    confounded_with: &["rear_motor_lag"],
    separated_by: "independent torque profiles for the two motors, with edges",
};

impl Mechanism for FrontMotorLag {
    fn card(&self) -> &'static Card {
        &CARD
    }
    fn input(&self, p: &[f64], quantity: Quantity, model: &mut InputModel) {
        if quantity == Quantity::FrontBrake {
            model.lag_s += p[0];
        }
    }
}
