//! What: the steer torque sensor reads beside zero.
//!
//! Equation: true steer torque = reading + b.
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
pub struct SteerTorqueBias;

static CARD: Card = Card {
    name: "steer_torque_bias",
    family: Family::Sensor,
    equations: &[Equation::Steer],
    claim: "the steer torque sensor reads beside zero",
    equation: "true steer torque = reading + b",
    source: "own, elementary",
    parameters: &[Param {
        name: "nm",
        null: 0.0,
        least: -10.0,
        most: 10.0,
        probe: 0.05,
        starts: &[],
        about: "true torque at reading zero",
    }],
    requires: &[Requirement::Input(Quantity::SteerTorque)],
    confounded_with: &["lateral_offset", "cross_slope"],
    separated_by: "a static log with no hand on the bar",
};

impl Mechanism for SteerTorqueBias {
    fn card(&self) -> &'static Card {
        &CARD
    }
    fn input(&self, p: &[f64], quantity: Quantity, model: &mut InputModel) {
        if quantity == Quantity::SteerTorque {
            model.offset += p[0];
        }
    }
}
