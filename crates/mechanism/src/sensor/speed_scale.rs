//! What: the speedometer is scaled wrongly.
//!
//! Equation: reading = gain times speed; where the speed is prescribed, true speed =
//! reading/gain.
//!
//! Source: own, elementary.
//!
//! Assumes and ignores: linear.
//!
//! Valid for: small angles.
//!
//! Checked by: the registry's conformance tests.

use crate::card::{Card, Equation, Family, Param, Requirement};
use crate::hooks::{InputModel, Mechanism, SensorModel};
use crate::quantity::Quantity;

/// See the module.
#[derive(Debug)]
pub struct SpeedScale;

static CARD: Card = Card {
    name: "speed_scale",
    family: Family::Sensor,
    equations: &[Equation::Sensor],
    claim: "the speedometer is scaled wrongly",
    equation: "reading = gain times speed; where the speed is prescribed, true speed = reading/gain",
    source: "own, elementary",
    parameters: &[Param {
        name: "gain",
        null: 1.0,
        least: 0.5,
        most: 2.0,
        probe: 0.01,
        starts: &[],
        about: "reading per truth",
    }],
    requires: &[Requirement::SpeedRange(1.15)],
    confounded_with: &["wheel_radius", "cornering_stiffness"],
    separated_by: "a measured distance, ridden straight",
};

impl Mechanism for SpeedScale {
    fn card(&self) -> &'static Card {
        &CARD
    }
    fn sensor(&self, p: &[f64], quantity: Quantity, model: &mut SensorModel) {
        if quantity == Quantity::Speed {
            model.gain *= p[0];
        }
    }

    fn input(&self, p: &[f64], quantity: Quantity, model: &mut InputModel) {
        if quantity == Quantity::Speed {
            model.gain /= p[0];
        }
    }
}
