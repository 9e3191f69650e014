//! What: air resists.
//!
//! Equation: force -1/2 rho CdA v |v|, rho 1.2 kg/m³.
//!
//! Source: D. G. Wilson, Bicycling Science (2004).
//!
//! Assumes and ignores: no wind.
//!
//! Valid for: small angles.
//!
//! Checked by: the registry's conformance tests.

use crate::card::{Card, Equation, Family, Param, Requirement};
use crate::hooks::Mechanism;
use crate::moment::{Moment, Wrench};

/// See the module.
#[derive(Debug)]
pub struct AerodynamicDrag;

static CARD: Card = Card {
    name: "aerodynamic_drag",
    family: Family::Environment,
    equations: &[Equation::Longitudinal],
    claim: "air resists",
    equation: "force -1/2 rho CdA v |v|, rho 1.2 kg/m³",
    source: "D. G. Wilson, Bicycling Science (2004)",
    parameters: &[Param {
        name: "cda_m2",
        null: 0.0,
        least: 0.0,
        most: 2.0,
        probe: 0.02,
        starts: &[],
        about: "drag area",
    }],
    requires: &[Requirement::PredictedSpeed],
    confounded_with: &["rolling_resistance", "brake_drag"],
    separated_by: "coast down from a high speed: only air drag grows with its square",
};

impl Mechanism for AerodynamicDrag {
    fn card(&self) -> &'static Card {
        &CARD
    }
    fn pushes(&self) -> bool {
        true
    }

    fn wrench(&self, p: &[f64], at: &Moment<'_>, _memory: &[f64]) -> Wrench {
        Wrench {
            force_n: -0.6 * p[0] * at.speed_m_s * at.speed_m_s.abs(),
            ..Wrench::default()
        }
    }
}
