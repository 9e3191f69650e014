//! What: the model without what it ignores: position on the map, heading, wheel angles.
//!
//! Equation: on tyres the reduced state is (roll, steer, trunk, legs; height, pitch; rates of
//! steer, trunk and legs; base velocity and angular velocity; wheel spins; relaxed slips). Without
//! slip the contact constraints make height and pitch functions of the configuration, and all
//! velocities functions of (roll, steer, trunk and leg rates, rear wheel speed): what is left is
//! (roll, steer, trunk, legs; their rates; speed).
//!
//! Source: Meijaard et al. (2007), section 2 (ignorable coordinates, seven velocities reduced to
//! three); own working out for trunk and legs.
//!
//! Assumes and ignores: a level road; nothing depends on place or heading.
//!
//! Valid for: roll below 75°.
//!
//! Checked by: `linearise`.

use super::constraint::contact_rates;
use super::contact::contact_points;
use super::model::{Input, Multibody};
use super::state::{ANGULAR, SLIP, SPIN, STEER, STEER_RATE, State, StateAccess, VELOCITY};
use crate::Scalar;

/// Number of reduced states, at most.
pub(super) const REDUCED: usize = 27;

/// Places of the reduced state vector.
pub(super) mod place {
    pub const ROLL: usize = 0;
    /// Steer, trunk (3), legs (2).
    pub const STEER: usize = 1;
    pub const HEIGHT: usize = 7;
    pub const PITCH: usize = 8;
    /// Steer rate, trunk rates (3), leg rates (2).
    pub const STEER_RATE: usize = 9;
    /// Without slip: roll rate; on tyres the forward component of angular velocity.
    pub const ANGULAR: usize = 15;
    /// Base velocity; without slip the first is the speed of the rear wheel.
    pub const VELOCITY: usize = 18;
    pub const SPIN: usize = 21;
    pub const SLIP: usize = 23;
}

/// Names of the reduced states on tyres.
pub(super) const NAMES: [&str; REDUCED] = [
    "roll_rad",
    "steer_rad",
    "trunk_lean_rad",
    "trunk_pitch_rad",
    "trunk_twist_rad",
    "left_leg_rad",
    "right_leg_rad",
    "height_m",
    "pitch_rad",
    "steer_rate_rad_s",
    "trunk_lean_rate_rad_s",
    "trunk_pitch_rate_rad_s",
    "trunk_twist_rate_rad_s",
    "left_leg_rate_rad_s",
    "right_leg_rate_rad_s",
    "angular_velocity_x_rad_s",
    "angular_velocity_y_rad_s",
    "angular_velocity_z_rad_s",
    "velocity_x_m_s",
    "velocity_y_m_s",
    "velocity_z_m_s",
    "rear_spin_rad_s",
    "front_spin_rad_s",
    "rear_relaxed_slip_angle",
    "front_relaxed_slip_angle",
    "rear_relaxed_slip_ratio",
    "front_relaxed_slip_ratio",
];

/// A reduced state.
pub(super) type Reduced<T> = [T; REDUCED];

impl Multibody {
    /// The reduced states that this model has, with its locked joints and wheels.
    pub(super) fn active(&self) -> Vec<usize> {
        use crate::tyre::TyreModel;
        let j = &self.parameters.joints;
        let lean = [
            j.steer.free,
            j.trunk_lean.free,
            j.trunk_pitch.free,
            j.trunk_twist.free,
            j.legs.free,
            j.legs.free,
        ];
        let relaxed = self.tyres.map(|t| t.relaxation_length_m().is_some());
        (0..REDUCED)
            .filter(|&k| match k {
                place::ROLL => true,
                place::STEER..place::HEIGHT => lean[k - place::STEER],
                place::HEIGHT | place::PITCH => !self.no_slip,
                place::STEER_RATE..place::ANGULAR => lean[k - place::STEER_RATE],
                place::ANGULAR => true,
                place::VELOCITY => true,
                place::SPIN => !self.no_slip && j.rear_wheel.free,
                22 => !self.no_slip && j.front_wheel.free,
                place::SLIP.. => !self.no_slip && relaxed[(k - place::SLIP) % 2],
                _ => !self.no_slip,
            })
            .collect()
    }

    /// The full state of a reduced one, at the origin, heading along x.
    pub(super) fn expanded<T: Scalar>(&self, r: &Reduced<T>) -> State<T> {
        let mut x: State<T> = self.upright(0.0);
        for k in 0..6 {
            x[STEER + k] = r[place::STEER + k];
            x[STEER_RATE + k] = r[place::STEER_RATE + k];
        }
        if self.no_slip {
            // Start near the road: with roll the rear hub comes down.
            let radius = self.tree.wheels[0].radius;
            x[2] = -r[place::ROLL].cos().scale(radius);
            x.set_attitude_rad(T::zero(), r[place::ROLL], T::zero());
            self.touch_down(&mut x, 8);
            self.roll_without_slip(&mut x, r);
        } else {
            x[2] = r[place::HEIGHT];
            x.set_attitude_rad(T::zero(), r[place::ROLL], r[place::PITCH]);
            for k in 0..3 {
                x[ANGULAR + k] = r[place::ANGULAR + k];
                x[VELOCITY + k] = r[place::VELOCITY + k];
            }
            for k in 0..2 {
                x[SPIN + k] = r[place::SPIN + k];
            }
            for k in 0..4 {
                x[SLIP + k] = r[place::SLIP + k];
            }
        }
        x
    }

    /// Sets all velocities from roll rate, joint rates and speed of the rear wheel, so that no
    /// contact slips. The contact velocities are linear in the velocities: six equations.
    fn roll_without_slip<T: Scalar>(&self, x: &mut State<T>, r: &Reduced<T>) {
        let pose = self.tree.pose(x);
        let (_, _, pitch) = x.yaw_roll_pitch_rad();
        let (sp, cp) = pitch.sin_cos();
        let rate = r[place::ANGULAR];
        let rear = r[place::VELOCITY].scale(1.0 / self.tree.wheels[0].radius);
        let grounds = self.grounds(x, &pose, None);
        let base = *x;
        // Unknown: two angular velocities across the roll axis (pitch; heading), velocity, front
        // spin.
        let set = |u: &[T; 6]| -> State<T> {
            let mut y = base;
            // Angular velocity: roll rate about the level forward axis, u0 about the lateral axis,
            // u1 about the axis square to both.
            y[ANGULAR] = cp * rate - sp * u[1];
            y[ANGULAR + 1] = u[0];
            y[ANGULAR + 2] = sp * rate + cp * u[1];
            for k in 0..3 {
                y[VELOCITY + k] = u[2 + k];
            }
            y[SPIN] = rear;
            y[SPIN + 1] = u[5];
            y
        };
        let rates = |u: &[T; 6]| {
            let y = set(u);
            contact_rates(
                &self.tree,
                &y,
                &contact_points(&self.tree, &y, &pose, &grounds, true),
            )
        };
        let z = T::zero();
        let offset = rates(&[z; 6]);
        let mut matrix = [[z; 7]; 6];
        for c in 0..6 {
            let mut unit = [z; 6];
            unit[c] = T::one();
            let column = rates(&unit);
            for row in 0..6 {
                matrix[row][c] = column[row] - offset[row];
            }
        }
        for row in 0..6 {
            matrix[row][6] = -offset[row];
        }
        let u = eliminated(&mut matrix);
        *x = set(&u);
    }

    /// Derivative of the reduced state.
    pub(super) fn reduced_rhs<T: Scalar>(&self, r: &Reduced<T>, input: &Input<T>) -> Reduced<T> {
        let x = self.expanded(r);
        let mut dx = [T::zero(); super::STATES];
        self.rhs(&x, input, None, &mut dx);
        let mut d = [T::zero(); REDUCED];
        for k in 0..6 {
            d[place::STEER + k] = dx[STEER + k];
            d[place::STEER_RATE + k] = dx[STEER_RATE + k];
        }
        // Base axes: roll' = cos(pitch) w_x + sin(pitch) w_z, heading' cos(roll) = cos(pitch) w_z -
        // sin(pitch) w_x, pitch' = w_y - heading' sin(roll).
        let (_, roll, pitch) = x.yaw_roll_pitch_rad();
        let ((sr, cr), (sp, cp)) = (roll.sin_cos(), pitch.sin_cos());
        let w = [x[ANGULAR], x[ANGULAR + 1], x[ANGULAR + 2]];
        let heading = (cp * w[2] - sp * w[0]) / cr;
        let pitch_rate = w[1] - heading * sr;
        d[place::ROLL] = cp * w[0] + sp * w[2];
        if self.no_slip {
            d[place::ANGULAR] =
                cp * dx[ANGULAR] + sp * dx[ANGULAR + 2] + pitch_rate * (cp * w[2] - sp * w[0]);
            d[place::VELOCITY] = dx[SPIN].scale(self.tree.wheels[0].radius);
        } else {
            d[place::HEIGHT] = dx[2];
            d[place::PITCH] = pitch_rate;
            for k in 0..3 {
                d[place::ANGULAR + k] = dx[ANGULAR + k];
                d[place::VELOCITY + k] = dx[VELOCITY + k];
            }
            for k in 0..2 {
                d[place::SPIN + k] = dx[SPIN + k];
            }
            for k in 0..4 {
                d[place::SLIP + k] = dx[SLIP + k];
            }
        }
        d
    }
}

/// Solution of six equations, with the right-hand side as seventh column (Gauss, row pivots).
fn eliminated<T: Scalar>(m: &mut [[T; 7]; 6]) -> [T; 6] {
    for c in 0..6 {
        let pivot = (c..6)
            .max_by(|&a, &b| m[a][c].value().abs().total_cmp(&m[b][c].value().abs()))
            .unwrap_or(c);
        m.swap(c, pivot);
        let inverse = T::one() / m[c][c];
        for r in c + 1..6 {
            let factor = m[r][c] * inverse;
            for k in c..7 {
                let above = m[c][k];
                m[r][k] -= factor * above;
            }
        }
    }
    let mut u = [T::zero(); 6];
    for r in (0..6).rev() {
        let mut sum = m[r][6];
        for k in r + 1..6 {
            sum -= m[r][k] * u[k];
        }
        u[r] = sum / m[r][r];
    }
    u
}
