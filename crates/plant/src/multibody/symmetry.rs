//! What: straight running splits into a lateral and a longitudinal part.
//!
//! Equation: the model is its own mirror image. About a straight steady state, states that change
//! sign in the mirror (roll, steer, lean, twist, right less left leg, ...) and states that do not
//! (height, pitch, speed, right plus left leg, ...) have no effect on each other to first order.
//!
//! Source: symmetry of the model.
//!
//! Assumes and ignores: a level road without a left-right difference.
//!
//! Valid for: roll zero.
//!
//! Checked by: `lateral_and_longitudinal_do_not_mix` in `multibody/tests` (1e-9).

use super::linearise::Linear;
use super::model::Multibody;
use super::steady::Steady;
use nalgebra::DMatrix;

/// States that change sign in the mirror.
const LATERAL: [&str; 17] = [
    "roll_rad",
    "steer_rad",
    "trunk_lean_rad",
    "trunk_twist_rad",
    "left_leg_rad",
    "right_leg_rad",
    "steer_rate_rad_s",
    "trunk_lean_rate_rad_s",
    "trunk_twist_rate_rad_s",
    "left_leg_rate_rad_s",
    "right_leg_rate_rad_s",
    "angular_velocity_x_rad_s",
    "angular_velocity_z_rad_s",
    "roll_rate_rad_s",
    "velocity_y_m_s",
    "rear_relaxed_slip_angle",
    "front_relaxed_slip_angle",
];

/// Left and right leg, and what their difference and sum are called.
const LEGS: [[&str; 4]; 2] = [
    [
        "left_leg_rad",
        "right_leg_rad",
        "legs_swing_rad",
        "legs_spread_rad",
    ],
    [
        "left_leg_rate_rad_s",
        "right_leg_rate_rad_s",
        "legs_swing_rate_rad_s",
        "legs_spread_rate_rad_s",
    ],
];

/// One of the two parts: its states as combinations of those of the whole.
struct Part {
    names: Vec<&'static str>,
    /// Column: one state of the part.
    basis: DMatrix<f64>,
}

impl Part {
    fn of(states: &[&'static str], lateral: bool) -> Part {
        let n = states.len();
        let mut names = Vec::new();
        let mut columns: Vec<Vec<f64>> = Vec::new();
        for (i, name) in states.iter().enumerate() {
            let mut column = vec![0.0; n];
            if let Some(leg) = LEGS.iter().find(|l| l[0] == *name) {
                let right = states.iter().position(|s| *s == leg[1]).unwrap_or(i);
                let h = core::f64::consts::FRAC_1_SQRT_2;
                column[right] = h;
                column[i] = if lateral { -h } else { h };
                names.push(leg[if lateral { 2 } else { 3 }]);
            } else if LEGS.iter().any(|l| l[1] == *name) || LATERAL.contains(name) != lateral {
                continue;
            } else {
                column[i] = 1.0;
                names.push(*name);
            }
            columns.push(column);
        }
        let basis = DMatrix::from_fn(n, columns.len(), |r, c| columns[c][r]);
        Part { names, basis }
    }
}

impl Multibody {
    /// The lateral part of the model linearised about a straight steady state, without inputs: half
    /// the work of `linearise`.
    pub fn lateral(&self, steady: &Steady) -> Linear {
        let active = self.active();
        let part = Part::of(&self.state_names(&active), true);
        let n = part.names.len();
        if steady.course.roll_rad != 0.0 {
            return self.linearise(steady).lateral();
        }
        let columns = self.jacobian(steady, &active, &part.basis);
        Linear {
            a: part.basis.transpose() * columns,
            b: DMatrix::zeros(n, 0),
            names: part.names,
        }
    }
}

impl Linear {
    fn split(&self, lateral: bool) -> Linear {
        let part = Part::of(&self.names, lateral);
        Linear {
            a: part.basis.transpose() * &self.a * &part.basis,
            b: part.basis.transpose() * &self.b,
            names: part.names,
        }
    }

    /// The lateral part: roll, steer, lean, twist, side slip. Only for straight running.
    pub fn lateral(&self) -> Linear {
        self.split(true)
    }

    /// The longitudinal part: speed, height, pitch, wheel spins. Only for straight running.
    pub fn longitudinal(&self) -> Linear {
        self.split(false)
    }

    /// Largest entry of the state matrix that lets one part act on the other.
    pub fn mixing(&self) -> f64 {
        let (lateral, longitudinal) = (
            Part::of(&self.names, true).basis,
            Part::of(&self.names, false).basis,
        );
        let there = lateral.transpose() * &self.a * &longitudinal;
        let back = longitudinal.transpose() * &self.a * &lateral;
        there.amax().max(back.amax())
    }
}
