//! What: the arms damp the bar.
//!
//! Equation: torque -c steer rate.
//!
//! Source: J. K. Moore (2012), Human control of a bicycle; linear damper own.
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
pub struct ArmDamping;

static CARD: Card = Card {
    name: "arm_damping",
    family: Family::Rider,
    equations: &[Equation::Steer],
    claim: "the arms damp the bar",
    equation: "torque -c steer rate",
    source: "J. K. Moore (2012), Human control of a bicycle; linear damper own",
    parameters: &[Param {
        name: "nms_rad",
        null: 0.0,
        least: 0.0,
        most: 20.0,
        probe: 0.05,
        starts: &[],
        about: "damping of the arms about the steer axis",
    }],
    requires: &[Requirement::HandsOn],
    confounded_with: &["steer_damping", "steer_coulomb_friction"],
    separated_by: "hands on against hands off at one speed",
};

impl Mechanism for ArmDamping {
    fn card(&self) -> &'static Card {
        &CARD
    }
    fn terms(&self, p: &[f64], terms: &mut Terms) {
        terms.damping[0][(1, 1)] += p[0];
    }
}
