//! What: rolling costs a constant force.
//!
//! Equation: force -F sign(v).
//!
//! Source: own, elementary.
//!
//! Assumes and ignores: does not depend on speed or load transfer.
//!
//! Valid for: small angles.
//!
//! Checked by: the registry's conformance tests.

use crate::card::{Card, Equation, Family, Param, Requirement};
use crate::hooks::Mechanism;
use crate::moment::{Moment, Wrench};

/// See the module.
#[derive(Debug)]
pub struct RollingResistance;

static CARD: Card = Card {
    name: "rolling_resistance",
    family: Family::Tyre,
    equations: &[Equation::Longitudinal],
    claim: "rolling costs a constant force",
    equation: "force -F sign(v)",
    source: "own, elementary",
    parameters: &[Param {
        name: "n",
        null: 0.0,
        least: 0.0,
        most: 60.0,
        probe: 0.2,
        starts: &[],
        about: "resistance of both wheels",
    }],
    requires: &[Requirement::PredictedSpeed],
    confounded_with: &["longitudinal_slope", "brake_drag", "motor_drag"],
    separated_by: "coast down on the same road out and back",
};

impl Mechanism for RollingResistance {
    fn card(&self) -> &'static Card {
        &CARD
    }
    fn pushes(&self) -> bool {
        true
    }

    fn wrench(&self, p: &[f64], at: &Moment<'_>, _memory: &[f64]) -> Wrench {
        Wrench {
            force_n: -p[0] * at.speed_m_s.signum(),
            ..Wrench::default()
        }
    }
}
