//! Measured roll, as laboratories have it.
//!
//! What: roll angle and rate of the rear frame from motion capture or a reference unit. Equation
//! and source: `channel.rs`. Assumes and ignores: the laboratory's own filtering is in the delay.
//! Valid for: comparisons; no bicycle on sale has it. Checked by: the conformance suite.

use serde::{Deserialize, Serialize};
use twinhub_types::{Instant, Measurement, RollSample};

use super::{
    AngleError, Channel, RateError, Sampler, Sensor, SensorKind, SensorModel, SensorTruth, Timing,
};
use crate::admissible::OutOfRange;
use crate::explain::Explain;

/// Parameters of a roll sensor.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RollParameters {
    /// Rate, delay, losses.
    pub timing: Timing,
    /// Errors of the angle.
    pub angle: AngleError,
    /// Errors of the rate.
    pub rate: RateError,
}

/// A roll sensor in use.
#[derive(Clone, Debug)]
pub struct RollSensor {
    angle: Channel,
    rate: Channel,
    sampler: Sampler<RollSample>,
}

impl SensorKind for RollParameters {
    fn explain(&self) -> Explain {
        Explain {
            name: "roll",
            what: "roll angle and rate of the rear frame, measured in the laboratory",
            equation: "y = quantise(clamp((1 + s) x + b + N √(f/2) n)), db = K √dt n'",
            source: "error model of IEEE Std 952 without bias instability; figures: see the suite",
            assumes: "no occlusion of markers beyond independent losses",
        }
    }

    fn validate(&self) -> Result<(), OutOfRange> {
        self.timing.validate()?;
        self.angle.validate()?;
        self.rate.validate()
    }

    fn build(&self, seed: u64) -> Sensor {
        let rate_hz = self.timing.rate_hz;
        Sensor::Roll(RollSensor {
            angle: Channel::new(&self.angle.figures(), rate_hz, seed, "roll.angle"),
            rate: Channel::new(&self.rate.figures(), rate_hz, seed, "roll.rate"),
            sampler: Sampler::new(&self.timing, seed, "roll", RollSample::default()),
        })
    }
}

impl SensorModel for RollSensor {
    fn sample(&mut self, now: Instant, truth: &SensorTruth, into: &mut Measurement) {
        let Self {
            angle,
            rate,
            sampler,
        } = self;
        into.roll = sampler.tick(now, || RollSample {
            stamp_ns: now.as_nanos(),
            roll_rad: angle.measure(truth.roll_rad) as f32,
            roll_rate_rad_s: rate.measure(truth.roll_rate_rad_s) as f32,
        });
    }
}
