//! What: pedalling rolls the bicycle once and twice a turn of the cranks.
//!
//! Equation: roll torque sum over n = 1, 2 of A_n cos(n crank angle - phase_n).
//!
//! Source: V. E. Bulsink (2017), Bicycling stability, pedalling forces as a disturbance; Fourier
//! form own.
//!
//! Assumes and ignores: amplitude does not follow power.
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
pub struct PedallingTorque;

static CARD: Card = Card {
    name: "pedalling_torque",
    family: Family::Rider,
    equations: &[Equation::Roll],
    claim: "pedalling rolls the bicycle once and twice a turn of the cranks",
    equation: "roll torque sum over n = 1, 2 of A_n cos(n crank angle - phase_n)",
    source: "V. E. Bulsink (2017), Bicycling stability, pedalling forces as a disturbance; Fourier form own",
    parameters: &[
        Param {
            name: "amplitude_nm",
            null: 0.0,
            least: 0.0,
            most: 80.0,
            probe: 1.0,
            starts: &[],
            about: "amplitude at the first order",
        },
        Param {
            name: "phase_rad",
            null: 0.0,
            least: -3.1416,
            most: 3.1416,
            probe: 0.1,
            starts: &[],
            about: "phase at the first order",
        },
        Param {
            name: "second_amplitude_nm",
            null: 0.0,
            least: 0.0,
            most: 80.0,
            probe: 1.0,
            starts: &[],
            about: "amplitude at the second order",
        },
        Param {
            name: "second_phase_rad",
            null: 0.0,
            least: -3.1416,
            most: 3.1416,
            probe: 0.1,
            starts: &[],
            about: "phase at the second order",
        },
    ],
    requires: &[Requirement::Channel(Quantity::CrankAngle)],
    confounded_with: &["wheel_imbalance"],
    separated_by: "another gear at the same speed: cadence and wheel order part",
};

impl Mechanism for PedallingTorque {
    fn card(&self) -> &'static Card {
        &CARD
    }
    fn pushes(&self) -> bool {
        true
    }

    fn probes(&self, _bicycle: &Parameters) -> Vec<Vec<f64>> {
        let quarter = 0.5 * std::f64::consts::PI;
        vec![
            vec![1.0, 0.0, 0.0, 0.0],
            vec![1.0, quarter, 0.0, 0.0],
            vec![0.0, 0.0, 1.0, 0.0],
            vec![0.0, 0.0, 1.0, quarter],
        ]
    }

    fn from_probes(&self, c: &[f64], _bicycle: &Parameters) -> Vec<f64> {
        vec![
            libm::hypot(c[0], c[1]),
            libm::atan2(c[1], c[0]),
            libm::hypot(c[2], c[3]),
            libm::atan2(c[3], c[2]),
        ]
    }

    fn wrench(&self, p: &[f64], at: &Moment<'_>, _memory: &[f64]) -> Wrench {
        let Some(crank) = at.crank_rad else {
            return Wrench::default();
        };
        Wrench {
            roll_nm: p[0] * libm::cos(crank - p[1]) + p[2] * libm::cos(2.0 * crank - p[3]),
            ..Wrench::default()
        }
    }
}
