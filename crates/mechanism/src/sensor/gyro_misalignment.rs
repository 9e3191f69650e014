//! What: the roll-rate gyro is turned towards yaw.
//!
//! Equation: reading = roll rate + angle times yaw rate.
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
pub struct GyroMisalignment;

static CARD: Card = Card {
    name: "gyro_misalignment",
    family: Family::Sensor,
    equations: &[Equation::Sensor],
    claim: "the roll-rate gyro is turned towards yaw",
    equation: "reading = roll rate + angle times yaw rate",
    source: "own, elementary",
    parameters: &[Param {
        name: "rad",
        null: 0.0,
        least: -0.4,
        most: 0.4,
        probe: 0.005,
        starts: &[],
        about: "rotation of the axis towards yaw",
    }],
    requires: &[Requirement::Output(Quantity::RollRate)],
    confounded_with: &["steer_damping"],
    separated_by: "slalom at two speeds",
};

impl Mechanism for GyroMisalignment {
    fn card(&self) -> &'static Card {
        &CARD
    }
    fn sensor(&self, p: &[f64], quantity: Quantity, model: &mut SensorModel) {
        if quantity == Quantity::RollRate {
            model.yaw_share += p[0];
        }
    }
}
