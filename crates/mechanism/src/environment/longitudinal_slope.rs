//! What: the road climbs.
//!
//! Equation: force -m g sin(slope).
//!
//! Source: own, elementary.
//!
//! Assumes and ignores: constant over the study.
//!
//! Valid for: small angles.
//!
//! Checked by: the registry's conformance tests.

use crate::card::{Card, Equation, Family, Param, Requirement};
use crate::hooks::Mechanism;
use crate::moment::{Moment, Wrench};

/// See the module.
#[derive(Debug)]
pub struct LongitudinalSlope;

static CARD: Card = Card {
    name: "longitudinal_slope",
    family: Family::Environment,
    equations: &[Equation::Longitudinal],
    claim: "the road climbs",
    equation: "force -m g sin(slope)",
    source: "own, elementary",
    parameters: &[Param {
        name: "rad",
        null: 0.0,
        least: -0.2,
        most: 0.2,
        probe: 0.001,
        starts: &[],
        about: "climb of the study's first ride, positive uphill",
    }],
    requires: &[Requirement::PredictedSpeed],
    confounded_with: &["rolling_resistance", "brake_drag"],
    separated_by: "the same road out and back",
};

impl Mechanism for LongitudinalSlope {
    fn card(&self) -> &'static Card {
        &CARD
    }
    fn pushes(&self) -> bool {
        true
    }

    fn wrench(&self, p: &[f64], at: &Moment<'_>, _memory: &[f64]) -> Wrench {
        let gravity_n = -at.body.mass_kg * at.body.gravity_m_s2 * libm::sin(at.way * p[0]);
        Wrench {
            force_n: gravity_n,
            gravity_n,
            ..Wrench::default()
        }
    }
}
