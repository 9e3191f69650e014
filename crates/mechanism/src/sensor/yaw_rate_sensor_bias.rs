//! What: the yaw rate sensor reads beside zero.
//!
//! Equation: reading = yaw rate + b.
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
pub struct YawRateSensorBias;

static CARD: Card = Card {
    name: "yaw_rate_sensor_bias",
    family: Family::Sensor,
    equations: &[Equation::Sensor],
    claim: "the yaw rate sensor reads beside zero",
    equation: "reading = yaw rate + b",
    source: "own, elementary",
    parameters: &[Param {
        name: "rad_s",
        null: 0.0,
        least: -0.5,
        most: 0.5,
        probe: 0.002,
        starts: &[],
        about: "offset of the reading",
    }],
    requires: &[Requirement::Output(Quantity::YawRate)],
    confounded_with: &["cross_slope"],
    separated_by: "a static log",
};

impl Mechanism for YawRateSensorBias {
    fn card(&self) -> &'static Card {
        &CARD
    }
    fn sensor(&self, p: &[f64], quantity: Quantity, model: &mut SensorModel) {
        if quantity == Quantity::YawRate {
            model.offset += p[0];
        }
    }
}
