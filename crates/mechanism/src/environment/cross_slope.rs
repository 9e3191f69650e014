//! What: the road falls to one side.
//!
//! Equation: gravity leans by the slope: torque -g K0 (slope, 0); the other way the road falls to the
//! other side.
//!
//! Source: Meijaard, Papadopoulos, Ruina and Schwab (2007), equations (4.1)-(4.6).
//!
//! Assumes and ignores: constant over the study; roll is measured against the road.
//!
//! Valid for: small angles.
//!
//! Checked by: the registry's conformance tests.

use crate::card::{Card, Equation, Family, Param};
use crate::hooks::Mechanism;
use crate::moment::{Moment, Wrench};

/// See the module.
#[derive(Debug)]
pub struct CrossSlope;

static CARD: Card = Card {
    name: "cross_slope",
    family: Family::Environment,
    equations: &[Equation::Roll, Equation::Steer],
    claim: "the road falls to one side",
    equation: "gravity leans by the slope: torque -g K0 (slope, 0)",
    source: "Meijaard, Papadopoulos, Ruina and Schwab (2007), equations (4.1)-(4.6)",
    parameters: &[Param {
        name: "rad",
        null: 0.0,
        least: -0.2,
        most: 0.2,
        probe: 0.002,
        starts: &[],
        about: "fall to the right of the study's first ride",
    }],
    requires: &[],
    confounded_with: &["lateral_offset", "roll_sensor_bias", "crosswind"],
    separated_by: "the same road out and back: the slope changes sides, an offset load does not",
};

impl Mechanism for CrossSlope {
    fn card(&self) -> &'static Card {
        &CARD
    }
    fn pushes(&self) -> bool {
        true
    }

    fn wrench(&self, p: &[f64], at: &Moment<'_>, _memory: &[f64]) -> Wrench {
        let k0 = at.body.terms.stiffness[0];
        let slope_rad = at.way * p[0];
        Wrench {
            roll_nm: -k0[(0, 0)] * slope_rad,
            steer_nm: -k0[(1, 0)] * slope_rad,
            ..Wrench::default()
        }
    }
}
