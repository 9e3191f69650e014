//! What: the load stands beside the middle plane.
//!
//! Equation: roll torque g times mass times offset to the right.
//!
//! Source: own, elementary.
//!
//! Assumes and ignores: constant over the study; its part in the steer equation is left out.
//!
//! Valid for: small angles.
//!
//! Checked by: the registry's conformance tests.

use crate::card::{Card, Equation, Family, Param};
use crate::hooks::Mechanism;
use crate::moment::{Moment, Wrench};

/// See the module.
#[derive(Debug)]
pub struct LateralOffset;

static CARD: Card = Card {
    name: "lateral_offset",
    family: Family::Structure,
    equations: &[Equation::Roll],
    claim: "the load stands beside the middle plane",
    equation: "roll torque g times mass times offset to the right",
    source: "own, elementary",
    parameters: &[Param {
        name: "kg_m",
        null: 0.0,
        least: -20.0,
        most: 20.0,
        probe: 0.02,
        starts: &[],
        about: "mass times offset, positive to the right",
    }],
    requires: &[],
    confounded_with: &["cross_slope", "roll_sensor_bias", "crosswind"],
    separated_by: "the same road out and back: the slope changes sides, the load does not",
};

impl Mechanism for LateralOffset {
    fn card(&self) -> &'static Card {
        &CARD
    }
    fn pushes(&self) -> bool {
        true
    }

    fn wrench(&self, p: &[f64], at: &Moment<'_>, _memory: &[f64]) -> Wrench {
        Wrench {
            roll_nm: p[0] * at.body.gravity_m_s2,
            ..Wrench::default()
        }
    }
}
