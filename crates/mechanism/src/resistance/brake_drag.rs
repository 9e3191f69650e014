//! What: the front brake rubs.
//!
//! Equation: force -F at the front contact: it slows, and stiffens the steering by F c (w + c)/w
//! cos²(lam).
//!
//! Source: twinhub_linear::MotorPair for the steer part.
//!
//! Assumes and ignores: constant.
//!
//! Valid for: small angles.
//!
//! Checked by: the registry's conformance tests.

use crate::card::{Card, Equation, Family, Param, Requirement};
use crate::hooks::Mechanism;
use crate::moment::{Moment, Wrench};

/// See the module.
#[derive(Debug)]
pub struct BrakeDrag;

static CARD: Card = Card {
    name: "brake_drag",
    family: Family::Actuator,
    equations: &[
        Equation::WheelFront,
        Equation::Longitudinal,
        Equation::Steer,
    ],
    claim: "the front brake rubs",
    equation: "force -F at the front contact: it slows, and stiffens the steering by F c (w + c)/w cos²(lam)",
    source: "twinhub_linear::MotorPair for the steer part",
    parameters: &[Param {
        name: "n",
        null: 0.0,
        least: 0.0,
        most: 60.0,
        probe: 0.2,
        starts: &[],
        about: "force at the front wheel",
    }],
    requires: &[Requirement::PredictedSpeed],
    confounded_with: &["rolling_resistance", "motor_drag", "longitudinal_slope"],
    separated_by: "coast down with the brake taken off",
};

impl Mechanism for BrakeDrag {
    fn card(&self) -> &'static Card {
        &CARD
    }
    fn pushes(&self) -> bool {
        true
    }

    fn wrench(&self, p: &[f64], at: &Moment<'_>, _memory: &[f64]) -> Wrench {
        let stiffness = p[0] * at.body.canonical.pair_stiffness_per_force_m();
        Wrench {
            force_n: -p[0] * at.speed_m_s.signum(),
            steer_nm: -stiffness * at.angle_rad[1],
            ..Wrench::default()
        }
    }
}
