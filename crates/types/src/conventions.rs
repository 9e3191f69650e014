//! Frames and signs, after Meijaard, Papadopoulos, Ruina and Schwab (2007), Proc. R. Soc. A 463.
//!
//! * Axes: x forward, y to the right, z down. The origin of the bicycle is the rear contact point.
//! * Roll, steer and yaw are positive to the right: a bicycle with `roll_rad > 0` leans to the
//!   right, one with `steer_rad > 0` steers to the right. Pitch is positive nose up.
//! * Wheel spin rates are positive when the bicycle rolls forward. (About the y axis to the right
//!   this is a negative rotation; the plant converts at its boundary.)
//! * `front_brake_nm > 0` brakes, `rear_traction_nm > 0` drives. Both are torques of the hub
//!   motors about their wheel axles.
//! * `steer_torque_nm > 0` turns the front assembly to the right; `roll_torque_nm > 0` and
//!   `lateral_force_n > 0` push the bicycle to the right.
//! * An accelerometer reads specific force in body axes: upright and at rest it reads
//!   `(0, 0, -9.81)`, because z points down.
//! * SI units throughout; the unit stands at the end of every public name (`_nm` is newton
//!   metre). Degrees and km/h appear only at the edge: command line flags and reports.

/// Standard gravity, m/s².
pub const GRAVITY_M_S2: f64 = 9.81;

/// The tick of the closed loop: 1 ms.
pub const TICK: crate::Duration = crate::Duration::from_millis(1);
