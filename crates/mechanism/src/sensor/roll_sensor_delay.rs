//! What: the roll reading is late.
//!
//! Equation: reading(t) = roll(t - delay).
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
pub struct RollSensorDelay;

static CARD: Card = Card {
    name: "roll_sensor_delay",
    family: Family::Sensor,
    equations: &[Equation::Sensor],
    claim: "the roll reading is late",
    equation: "reading(t) = roll(t - delay)",
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
    requires: &[Requirement::Output(Quantity::Roll)],
    confounded_with: &[],
    separated_by: "broad-band roll disturbance",
};

impl Mechanism for RollSensorDelay {
    fn card(&self) -> &'static Card {
        &CARD
    }
    fn sensor(&self, p: &[f64], quantity: Quantity, model: &mut SensorModel) {
        if quantity == Quantity::Roll {
            model.delay_s += p[0];
        }
    }
}
