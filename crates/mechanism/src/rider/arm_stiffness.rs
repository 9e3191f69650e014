//! What: the arms hold the bar like a spring.
//!
//! Equation: torque -k steer.
//!
//! Source: J. K. Moore (2012), Human control of a bicycle: arms as the first suspect; linear
//! spring own.
//!
//! Assumes and ignores: the trunk does not move.
//!
//! Valid for: small angles.
//!
//! Checked by: the registry's conformance tests.

use crate::body::Terms;
use crate::card::{Card, Equation, Family, Param, Requirement};
use crate::hooks::Mechanism;

/// See the module.
#[derive(Debug)]
pub struct ArmStiffness;

static CARD: Card = Card {
    name: "arm_stiffness",
    family: Family::Rider,
    equations: &[Equation::Steer],
    claim: "the arms hold the bar like a spring",
    equation: "torque -k steer",
    source: "J. K. Moore (2012), Human control of a bicycle: arms as the first suspect; linear spring own",
    parameters: &[Param {
        name: "nm_rad",
        null: 0.0,
        least: 0.0,
        most: 200.0,
        probe: 0.5,
        starts: &[],
        about: "stiffness of the arms about the steer axis",
    }],
    requires: &[Requirement::HandsOn],
    confounded_with: &["twisting_torque"],
    separated_by: "hands on against hands off at one speed",
};

impl Mechanism for ArmStiffness {
    fn card(&self) -> &'static Card {
        &CARD
    }
    fn terms(&self, p: &[f64], terms: &mut Terms) {
        terms.stiffness[0][(1, 1)] += p[0];
    }
}
