//! What: a steady wind blows from one side.
//!
//! Equation: side force 1/2 rho CyA w sqrt(v² + w²) with CyA = 0.6 m², at 1.0 m height over the
//! middle of the wheelbase; the other way the wind comes from the other side.
//!
//! Source: D. G. Wilson, Bicycling Science (2004), for the order of side areas; 0.6 m² and the
//! point are guesses.
//!
//! Assumes and ignores: a ride keeps its road; no head wind.
//!
//! Valid for: small angles.
//!
//! Checked by: the registry's conformance tests.

use crate::card::{Card, Equation, Family, Param, Requirement};
use crate::hooks::Mechanism;
use crate::moment::{Moment, Wrench};

/// See the module.
#[derive(Debug)]
pub struct Crosswind;

static CARD: Card = Card {
    name: "crosswind",
    family: Family::Environment,
    equations: &[Equation::Roll, Equation::Steer],
    claim: "a steady wind blows from one side",
    equation: "side force 1/2 rho CyA w sqrt(v² + w²) with CyA = 0.6 m², at 1.0 m height over the middle of the wheelbase",
    source: "D. G. Wilson, Bicycling Science (2004), for the order of side areas; 0.6 m² and the point are guesses",
    parameters: &[Param {
        name: "m_s",
        null: 0.0,
        least: -20.0,
        most: 20.0,
        probe: 0.3,
        starts: &[-3.0, 3.0],
        about: "wind to the right of the study's first ride",
    }],
    requires: &[Requirement::Road],
    confounded_with: &["cross_slope", "lateral_offset"],
    separated_by: "the same road out and back: the wind changes sides, an offset load does not",
};

impl Mechanism for Crosswind {
    fn card(&self) -> &'static Card {
        &CARD
    }
    fn pushes(&self) -> bool {
        true
    }

    fn wrench(&self, p: &[f64], at: &Moment<'_>, _memory: &[f64]) -> Wrench {
        const HALF_RHO_AREA: f64 = 0.5 * 1.2 * 0.6;
        let wind_m_s = at.way * p[0];
        let force = HALF_RHO_AREA * wind_m_s * libm::hypot(at.speed_m_s, wind_m_s);
        let arm = at.body.side_force_arm_m(0.5 * at.body.parameters.w, -1.0);
        Wrench {
            roll_nm: arm[0] * force,
            steer_nm: arm[1] * force,
            ..Wrench::default()
        }
    }
}
