//! What: the roll sensor stands askew.
//!
//! Equation: reading = roll + b.
//!
//! Source: own, elementary.
//!
//! Assumes and ignores: constant over the study.
//!
//! Valid for: small angles.
//!
//! Checked by: the registry's conformance tests.

use crate::card::{Card, Equation, Family, Param, Requirement};
use crate::hooks::{Mechanism, SensorModel};
use crate::quantity::Quantity;

/// See the module.
#[derive(Debug)]
pub struct RollSensorBias;

static CARD: Card = Card {
    name: "roll_sensor_bias",
    family: Family::Sensor,
    equations: &[Equation::Sensor],
    claim: "the roll sensor stands askew",
    equation: "reading = roll + b",
    source: "own, elementary",
    parameters: &[Param {
        name: "rad",
        null: 0.0,
        least: -0.3,
        most: 0.3,
        probe: 0.002,
        starts: &[],
        about: "offset of the reading",
    }],
    requires: &[Requirement::Output(Quantity::Roll)],
    confounded_with: &["cross_slope", "lateral_offset"],
    separated_by: "a static log of the bicycle held upright",
};

impl Mechanism for RollSensorBias {
    fn card(&self) -> &'static Card {
        &CARD
    }
    fn sensor(&self, p: &[f64], quantity: Quantity, model: &mut SensorModel) {
        if quantity == Quantity::Roll {
            model.offset += p[0];
        }
    }
}
