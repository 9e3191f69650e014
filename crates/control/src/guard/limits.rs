//! What the guard promises, in numbers, and what it is asked.

use twinhub_types::LimitedBy;

use crate::bounded::Bounded as _;
use crate::config::{Config, Profile};

/// From any torque to zero on a lost link or a fault, s. With the 20 ms until the loss is seen
/// and a tick this stays below 200 ms.
pub const LINK_RAMP_S: f32 = 0.15;
/// From any torque to zero without wheel speeds, s: a locked wheel would not be noticed.
pub const BLIND_RAMP_S: f32 = 0.5;
/// A brake lever that is pulled further than this ends the pair at once.
pub const LEVER_THRESHOLD_RATIO: f32 = 0.02;
/// Slip beyond this share of the speed, plus [`SLIP_MARGIN_M_S`], ends the pair at once.
pub const SLIP_RATIO: f32 = 0.15;
/// Slip speed that is always tolerated, m/s.
pub const SLIP_MARGIN_M_S: f32 = 0.3;
/// How long a slip keeps the pair away, s.
pub const SLIP_HOLD_S: f32 = 1.0;
/// A wheel whose tread is slower than this is not braked, m/s.
pub const STANDSTILL_M_S: f32 = 0.3;
/// Largest brake torque of a motor by the square of its wheel's tread speed, Nm per m²/s². A wheel
/// that loses its grip stops in a time that grows with its speed and falls with the torque, and the
/// sensors of a slow wheel see it later, by one over its speed. It limits 80 Nm below 3.2 m/s and
/// 40 Nm below 2.3. Found by rides over jumps of friction (`tests/stabilizer/friction_jumps.rs`).
pub const TURNING_NM_PER_M2_S2: f32 = 8.0;
/// Thermal time constant of a hub motor, s (guess).
pub const THERMAL_TAU_S: f32 = 60.0;
/// Power above the average limit per unused power below it, dimensionless; with the time
/// constant it allows the peak for about five seconds and then eases it down.
pub const PEAK_GAIN: f32 = 6.0;

/// What the guard is asked to let out.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Request {
    /// Pair, Nm of the front motor.
    pub pair_nm: f32,
    /// Rear torque on top of what balances the front, Nm; negative brakes.
    pub trim_nm: f32,
    /// Largest pair that the tyres carry, Nm: holds at once.
    pub pair_ceiling_nm: f32,
    /// What has limited the request so far.
    pub limited_by: LimitedBy,
}

/// The guard's limits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GuardLimits {
    /// Largest torque of either motor, Nm.
    pub torque_max_nm: f32,
    /// Fastest growth, Nm/s.
    pub ramp_up_nm_s: f32,
    /// From any torque to zero with a healthy torque path, s.
    pub ramp_down_s: f32,
    /// Largest thermal average of either motor's mechanical power, W.
    pub power_average_max_w: Option<f32>,
    /// Radius of the front wheel, m.
    pub front_wheel_radius_m: f32,
    /// Radius of the rear wheel, m.
    pub rear_wheel_radius_m: f32,
}

impl GuardLimits {
    /// No torque at all.
    pub const ZERO: Self = Self {
        torque_max_nm: 0.0,
        ramp_up_nm_s: 1.0,
        ramp_down_s: 1.0,
        power_average_max_w: None,
        front_wheel_radius_m: 0.3,
        rear_wheel_radius_m: 0.3,
    };

    /// The limits of a configuration; [`ZERO`](Self::ZERO) if it breaks a rule.
    pub fn new(config: &Config) -> Self {
        if config.check().is_err() {
            return Self::ZERO;
        }
        let profile: Profile = config.profile;
        Self {
            torque_max_nm: config.limits.torque_max_nm.at_most(profile.torque_max_nm()),
            ramp_up_nm_s: config.limits.ramp_up_nm_s,
            ramp_down_s: config.limits.ramp_down_s,
            power_average_max_w: profile.power_average_max_w(),
            front_wheel_radius_m: config.bicycle.front_wheel_radius_m,
            rear_wheel_radius_m: config.bicycle.rear_wheel_radius_m,
        }
    }
}

/// Slip speed, m/s, beyond which a wheel slips: how far its tread may lag behind the bicycle, or lead it.
pub(crate) fn tolerated_slip_m_s(speed_m_s: f32) -> f32 {
    SLIP_RATIO * speed_m_s.abs() + SLIP_MARGIN_M_S
}

/// The largest brake torque for a wheel with this tread speed, Nm: see [`TURNING_NM_PER_M2_S2`].
pub(super) fn turning_nm(tread_m_s: f32) -> f32 {
    let forward_m_s = tread_m_s.at_least(0.0);
    TURNING_NM_PER_M2_S2 * forward_m_s * forward_m_s
}
