//! What: the speedometer reads in steps.
//!
//! Equation: reading rounded to a multiple of the step.
//!
//! Source: own, elementary.
//!
//! Assumes and ignores: the rounding counts as white noise of step²/12.
//!
//! Valid for: small angles.
//!
//! Checked by: the registry's conformance tests.

use crate::card::{Card, Equation, Family, Param, Requirement};
use crate::hooks::{Mechanism, SensorModel};
use crate::quantity::Quantity;

/// See the module.
#[derive(Debug)]
pub struct SpeedQuantisation;

static CARD: Card = Card {
    name: "speed_quantisation",
    family: Family::Sensor,
    equations: &[Equation::Sensor],
    claim: "the speedometer reads in steps",
    equation: "reading rounded to a multiple of the step",
    source: "own, elementary",
    parameters: &[Param {
        name: "m_s",
        null: 0.0,
        least: 0.0,
        most: 0.5,
        probe: 0.02,
        starts: &[0.05],
        about: "step of the reading",
    }],
    requires: &[
        Requirement::PredictedSpeed,
        Requirement::Output(Quantity::Speed),
    ],
    confounded_with: &[],
    separated_by: "a slow sweep of the speed",
};

impl Mechanism for SpeedQuantisation {
    fn card(&self) -> &'static Card {
        &CARD
    }
    fn sensor(&self, p: &[f64], quantity: Quantity, model: &mut SensorModel) {
        if quantity == Quantity::Speed {
            model.quantum += p[0];
        }
    }
}
