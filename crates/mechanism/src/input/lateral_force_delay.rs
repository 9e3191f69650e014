//! What: the side force reading is late.
//!
//! Equation: true side force(t) = reading(t + delay).
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
pub struct LateralForceDelay;

static CARD: Card = Card {
    name: "lateral_force_delay",
    family: Family::Sensor,
    equations: &[Equation::Roll],
    claim: "the side force reading is late",
    equation: "true side force(t) = reading(t + delay)",
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
    requires: &[Requirement::Input(Quantity::LateralForce)],
    confounded_with: &[],
    separated_by: "a blow beside the force sensor against an accelerometer",
};

impl Mechanism for LateralForceDelay {
    fn card(&self) -> &'static Card {
        &CARD
    }
    fn input(&self, p: &[f64], quantity: Quantity, model: &mut InputModel) {
        if quantity == Quantity::LateralForce {
            model.delay_s -= p[0];
        }
    }
}
