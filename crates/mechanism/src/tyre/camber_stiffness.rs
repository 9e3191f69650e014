//! What: a cambered tyre pushes sideways and so slips less.
//!
//! Equation: side force k camber at each wheel is borne by the tyre itself: side slip falls by
//! camber force times the tyre's compliance of 1/(15 N per N load and rad).
//!
//! Source: J. P. Meijaard and A. L. Schwab (2006), Linearized equations for an extended bicycle
//! model, for camber thrust; compliance 1/15 is typical of bicycle tyres, a guess.
//!
//! Assumes and ignores: one stiffness for both wheels; without slip a camber force is borne by
//! the constraint and nothing is seen.
//!
//! Valid for: small angles.
//!
//! Checked by: the registry's conformance tests.

use crate::card::{Card, Equation, Family, Param, Requirement};
use crate::hooks::Mechanism;
use crate::moment::{Moment, Wrench};

/// See the module.
#[derive(Debug)]
pub struct CamberStiffness;

static CARD: Card = Card {
    name: "camber_stiffness",
    family: Family::Tyre,
    equations: &[Equation::Roll, Equation::Lateral],
    claim: "a cambered tyre pushes sideways and so slips less",
    equation: "side force k camber at each wheel is borne by the tyre itself: side slip falls by camber force times the tyre's compliance of 1/(15 N per N load and rad)",
    source: "J. P. Meijaard and A. L. Schwab (2006), Linearized equations for an extended bicycle model, for camber thrust; compliance 1/15 is typical of bicycle tyres, a guess",
    parameters: &[Param {
        name: "n_rad",
        null: 0.0,
        least: 0.0,
        most: 4000.0,
        probe: 50.0,
        starts: &[300.0, 1000.0],
        about: "side force per camber angle, each wheel",
    }],
    requires: &[Requirement::SpeedRange(1.15)],
    confounded_with: &["cornering_stiffness", "roll_sensor_bias"],
    separated_by: "steady circles at several speeds with lean measured against the road",
};

impl Mechanism for CamberStiffness {
    fn card(&self) -> &'static Card {
        &CARD
    }
    fn pushes(&self) -> bool {
        true
    }

    fn feeds_back(&self) -> bool {
        true
    }

    fn wrench(&self, p: &[f64], at: &Moment<'_>, _memory: &[f64]) -> Wrench {
        let (v, b) = (at.speed_m_s, at.body);
        let weight = b.mass_kg * b.gravity_m_s2;
        let share = b.front_share();
        let sin = libm::sin(b.parameters.lam);
        // Slip angle that each camber force takes away.
        let (front, rear) = (
            p[0] / (15.0 * weight * share),
            p[0] / (15.0 * weight * (1.0 - share)),
        );
        let gain = v / b.parameters.w;
        let rate =
            gain * (front * (at.angle_rad[0] + sin * at.angle_rad[1]) - rear * at.angle_rad[0]);
        let slope =
            gain * (front * (at.rate_rad_s[0] + sin * at.rate_rad_s[1]) - rear * at.rate_rad_s[0]);
        b.slip_wrench(v, rate, slope)
    }
}
