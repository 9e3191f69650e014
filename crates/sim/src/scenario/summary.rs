//! What a run came to, in numbers.

use super::Scenario;
use super::columns::Now;
use serde::Serialize;
use twinhub_plant::Truth;
use twinhub_plant::multibody::{Input, InputPower, Ride};

/// What a run came to.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Summary {
    /// The bicycle.
    pub bicycle: String,
    /// How long it went on, s.
    pub duration_s: f64,
    /// Rows that were written down.
    pub rows: u64,
    /// The bicycle fell.
    pub fell: bool,
    /// When, s.
    pub fall_time_s: Option<f64>,
    /// Largest roll either way, rad.
    pub max_roll_rad: f64,
    /// Largest steer either way, rad.
    pub max_steer_rad: f64,
    /// Roll at the end, rad.
    pub end_roll_rad: f64,
    /// Heading at the end, rad.
    pub end_yaw_rad: f64,
    /// Speed at the end, m/s.
    pub end_speed_m_s: f64,
    /// When the front wheel first stood still while the bicycle moved, s.
    pub front_wheel_locked_s: Option<f64>,
    /// Least load of the front and of the rear wheel in the rows before a fall, N.
    pub least_load_n: [f64; 2],
    /// Where the energy came from and went.
    pub energy: EnergyBalance,
}

/// start + motors + pedals + rider + disturbances = end + lost.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct EnergyBalance {
    /// Of motion, gravity and springs at the start, J.
    pub start_j: f64,
    /// The same at the end, J.
    pub end_j: f64,
    /// Brought in by torques on the wheels (motors, drive and pedals), J.
    pub wheels_j: f64,
    /// Brought in by the rider's torques on bar, trunk and legs, J.
    pub rider_j: f64,
    /// Brought in by forces and moments on the frame, J.
    pub disturbances_j: f64,
    /// Lost in tyres, dampers, bearings and air, J: what remains of the sum.
    pub lost_j: f64,
}

/// Below this rate a wheel stands still, rad/s.
const LOCKED_RAD_S: f64 = 0.5;
/// Above this speed a standing wheel is locked, m/s.
const MOVING_M_S: f64 = 1.0;

/// Sums as the run goes.
pub(super) struct Tally {
    summary: Summary,
    before: InputPower,
}

impl Tally {
    pub(super) fn new(scenario: &Scenario, ride: &Ride) -> Self {
        Self {
            summary: Summary {
                bicycle: scenario.bicycle.clone(),
                duration_s: 0.0,
                rows: 0,
                fell: false,
                fall_time_s: None,
                max_roll_rad: 0.0,
                max_steer_rad: 0.0,
                end_roll_rad: 0.0,
                end_yaw_rad: 0.0,
                end_speed_m_s: 0.0,
                front_wheel_locked_s: None,
                least_load_n: [f64::INFINITY; 2],
                energy: EnergyBalance {
                    start_j: EnergyBalance::stored_j(ride),
                    ..EnergyBalance::default()
                },
            },
            before: InputPower::default(),
        }
    }

    /// Looks at a step; true when the bicycle falls in it.
    pub(super) fn look(&mut self, t_s: f64, truth: &Truth, fall_roll_rad: f64) -> bool {
        let s = &mut self.summary;
        s.max_roll_rad = s.max_roll_rad.max(truth.roll_rad.abs());
        s.max_steer_rad = s.max_steer_rad.max(truth.steer_rad.abs());
        s.end_roll_rad = truth.roll_rad;
        s.end_yaw_rad = truth.yaw_rad;
        s.end_speed_m_s = truth.speed_m_s;
        let stands = truth.front_wheel_rate_rad_s < LOCKED_RAD_S;
        if s.front_wheel_locked_s.is_none() && stands && truth.speed_m_s > MOVING_M_S {
            s.front_wheel_locked_s = Some(t_s);
        }
        let falls = !s.fell && truth.roll_rad.abs() > fall_roll_rad;
        if falls {
            (s.fell, s.fall_time_s) = (true, Some(t_s));
        }
        falls
    }

    /// Counts a row.
    pub(super) fn row(&mut self, now: &Now) {
        let s = &mut self.summary;
        s.rows += 1;
        if !s.fell {
            let loads = [now.truth.front_load_n, now.truth.rear_load_n];
            for (least, load) in s.least_load_n.iter_mut().zip(loads) {
                *least = least.min(load);
            }
        }
    }

    /// Power at the start of a step.
    pub(super) fn before(&mut self, ride: &Ride, input: &Input) {
        self.before = ride.model().input_power(ride.state(), input);
    }

    /// Power at its end: work by the trapezoidal rule.
    pub(super) fn after(&mut self, ride: &Ride, input: &Input, step_s: f64) {
        let after = ride.model().input_power(ride.state(), input);
        let half = 0.5 * step_s;
        let e = &mut self.summary.energy;
        e.wheels_j += half * (self.before.wheels_w + after.wheels_w);
        e.rider_j += half * (self.before.rider_w + after.rider_w);
        e.disturbances_j += half * (self.before.disturbances_w + after.disturbances_w);
    }

    pub(super) fn finish(mut self, ride: &Ride, duration_s: f64) -> Summary {
        self.summary.duration_s = duration_s;
        let e = &mut self.summary.energy;
        e.end_j = EnergyBalance::stored_j(ride);
        e.lost_j = e.start_j + e.wheels_j + e.rider_j + e.disturbances_j - e.end_j;
        self.summary
    }
}
