//! What: the arms move with the bar.
//!
//! Equation: torque -J steer acceleration.
//!
//! Source: J. K. Moore (2012), Human control of a bicycle: model with arms.
//!
//! Assumes and ignores: the inertia acts about the steer axis only.
//!
//! Valid for: small angles.
//!
//! Checked by: the registry's conformance tests.

use crate::body::Terms;
use crate::card::{Card, Equation, Family, Param, Requirement};
use crate::hooks::Mechanism;

/// See the module.
#[derive(Debug)]
pub struct ArmInertia;

static CARD: Card = Card {
    name: "arm_inertia",
    family: Family::Rider,
    equations: &[Equation::Steer],
    claim: "the arms move with the bar",
    equation: "torque -J steer acceleration",
    source: "J. K. Moore (2012), Human control of a bicycle: model with arms",
    parameters: &[Param {
        name: "kg_m2",
        null: 0.0,
        least: 0.0,
        most: 1.5,
        probe: 0.01,
        starts: &[],
        about: "inertia of the arms about the steer axis",
    }],
    requires: &[Requirement::HandsOn],
    confounded_with: &["steer_torque_gain"],
    separated_by: "hands on against hands off, steer torque from 1 to 5 Hz",
};

impl Mechanism for ArmInertia {
    fn card(&self) -> &'static Card {
        &CARD
    }
    fn terms(&self, p: &[f64], terms: &mut Terms) {
        terms.mass[(1, 1)] += p[0];
    }
}
