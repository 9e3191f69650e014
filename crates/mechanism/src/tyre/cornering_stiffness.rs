//! What: tyres slip sideways in proportion to their side force.
//!
//! Equation: lateral and yaw balance with F = -(lateral speed across the wheel)/(v k) at both wheels:
//! the rear contact's lateral velocity u and the yaw rate r that slip adds are states, and u', r and
//! r' push roll and steer.
//!
//! Source: H. B. Pacejka, Tire and Vehicle Dynamics (2012), chapter 1; balances after Meijaard,
//! Papadopoulos, Ruina and Schwab (2007), equations (4.1)-(4.6).
//!
//! Assumes and ignores: one compliance for both wheels; no lag of the side force.
//!
//! Valid for: small angles.
//!
//! Checked by: `tests` here: a compliance that vanishes holds the wheels to their path, and steady
//! turning is that of the forces; the registry's conformance tests.

use crate::card::{Card, Equation, Family, Param, Requirement};
use crate::hooks::Mechanism;
use crate::moment::{Moment, Wrench};
use nalgebra::{Matrix2, Vector2};

/// See the module.
#[derive(Debug)]
pub struct CorneringStiffness;

/// Stiffer tyres are as good as ones that do not slip.
const LEAST_RAD_N: f64 = 1e-9;

static CARD: Card = Card {
    name: "cornering_stiffness",
    family: Family::Tyre,
    equations: &[Equation::Roll, Equation::Steer, Equation::Lateral],
    claim: "tyres slip sideways in proportion to their side force",
    equation: "lateral and yaw balance with F = -(lateral speed across the wheel)/(v k) at both wheels",
    source: "H. B. Pacejka, Tire and Vehicle Dynamics (2012), chapter 1; balances after Meijaard, Papadopoulos, Ruina and Schwab (2007)",
    parameters: &[Param {
        name: "compliance_rad_n",
        null: 0.0,
        least: 0.0,
        most: 2e-3,
        probe: 1e-5,
        starts: &[5e-5, 2e-4, 5e-4],
        about: "slip angle per side force",
    }],
    requires: &[Requirement::SpeedRange(1.15)],
    confounded_with: &["steer_sensor_scale", "tyre_relaxation"],
    separated_by: "a range of speeds: the effect grows with the square of speed",
};

/// exp(A h), of two real or complex eigenvalues.
fn transition(a: &Matrix2<f64>, h: f64) -> Matrix2<f64> {
    let middle = 0.5 * a.trace();
    let square = middle * middle - a.determinant();
    let off = a - Matrix2::identity() * middle;
    let root = square.abs().sqrt();
    if root * h < 1e-6 {
        (Matrix2::identity() + off * h) * libm::exp(middle * h)
    } else if square > 0.0 {
        // Apart, so that a stiff sum of large and small does not overflow.
        let (slow, fast) = (
            libm::exp((middle + root) * h),
            libm::exp((middle - root) * h),
        );
        Matrix2::identity() * (0.5 * (slow + fast)) + off * (0.5 * (slow - fast) / root)
    } else {
        let (sin, cos) = libm::sincos(root * h);
        (Matrix2::identity() * cos + off * (sin / root)) * libm::exp(middle * h)
    }
}

/// Slip over one step from what is remembered, for the motion of `at`.
struct Slip {
    /// exp(A h) - 1, and the same over A.
    change: Matrix2<f64>,
    per_load: Matrix2<f64>,
    from: Vector2<f64>,
    /// Mean rates over the step before.
    before: Vector2<f64>,
    step_s: f64,
}

impl Slip {
    fn new(compliance_rad_n: f64, at: &Moment<'_>, memory: &[f64]) -> Option<Self> {
        let a = at.body.slip_matrix(at.speed_m_s, compliance_rad_n);
        let change = transition(&a, at.dt_s) - Matrix2::identity();
        Some(Self {
            change,
            per_load: a.try_inverse()? * change,
            from: Vector2::new(memory[0], memory[1]),
            before: Vector2::new(memory[2], memory[3]),
            step_s: at.dt_s,
        })
    }

    fn added(&self, at: &Moment<'_>) -> Vector2<f64> {
        self.change * self.from + self.per_load * at.body.slip_load(at)
    }

    fn wrench(&self, at: &Moment<'_>) -> Wrench {
        // The mean over the steps before and after: what is faster has settled within them.
        let rates = 0.5 * (self.before + self.added(at) / self.step_s);
        let mut wrench = at.body.slip_wrench(at.speed_m_s, self.from.y, rates.y);
        wrench += at.body.slide_wrench(rates.x);
        wrench
    }
}

impl Mechanism for CorneringStiffness {
    fn card(&self) -> &'static Card {
        &CARD
    }
    fn pushes(&self) -> bool {
        true
    }

    fn memory(&self) -> usize {
        4
    }

    fn remember(&self, p: &[f64], at: &Moment<'_>, memory: &mut [f64], fresh: bool) {
        if fresh {
            // Settled.
            let a = at.body.slip_matrix(at.speed_m_s, p[0].max(LEAST_RAD_N));
            let load = at.body.slip_load(at);
            let settled = a.try_inverse().map_or_else(Vector2::zeros, |i| -(i * load));
            memory.copy_from_slice(&[settled.x, settled.y, 0.0, 0.0]);
        } else if at.dt_s > 0.0
            && let Some(slip) = Slip::new(p[0].max(LEAST_RAD_N), at, memory)
        {
            let added = slip.added(&at.settled(|at| slip.wrench(at)));
            let (there, rates) = (slip.from + added, added / at.dt_s);
            memory.copy_from_slice(&[there.x, there.y, rates.x, rates.y]);
        }
    }

    fn wrench(&self, p: &[f64], at: &Moment<'_>, memory: &[f64]) -> Wrench {
        if p[0] <= 0.0 || at.dt_s <= 0.0 {
            return Wrench::default();
        }
        Slip::new(p[0].max(LEAST_RAD_N), at, memory).map_or_else(Wrench::default, |slip| {
            slip.wrench(&at.settled(|at| slip.wrench(at)))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Body;
    use twinhub_linear::Bicycle;

    fn at(body: &Body) -> Moment<'_> {
        Moment {
            body,
            t_s: 0.0,
            dt_s: 0.01,
            speed_m_s: 4.0,
            accel_m_s2: 0.0,
            travel_m: 0.0,
            angle_rad: [0.0, 0.1],
            rate_rad_s: [0.0; 2],
            accel_rad_s2: [0.0; 2],
            inputs: crate::Inputs::default(),
            crank_rad: None,
            wheel_rad: None,
            trunk_lean_rad: None,
            way: 1.0,
        }
    }

    fn settled(k: f64) -> (Body, [f64; 4]) {
        let body = Body::new(&Bicycle::load("meijaard2007_benchmark").unwrap()).unwrap();
        let mut memory = [0.0; 4];
        CorneringStiffness.remember(&[k], &at(&body), &mut memory, true);
        (body, memory)
    }

    /// Slip angles are compliance times side forces that turn the mass.
    #[test]
    fn steady_turn() {
        let k = 1e-4;
        let (body, [u, r, ..]) = settled(k);
        let moment = at(&body);
        let (v, w) = (moment.speed_m_s, body.parameters.w);
        let (front, rear) = (-(u + w * r) / (v * k), -u / (v * k));
        let turn = v * (moment.yaw_rate_rad_s() + r);
        assert!((front + rear - body.mass_kg * turn).abs() < 1e-9);
        assert!((w * front - body.mass_kg * body.centre_m[0] * turn).abs() < 1e-9);
    }

    #[test]
    fn stiff_tyres_do_not_slip() {
        let (body, mut memory) = settled(1e-9);
        let [u, r, ..] = memory;
        assert!(u.abs() < 1e-5 && r.abs() < 1e-5, "{u} {r}");
        CorneringStiffness.remember(&[1e-9], &at(&body), &mut memory, false);
        let wrench = CorneringStiffness.wrench(&[1e-9], &at(&body), &memory);
        assert!(
            wrench.roll_nm.abs() < 1e-2 && wrench.steer_nm.abs() < 1e-3,
            "{wrench:?}"
        );
    }

    #[test]
    fn transition_is_the_exponential() {
        for a in [
            Matrix2::new(-3.0, 1.0, 0.5, -200.0),
            Matrix2::new(-3.0, 8.0, -9.0, -2.0),
            Matrix2::new(-3.0, 1.0, 0.0, -3.0),
        ] {
            assert!(
                (transition(&a, 0.05) - (a * 0.05).exp()).norm() < 1e-9,
                "{a}"
            );
        }
    }
}
