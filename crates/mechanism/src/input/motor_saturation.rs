//! What: the motors cannot give what is commanded.
//!
//! Equation: true torque within +-limit.
//!
//! Source: own, elementary.
//!
//! Assumes and ignores: both motors alike; hard limit.
//!
//! Valid for: small angles.
//!
//! Checked by: the registry's conformance tests.

use crate::card::{Card, Equation, Family, Param, Requirement};
use crate::hooks::{InputModel, Mechanism};
use crate::quantity::Quantity;
use twinhub_linear::Parameters;

/// See the module.
#[derive(Debug)]
pub struct MotorSaturation;

static CARD: Card = Card {
    name: "motor_saturation",
    family: Family::Actuator,
    equations: &[Equation::Longitudinal],
    claim: "the motors cannot give what is commanded",
    equation: "true torque within +-limit",
    source: "own, elementary",
    parameters: &[Param {
        name: "limit_nm",
        null: 200.0,
        least: 1.0,
        most: 200.0,
        probe: -190.0,
        starts: &[30.0, 20.0, 15.0, 10.0, 7.0, 5.0],
        about: "largest torque",
    }],
    requires: &[Requirement::Input(Quantity::RearTraction)],
    confounded_with: &["rear_motor_gain", "front_motor_gain"],
    separated_by: "commands of two heights: a gain acts on both, a limit on the higher one",
};

impl Mechanism for MotorSaturation {
    fn card(&self) -> &'static Card {
        &CARD
    }
    fn from_probes(&self, c: &[f64], _bicycle: &Parameters) -> Vec<f64> {
        // The probe is a hard limit; how hard the true one is comes from the grid.
        vec![if c[0] > 0.0 { 12.0 } else { 200.0 }]
    }

    fn input(&self, p: &[f64], quantity: Quantity, model: &mut InputModel) {
        if matches!(quantity, Quantity::FrontBrake | Quantity::RearTraction) {
            model.limit = model.limit.min(p[0]);
        }
    }
}
