//! What: side forces follow the steering only after a rolled distance.
//!
//! Equation: (length/v) r' + r = kinematic yaw rate; both wheels alike, so that yaw rate and
//! lateral acceleration lag together.
//!
//! Source: H. B. Pacejka, Tire and Vehicle Dynamics (2012), chapter 7: first-order lag over
//! distance.
//!
//! Assumes and ignores: the same length at both wheels; no lag of the aligning torque by itself.
//!
//! Valid for: small angles.
//!
//! Checked by: the registry's conformance tests.

use crate::card::{Card, Equation, Family, Param};
use crate::hooks::Mechanism;
use crate::moment::{Moment, Wrench};

/// See the module.
#[derive(Debug)]
pub struct TyreRelaxation;

static CARD: Card = Card {
    name: "tyre_relaxation",
    family: Family::Tyre,
    equations: &[Equation::Steer, Equation::Roll, Equation::Lateral],
    claim: "side forces follow the steering only after a rolled distance",
    equation: "(length/v) r' + r = kinematic yaw rate; both wheels alike, so that yaw rate and lateral acceleration lag together",
    source: "H. B. Pacejka, Tire and Vehicle Dynamics (2012), chapter 7: first-order lag over distance",
    parameters: &[Param {
        name: "length_m",
        null: 0.0,
        least: 0.0,
        most: 1.5,
        probe: 0.05,
        starts: &[0.1, 0.3],
        about: "relaxation length of both tyres",
    }],
    requires: &[],
    confounded_with: &["steer_sensor_delay", "cornering_stiffness"],
    separated_by: "steering to 3 Hz at three speeds: the lag in time falls with speed, a sensor delay does not",
};

/// How much the yaw rate of the tyres changes over the step: exact for a kinematic one that changes
/// evenly.
fn added_rad_s(length_m: f64, at: &Moment<'_>, yaw_rate_rad_s: f64) -> f64 {
    let rate = at.speed_m_s.abs() / length_m.max(1e-6);
    let slope = at.yaw_accel_rad_s2();
    let settled = at.yaw_rate_rad_s() - slope / rate.max(1e-9);
    let left = -libm::expm1(-rate * at.dt_s);
    slope * at.dt_s + (settled - yaw_rate_rad_s) * left
}

/// Wrench of the yaw rate that is still lacking, with the accelerations of `at`; `memory` is the yaw
/// rate of the tyres and its mean slope over the step before.
fn lagging(length_m: f64, at: &Moment<'_>, memory: &[f64]) -> Wrench {
    let lack = memory[0] - at.yaw_rate_rad_s();
    // Over the steps before and after: a lag that is shorter has settled within them.
    let next = added_rad_s(length_m, at, memory[0]) / at.dt_s;
    let slope = 0.5 * (memory[1] + next) - at.yaw_accel_rad_s2();
    at.body.slip_wrench(at.speed_m_s, lack, slope)
}

impl Mechanism for TyreRelaxation {
    fn card(&self) -> &'static Card {
        &CARD
    }
    fn pushes(&self) -> bool {
        true
    }

    fn memory(&self) -> usize {
        2
    }

    fn remember(&self, p: &[f64], at: &Moment<'_>, memory: &mut [f64], fresh: bool) {
        if fresh {
            memory[0] = at.yaw_rate_rad_s();
            memory[1] = at.yaw_accel_rad_s2();
        } else if at.dt_s > 0.0 {
            let at = at.settled(|at| lagging(p[0], at, memory));
            let added = added_rad_s(p[0], &at, memory[0]);
            memory[0] += added;
            memory[1] = added / at.dt_s;
        }
    }

    fn wrench(&self, p: &[f64], at: &Moment<'_>, memory: &[f64]) -> Wrench {
        if p[0] <= 0.0 || at.dt_s <= 0.0 {
            return Wrench::default();
        }
        let lagging = |at: &Moment<'_>| lagging(p[0], at, memory);
        lagging(&at.settled(lagging))
    }
}
