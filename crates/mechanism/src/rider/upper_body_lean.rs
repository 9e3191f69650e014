//! What: the rider leans the trunk against the bicycle.
//!
//! Equation: roll torque m g h/2 times lean, with the trunk's m h as parameter.
//!
//! Source: Sharp (2008) and others treat the trunk as an inverted pendulum; static part only,
//! own.
//!
//! Assumes and ignores: the trunk's inertia torque is left out: below about 0.5 Hz.
//!
//! Valid for: small angles.
//!
//! Checked by: the registry's conformance tests.

use crate::card::{Card, Equation, Family, Param, Requirement};
use crate::hooks::Mechanism;
use crate::moment::{Moment, Wrench};
use crate::quantity::Quantity;

/// See the module.
#[derive(Debug)]
pub struct UpperBodyLean;

static CARD: Card = Card {
    name: "upper_body_lean",
    family: Family::Rider,
    equations: &[Equation::Roll],
    claim: "the rider leans the trunk against the bicycle",
    equation: "roll torque m g h/2 times lean, with the trunk's m h as parameter",
    source: "Sharp (2008) and others treat the trunk as an inverted pendulum; static part only, own",
    parameters: &[Param {
        name: "nm_rad",
        null: 0.0,
        least: -600.0,
        most: 600.0,
        probe: 5.0,
        starts: &[],
        about: "roll torque per lean angle of the trunk",
    }],
    requires: &[Requirement::Channel(Quantity::TrunkLean)],
    confounded_with: &["payload"],
    separated_by: "harness against free trunk, with the trunk measured",
};

impl Mechanism for UpperBodyLean {
    fn card(&self) -> &'static Card {
        &CARD
    }
    fn pushes(&self) -> bool {
        true
    }

    fn wrench(&self, p: &[f64], at: &Moment<'_>, _memory: &[f64]) -> Wrench {
        Wrench {
            roll_nm: p[0] * at.trunk_lean_rad.unwrap_or(0.0),
            ..Wrench::default()
        }
    }
}
