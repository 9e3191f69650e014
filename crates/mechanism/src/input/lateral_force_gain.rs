//! What: the force sensor of the pulls is scaled wrongly.
//!
//! Equation: true force = gain times reading.
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
pub struct LateralForceGain;

static CARD: Card = Card {
    name: "lateral_force_gain",
    family: Family::Sensor,
    equations: &[Equation::Roll],
    claim: "the force sensor of the pulls is scaled wrongly",
    equation: "true force = gain times reading",
    source: "own, elementary",
    parameters: &[Param {
        name: "gain",
        null: 1.0,
        least: 0.2,
        most: 5.0,
        probe: 0.02,
        starts: &[],
        about: "true force per reading",
    }],
    requires: &[Requirement::Input(Quantity::LateralForce)],
    confounded_with: &["payload"],
    separated_by: "a known weight on the force sensor",
};

impl Mechanism for LateralForceGain {
    fn card(&self) -> &'static Card {
        &CARD
    }
    fn input(&self, p: &[f64], quantity: Quantity, model: &mut InputModel) {
        if quantity == Quantity::LateralForce {
            model.gain *= p[0];
        }
    }
}
