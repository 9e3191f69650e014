//! What the motor drives report.
//!
//! What: torques from sensed current, bus voltage and current, winding temperature. Equation:
//! `channel.rs`; the torque is the drive's nominal constant times its current, so an error of the
//! true constant does not show. Source: definition. Assumes and ignores: friction, iron drag and
//! cogging are invisible to the drive. Valid for: any. Checked by: the conformance suite.

use serde::{Deserialize, Serialize};
use twinhub_types::{Instant, Measurement, MotorSample};

use super::{
    Channel, CurrentError, Sampler, Sensor, SensorKind, SensorModel, SensorTruth, TemperatureError,
    Timing, TorqueError, VoltageError,
};
use crate::admissible::OutOfRange;
use crate::explain::Explain;

/// Parameters of the drives' report.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MotorReportParameters {
    /// Rate, delay, losses.
    pub timing: Timing,
    /// Errors of each torque.
    pub torque: TorqueError,
    /// Errors of the bus voltage.
    pub voltage: VoltageError,
    /// Errors of the bus current.
    pub current: CurrentError,
    /// Errors of the winding temperature.
    pub temperature: TemperatureError,
}

/// The drives' report in use.
#[derive(Clone, Debug)]
pub struct MotorReport {
    front: Channel,
    rear: Channel,
    voltage: Channel,
    current: Channel,
    temperature: Channel,
    sampler: Sampler<MotorSample>,
}

impl SensorKind for MotorReportParameters {
    fn explain(&self) -> Explain {
        Explain {
            name: "motor_report",
            what: "torques from the drives' current sensing, bus voltage and current, winding temperature",
            equation: "T = k_nominal i_q; y = quantise(clamp((1 + s) x + b + N √(f/2) n))",
            source: "definition; figures: see the suite",
            assumes: "friction and cogging are invisible to a drive",
        }
    }

    fn validate(&self) -> Result<(), OutOfRange> {
        self.timing.validate()?;
        self.torque.validate()?;
        self.voltage.validate()?;
        self.current.validate()?;
        self.temperature.validate()
    }

    fn build(&self, seed: u64) -> Sensor {
        let channel = |error, name: &str| Channel::new(&error, self.timing.rate_hz, seed, name);
        Sensor::MotorReport(MotorReport {
            front: channel(self.torque.figures(), "motors.front"),
            rear: channel(self.torque.figures(), "motors.rear"),
            voltage: channel(self.voltage.figures(), "motors.voltage"),
            current: channel(self.current.figures(), "motors.current"),
            temperature: channel(self.temperature.figures(), "motors.temperature"),
            sampler: Sampler::new(&self.timing, seed, "motors", MotorSample::default()),
        })
    }
}

impl SensorModel for MotorReport {
    fn sample(&mut self, now: Instant, truth: &SensorTruth, into: &mut Measurement) {
        let Self {
            front,
            rear,
            voltage,
            current,
            temperature,
            sampler,
        } = self;
        into.motors = sampler.tick(now, || MotorSample {
            stamp_ns: now.as_nanos(),
            front_brake_nm: front.measure(truth.front_brake_nm) as f32,
            rear_traction_nm: rear.measure(truth.rear_traction_nm) as f32,
            bus_v: voltage.measure(truth.bus_v) as f32,
            bus_a: current.measure(truth.bus_a) as f32,
            winding_celsius: temperature.measure(truth.winding_celsius) as f32,
            reserved: 0,
        });
    }
}
