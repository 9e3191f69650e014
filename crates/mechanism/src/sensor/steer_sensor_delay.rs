//! What: the steer reading is late.
//!
//! Equation: reading(t) = steer(t - delay).
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
pub struct SteerSensorDelay;

static CARD: Card = Card {
    name: "steer_sensor_delay",
    family: Family::Sensor,
    equations: &[Equation::Sensor],
    claim: "the steer reading is late",
    equation: "reading(t) = steer(t - delay)",
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
    requires: &[Requirement::Output(Quantity::Steer)],
    confounded_with: &["tyre_relaxation"],
    separated_by: "steering to 3 Hz at three speeds: a sensor delay does not fall with speed",
};

impl Mechanism for SteerSensorDelay {
    fn card(&self) -> &'static Card {
        &CARD
    }
    fn sensor(&self, p: &[f64], quantity: Quantity, model: &mut SensorModel) {
        if quantity == Quantity::Steer {
            model.delay_s += p[0];
        }
    }
}
