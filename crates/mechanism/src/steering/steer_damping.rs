//! What: the steering is damped.
//!
//! Equation: torque -c steer rate.
//!
//! Source: own, elementary.
//!
//! Assumes and ignores: linear; none in the rest of the model.
//!
//! Valid for: small angles.
//!
//! Checked by: the registry's conformance tests.

use crate::body::Terms;
use crate::card::{Card, Equation, Family, Param};
use crate::hooks::Mechanism;

/// See the module.
#[derive(Debug)]
pub struct SteerDamping;

static CARD: Card = Card {
    name: "steer_damping",
    family: Family::Structure,
    equations: &[Equation::Steer],
    claim: "the steering is damped",
    equation: "torque -c steer rate",
    source: "own, elementary",
    parameters: &[Param {
        name: "nms_rad",
        null: 0.0,
        least: 0.0,
        most: 20.0,
        probe: 0.05,
        starts: &[],
        about: "damping of the steering",
    }],
    requires: &[],
    confounded_with: &["arm_damping", "steer_coulomb_friction"],
    separated_by: "two steering amplitudes, and hands off: a damper acts alike at both amplitudes and without hands",
};

impl Mechanism for SteerDamping {
    fn card(&self) -> &'static Card {
        &CARD
    }
    fn terms(&self, p: &[f64], terms: &mut Terms) {
        terms.damping[0][(1, 1)] += p[0];
    }
}
