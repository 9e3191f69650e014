//! What: the front wheel is out of balance.
//!
//! Equation: steer torque a omega² cos(wheel angle - phase).
//!
//! Source: rotating mass.
//!
//! Assumes and ignores: the lateral part only; wheel angle integrated from the wheel rate.
//!
//! Valid for: small angles.
//!
//! Checked by: the registry's conformance tests.

use crate::card::{Card, Equation, Family, Param, Requirement};
use crate::hooks::Mechanism;
use crate::moment::{Moment, Wrench};
use crate::quantity::Quantity;
use twinhub_linear::Parameters;

/// See the module.
#[derive(Debug)]
pub struct WheelImbalance;

static CARD: Card = Card {
    name: "wheel_imbalance",
    family: Family::Structure,
    equations: &[Equation::Steer],
    claim: "the front wheel is out of balance",
    equation: "steer torque a omega² cos(wheel angle - phase)",
    source: "rotating mass",
    parameters: &[
        Param {
            name: "nm_s2",
            null: 0.0,
            least: 0.0,
            most: 0.1,
            probe: 0.0003,
            starts: &[],
            about: "torque per squared wheel rate",
        },
        Param {
            name: "phase_rad",
            null: 0.0,
            least: -3.1416,
            most: 3.1416,
            probe: 0.1,
            starts: &[],
            about: "phase, beyond that of each ride",
        },
    ],
    requires: &[Requirement::Channel(Quantity::FrontWheelRate)],
    confounded_with: &["pedalling_torque"],
    separated_by: "coast down: the order stays, the amplitude falls with the square of speed",
};

impl Mechanism for WheelImbalance {
    fn card(&self) -> &'static Card {
        &CARD
    }
    fn pushes(&self) -> bool {
        true
    }

    fn has_phase_by_ride(&self) -> bool {
        true
    }

    fn probes(&self, _bicycle: &Parameters) -> Vec<Vec<f64>> {
        vec![vec![3e-4, 0.0], vec![3e-4, 0.5 * std::f64::consts::PI]]
    }

    fn from_probes(&self, c: &[f64], _bicycle: &Parameters) -> Vec<f64> {
        vec![libm::hypot(c[0], c[1]) * 3e-4, libm::atan2(c[1], c[0])]
    }

    fn wrench(&self, p: &[f64], at: &Moment<'_>, _memory: &[f64]) -> Wrench {
        let Some(angle) = at.wheel_rad else {
            return Wrench::default();
        };
        let rate = at.speed_m_s / at.body.parameters.rF.max(1e-3);
        Wrench {
            steer_nm: p[0] * rate * rate * libm::cos(angle - p[1]),
            ..Wrench::default()
        }
    }
}
