//! What a ride comes to in a few numbers.

use crate::record::{RiderRow, TruthRow};
use serde::{Deserialize, Serialize};

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
    roll: f64,
    steer: f64,
    effort: f64,
    energy_j: f64,
    distance_m: f64,
}

impl Sums {
    /// Takes in one tick of `step_s`.
    pub fn add(&mut self, truth: &TruthRow, rider: &RiderRow, step_s: f64) {
        self.ticks += 1;
        self.roll += truth.roll_rad * truth.roll_rad;
        self.steer += truth.steer_rad * truth.steer_rad;
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
            energy_j: self.energy_j,
            distance_m: self.distance_m,
            ticks: self.ticks,
            missed_ticks,
        }
    }
}
