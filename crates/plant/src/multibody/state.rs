//! The state of the multibody model: a plain array with named entries.
//!
//! Position and attitude are those of the rear frame (base); its origin is the centre of the rear
//! wheel. Velocities are quasi-velocities in base axes: `velocity_m_s` of the origin and
//! `angular_velocity_rad_s`. Attitude is a quaternion (w, x, y, z), so no roll angle is singular.

use super::vector;
use crate::Scalar;

/// Number of state variables.
pub const STATES: usize = 33;

/// State of the model.
pub type State<T = f64> = [T; STATES];

/// Position of the origin, world axes, m (3).
pub const POSITION: usize = 0;
/// Attitude quaternion (4).
pub const ATTITUDE: usize = 3;
/// Steer angle, rad.
pub const STEER: usize = 7;
/// Trunk lean (right positive), pitch (backward positive), twist (right positive), rad (3).
pub const TRUNK: usize = 8;
/// Left and right leg about the hip-ankle line, knee outward positive, rad (2).
pub const LEGS: usize = 11;
/// Angle rolled by rear and front wheel, forward positive, rad (2).
pub const WHEELS: usize = 13;
/// Velocity of the origin in base axes, m/s (3).
pub const VELOCITY: usize = 15;
/// Angular velocity of the base in base axes, rad/s (3).
pub const ANGULAR: usize = 18;
/// Steer rate, rad/s.
pub const STEER_RATE: usize = 21;
/// Trunk rates, rad/s (3).
pub const TRUNK_RATE: usize = 22;
/// Leg rates, rad/s (2).
pub const LEG_RATE: usize = 25;
/// Spin rates of rear and front wheel relative to frame and fork, forward positive, rad/s (2).
pub const SPIN: usize = 27;
/// Relaxed slip: slip angle tangent of rear and front, slip ratio of rear and front (4).
pub const SLIP: usize = 29;

/// Names of the state variables, in order, with units.
pub const NAMES: [&str; STATES] = [
    "x_m",
    "y_m",
    "z_m",
    "attitude_w",
    "attitude_x",
    "attitude_y",
    "attitude_z",
    "steer_rad",
    "trunk_lean_rad",
    "trunk_pitch_rad",
    "trunk_twist_rad",
    "left_leg_rad",
    "right_leg_rad",
    "rear_wheel_rad",
    "front_wheel_rad",
    "velocity_x_m_s",
    "velocity_y_m_s",
    "velocity_z_m_s",
    "angular_velocity_x_rad_s",
    "angular_velocity_y_rad_s",
    "angular_velocity_z_rad_s",
    "steer_rate_rad_s",
    "trunk_lean_rate_rad_s",
    "trunk_pitch_rate_rad_s",
    "trunk_twist_rate_rad_s",
    "left_leg_rate_rad_s",
    "right_leg_rate_rad_s",
    "rear_spin_rad_s",
    "front_spin_rad_s",
    "rear_relaxed_slip_angle",
    "front_relaxed_slip_angle",
    "rear_relaxed_slip_ratio",
    "front_relaxed_slip_ratio",
];

/// Three consecutive entries.
#[inline(always)]
pub fn triple<T: Scalar>(x: &State<T>, at: usize) -> [T; 3] {
    [x[at], x[at + 1], x[at + 2]]
}

/// Named access to a state.
pub trait StateAccess<T: Scalar> {
    /// Attitude quaternion.
    fn attitude(&self) -> [T; 4];
    /// Yaw, roll, pitch, rad (3-1-2 sequence).
    fn yaw_roll_pitch_rad(&self) -> (T, T, T);
    /// Sets the attitude from yaw, roll, pitch, rad.
    fn set_attitude_rad(&mut self, yaw: T, roll: T, pitch: T);
    /// Velocity of the origin and angular velocity as (angular, linear).
    fn base_motion(&self) -> [T; 6];
}

impl<T: Scalar> StateAccess<T> for State<T> {
    #[inline(always)]
    fn attitude(&self) -> [T; 4] {
        [self[3], self[4], self[5], self[6]]
    }
    fn yaw_roll_pitch_rad(&self) -> (T, T, T) {
        vector::yaw_roll_pitch(&vector::rotation(&self.attitude()))
    }
    fn set_attitude_rad(&mut self, yaw: T, roll: T, pitch: T) {
        let q = vector::quaternion(yaw, roll, pitch);
        self[ATTITUDE..ATTITUDE + 4].copy_from_slice(&q);
    }
    #[inline(always)]
    fn base_motion(&self) -> [T; 6] {
        [
            self[ANGULAR],
            self[ANGULAR + 1],
            self[ANGULAR + 2],
            self[VELOCITY],
            self[VELOCITY + 1],
            self[VELOCITY + 2],
        ]
    }
}
