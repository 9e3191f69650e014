//! What: the rear wheel is not as large as the file says.
//!
//! Equation: rR: wheel rate v/rR, force T/rR.
//!
//! Source: rolling.
//!
//! Assumes and ignores: no slip.
//!
//! Valid for: small angles.
//!
//! Checked by: the registry's conformance tests.

use crate::card::{Card, Equation, Family, Param, Requirement};
use crate::hooks::Mechanism;
use crate::quantity::Quantity;
use twinhub_linear::Parameters;

/// See the module.
#[derive(Debug)]
pub struct WheelRadius;

static CARD: Card = Card {
    name: "wheel_radius",
    family: Family::Structure,
    equations: &[Equation::WheelRear, Equation::Longitudinal],
    claim: "the rear wheel is not as large as the file says",
    equation: "rR: wheel rate v/rR, force T/rR",
    source: "rolling",
    parameters: &[Param {
        name: "m",
        null: f64::NAN,
        least: 0.1,
        most: 0.6,
        probe: 0.003,
        starts: &[],
        about: "rolling radius of the rear wheel",
    }],
    requires: &[
        Requirement::PredictedSpeed,
        Requirement::Output(Quantity::RearWheelRate),
    ],
    confounded_with: &["speed_scale", "rear_motor_gain"],
    separated_by: "a measured distance, ridden straight",
};

impl Mechanism for WheelRadius {
    fn card(&self) -> &'static Card {
        &CARD
    }
    fn null(&self, bicycle: &Parameters) -> Vec<f64> {
        vec![bicycle.rR]
    }

    fn reshape(&self, p: &[f64], b: &mut Parameters) {
        b.rR = p[0];
    }
}
