//! What a ride comes to in a few numbers.

use crate::record::{RiderRow, TruthRow};
use serde::{Deserialize, Serialize};

/// Slower than this, no wheel counts as locked, m/s.
const LOCKED_SPEED_M_S: f64 = 0.5;
/// A wheel that has lost this share of its rolling speed counts as locked.
const LOCKED_SLIP_RATIO: f64 = 0.9;

/// The numbers of one ride.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Metrics {
    /// The bicycle fell.
    pub fell: bool,
    /// Root mean square of the roll angle, rad.
    pub roll_rms_rad: f64,
    /// Root mean square of the steer angle, rad.
    pub steer_rms_rad: f64,
    /// Root mean square of the rider's torque on the handlebar, Nm.
    pub rider_effort_rms_nm: f64,
    /// Root mean square of the steer rate, rad/s: how much the handlebar moves in the hands.
    pub steer_rate_rms_rad_s: f64,
    /// Largest roll angle, either side, rad.
    pub roll_max_rad: f64,
    /// How fast the bicycle swings: upward zero crossings of the roll rate per second, Hz.
    pub swing_hz: f64,
    /// Ticks in which the front motor braked a wheel that stood while the bicycle moved.
    pub front_locked_ticks: u64,
    /// Energy out of the battery, net of what came back, J.
    pub energy_j: f64,
    /// Distance, m.
    pub distance_m: f64,
    /// Ticks ridden.
    pub ticks: u64,
    /// Ticks for which the controller had no answer in time.
    pub missed_ticks: u64,
}

/// Sums over the ticks of a ride.
#[derive(Clone, Copy, Debug, Default)]
pub struct Sums {
    ticks: u64,
    seconds: f64,
    roll: f64,
    steer: f64,
    steer_rate: f64,
    roll_max_rad: f64,
    last_roll_rate_rad_s: f64,
    crossings: u64,
    front_locked_ticks: u64,
    effort: f64,
    energy_j: f64,
    distance_m: f64,
}

impl Sums {
    /// Takes in one tick of `step_s`.
    pub fn add(&mut self, truth: &TruthRow, rider: &RiderRow, step_s: f64) {
        self.ticks += 1;
        self.seconds += step_s;
        self.roll += truth.roll_rad * truth.roll_rad;
        self.steer += truth.steer_rad * truth.steer_rad;
        self.steer_rate += truth.steer_rate_rad_s * truth.steer_rate_rad_s;
        self.roll_max_rad = self.roll_max_rad.max(truth.roll_rad.abs());
        self.crossings +=
            u64::from(self.last_roll_rate_rad_s < 0.0 && truth.roll_rate_rad_s >= 0.0);
        self.last_roll_rate_rad_s = truth.roll_rate_rad_s;
        let locked = truth.front_brake_nm > 1.0
            && truth.speed_m_s > LOCKED_SPEED_M_S
            && truth.front_slip_ratio < -LOCKED_SLIP_RATIO;
        self.front_locked_ticks += u64::from(locked);
        self.effort += rider.steer_torque_nm * rider.steer_torque_nm;
        self.energy_j += truth.battery_w * step_s;
        self.distance_m += truth.speed_m_s * step_s;
    }

    /// The numbers of the ride that ends here.
    pub fn finish(&self, fell: bool, missed_ticks: u64) -> Metrics {
        let rms = |sum: f64| libm::sqrt(sum / self.ticks.max(1) as f64);
        Metrics {
            fell,
            roll_rms_rad: rms(self.roll),
            steer_rms_rad: rms(self.steer),
            rider_effort_rms_nm: rms(self.effort),
            steer_rate_rms_rad_s: rms(self.steer_rate),
            roll_max_rad: self.roll_max_rad,
            swing_hz: self.crossings as f64 / (self.seconds.max(1e-9)),
            front_locked_ticks: self.front_locked_ticks,
            energy_j: self.energy_j,
            distance_m: self.distance_m,
            ticks: self.ticks,
            missed_ticks,
        }
    }
}
