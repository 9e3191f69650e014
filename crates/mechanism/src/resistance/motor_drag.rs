//! What: a motor without current drags.
//!
//! Equation: while a motor's torque is zero it brakes its wheel with T.
//!
//! Source: own: iron losses and gears of a hub motor.
//!
//! Assumes and ignores: constant; both motors alike.
//!
//! Valid for: small angles.
//!
//! Checked by: the registry's conformance tests.

use crate::card::{Card, Equation, Family, Param, Requirement};
use crate::hooks::{InputModel, Mechanism};
use crate::quantity::Quantity;

/// See the module.
#[derive(Debug)]
pub struct MotorDrag;

static CARD: Card = Card {
    name: "motor_drag",
    family: Family::Actuator,
    equations: &[Equation::Longitudinal],
    claim: "a motor without current drags",
    equation: "while a motor's torque is zero it brakes its wheel with T",
    source: "own: iron losses and gears of a hub motor",
    parameters: &[Param {
        name: "nm",
        null: 0.0,
        least: 0.0,
        most: 10.0,
        probe: 0.05,
        starts: &[],
        about: "drag of each unpowered motor",
    }],
    requires: &[
        Requirement::PredictedSpeed,
        Requirement::Input(Quantity::RearTraction),
    ],
    confounded_with: &["rolling_resistance", "brake_drag"],
    separated_by: "coast downs with the motors on at zero current and off",
};

impl Mechanism for MotorDrag {
    fn card(&self) -> &'static Card {
        &CARD
    }
    fn input(&self, p: &[f64], quantity: Quantity, model: &mut InputModel) {
        match quantity {
            Quantity::FrontBrake => model.idle_drag += p[0],
            Quantity::RearTraction => model.idle_drag -= p[0],
            _ => {}
        }
    }
}
