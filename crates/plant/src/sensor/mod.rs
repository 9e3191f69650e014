//! Sensors: from what is true to what the controller is told.
//!
//! A [`SensorSuite`] is a list of sensors of the registry [`Sensor`], each with its own rate,
//! delay, losses and errors, and of [`Fault`]s laid over them. Every channel has a random stream
//! of its own, named after it: adding a sensor changes no other.

mod channel;
mod fault;
mod imu;
mod motors;
mod roll;
mod sampler;
pub mod sets;
mod steer;
mod suite;
mod wheels;

pub use channel::{
    AngleError, Channel, ChannelError, CurrentError, ForceError, RateError, TemperatureError,
    TorqueError, VoltageError,
};
pub use fault::{Fault, FaultInjector, FaultKind, FaultTarget};
pub use imu::{Imu, ImuParameters, specific_force_at};
pub use motors::{MotorReport, MotorReportParameters};
pub use roll::{RollParameters, RollSensor};
pub use sampler::{Sampler, Timing};
pub use steer::{SteerEncoder, SteerEncoderParameters, SteerRate};
pub use suite::{SensorSuite, SuiteError, SuiteParameters};
pub use wheels::{WheelHall, WheelHallParameters};

use serde::{Deserialize, Serialize};
use twinhub_types::{Instant, Measurement};

use crate::admissible::OutOfRange;
use crate::explain::Explain;
use crate::motor::PowerOutput;
use crate::truth::Truth;

/// What is true of everything that a sensor could see, SI, signs of `twinhub_types::conventions`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SensorTruth {
    /// Roll of the rear frame, rad.
    pub roll_rad: f64,
    /// Roll rate, rad/s.
    pub roll_rate_rad_s: f64,
    /// Angular velocity of the rear frame in its own axes, rad/s.
    pub body_rates_rad_s: [f64; 3],
    /// Specific force at the inertial sensor in the axes of the rear frame, m/s².
    pub specific_force_m_s2: [f64; 3],
    /// Steer angle, rad.
    pub steer_rad: f64,
    /// Steer rate, rad/s.
    pub steer_rate_rad_s: f64,
    /// Front wheel rate, positive forward, rad/s.
    pub front_wheel_rate_rad_s: f64,
    /// Rear wheel rate, positive forward, rad/s.
    pub rear_wheel_rate_rad_s: f64,
    /// Forward speed, m/s.
    pub speed_m_s: f64,
    /// Front brake torque that the drive's current stands for, Nm.
    pub front_brake_nm: f64,
    /// Rear traction torque that the drive's current stands for, Nm.
    pub rear_traction_nm: f64,
    /// Bus voltage, V.
    pub bus_v: f64,
    /// Bus current, positive out of the battery, A.
    pub bus_a: f64,
    /// Temperature of the hotter winding, °C.
    pub winding_celsius: f64,
}

impl SensorTruth {
    /// What the sensors see of a plant and its power train.
    pub fn new(truth: &Truth, power: &PowerOutput) -> Self {
        Self {
            roll_rad: truth.roll_rad,
            roll_rate_rad_s: truth.roll_rate_rad_s,
            body_rates_rad_s: truth.body_rates_rad_s,
            specific_force_m_s2: truth.specific_force_m_s2,
            steer_rad: truth.steer_rad,
            steer_rate_rad_s: truth.steer_rate_rad_s,
            front_wheel_rate_rad_s: truth.front_wheel_rate_rad_s,
            rear_wheel_rate_rad_s: truth.rear_wheel_rate_rad_s,
            speed_m_s: truth.speed_m_s,
            front_brake_nm: power.front_reported_nm,
            rear_traction_nm: power.rear_reported_nm,
            bus_v: power.bus_v,
            bus_a: power.bus_a,
            winding_celsius: power.winding_celsius,
        }
    }
}

/// A sensor in use.
pub trait SensorModel {
    /// One tick: writes the newest sample that has arrived into its place.
    fn sample(&mut self, now: Instant, truth: &SensorTruth, into: &mut Measurement);
}

/// A sensor as configured.
pub trait SensorKind {
    /// What it is, for users.
    fn explain(&self) -> Explain;
    /// Checks every parameter.
    fn validate(&self) -> Result<(), OutOfRange>;
    /// The sensor in use, with the random streams of `seed`.
    fn build(&self, seed: u64) -> Sensor;
}

twinhub_types::registry! {
    /// The sensors in use.
    #[derive(Clone, Debug)]
    #[allow(clippy::large_enum_variant)] // a handful of them live in one list, built once
    pub enum Sensor: SensorModel {
        /// Gyro and accelerometer.
        Imu(Imu) = "imu",
        /// Roll and roll rate from the laboratory.
        Roll(RollSensor) = "roll",
        /// Steer angle.
        SteerEncoder(SteerEncoder) = "steer_encoder",
        /// Wheel rates from pulses.
        WheelHall(WheelHall) = "wheel_hall",
        /// What the drives report.
        MotorReport(MotorReport) = "motor_report",
    }
    fn sample(&mut self, now: Instant, truth: &SensorTruth, into: &mut Measurement);
}

twinhub_types::registry! {
    /// The sensors as configured.
    #[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
    #[serde(rename_all = "snake_case")]
    pub enum SensorParameters: SensorKind {
        /// Gyro and accelerometer.
        Imu(ImuParameters) = "imu",
        /// Roll and roll rate from the laboratory.
        Roll(RollParameters) = "roll",
        /// Steer angle.
        SteerEncoder(SteerEncoderParameters) = "steer_encoder",
        /// Wheel rates from pulses.
        WheelHall(WheelHallParameters) = "wheel_hall",
        /// What the drives report.
        MotorReport(MotorReportParameters) = "motor_report",
    }
    fn explain(&self) -> Explain;
    fn validate(&self) -> Result<(), OutOfRange>;
    fn build(&self, seed: u64) -> Sensor;
}

#[cfg(test)]
mod fault_tests;
#[cfg(test)]
mod tests;
