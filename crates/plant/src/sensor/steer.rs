//! Steer encoder.
//!
//! What: steer angle, with its rate from nowhere, from differences, or from a gyro pair of its
//! own. Equation: `channel.rs`; by difference r' = ((y_k - y_{k-1}) f - r)/lag, stepped exactly.
//! Source: definition. Assumes and ignores: no backlash, no cyclic error of the magnet. Valid
//! for: angles within the range. Checked by: the conformance suite.

use serde::{Deserialize, Serialize};
use twinhub_types::{Instant, Measurement, SteerSample};

use super::{
    AngleError, Channel, RateError, Sampler, Sensor, SensorKind, SensorModel, SensorTruth, Timing,
};
use crate::admissible::{OutOfRange, within};
use crate::explain::Explain;

/// Where the steer rate comes from.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum SteerRate {
    /// The encoder gives none: the sample holds NaN.
    Absent {},
    /// Difference of successive angles through a first-order lag.
    Difference {
        /// Time constant, s.
        lag_s: f64,
    },
    /// A rate sensor of its own.
    Measured(RateError),
}

/// Parameters of a steer encoder.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SteerEncoderParameters {
    /// Rate, delay, losses.
    pub timing: Timing,
    /// Errors of the angle.
    pub angle: AngleError,
    /// Where the rate comes from.
    pub rate: SteerRate,
}

/// A steer encoder in use.
#[derive(Clone, Debug)]
pub struct SteerEncoder {
    angle: Channel,
    rate: RateSource,
    sampler: Sampler<SteerSample>,
}

#[derive(Clone, Debug)]
enum RateSource {
    Absent,
    Difference {
        rate_hz: f64,
        gain: f64,
        last: Option<(f64, f64)>,
    },
    Measured(Channel),
}

impl SensorKind for SteerEncoderParameters {
    fn explain(&self) -> Explain {
        Explain {
            name: "steer_encoder",
            what: "steer angle from an encoder at the head tube, its rate from nowhere, differences or a sensor",
            equation: "y = quantise(clamp((1 + s) x + b + N √(f/2) n)); rate by difference behind a lag",
            source: "definition; figures: see the suite",
            assumes: "no backlash, no cyclic error",
        }
    }

    fn validate(&self) -> Result<(), OutOfRange> {
        self.timing.validate()?;
        self.angle.validate()?;
        match &self.rate {
            SteerRate::Absent {} => Ok(()),
            SteerRate::Difference { lag_s } => within("lag_s", *lag_s, 0.0, 1.0),
            SteerRate::Measured(error) => error.validate(),
        }
    }

    fn build(&self, seed: u64) -> Sensor {
        let rate_hz = self.timing.rate_hz;
        let rate = match &self.rate {
            SteerRate::Absent {} => RateSource::Absent,
            SteerRate::Difference { lag_s } => {
                let gain = if *lag_s > 0.0 {
                    -libm::expm1(-1.0 / (rate_hz * lag_s))
                } else {
                    1.0
                };
                RateSource::Difference {
                    rate_hz,
                    gain,
                    last: None,
                }
            }
            SteerRate::Measured(error) => {
                RateSource::Measured(Channel::new(&error.figures(), rate_hz, seed, "steer.rate"))
            }
        };
        Sensor::SteerEncoder(SteerEncoder {
            angle: Channel::new(&self.angle.figures(), rate_hz, seed, "steer.angle"),
            rate,
            sampler: Sampler::new(&self.timing, seed, "steer", SteerSample::default()),
        })
    }
}

impl SensorModel for SteerEncoder {
    fn sample(&mut self, now: Instant, truth: &SensorTruth, into: &mut Measurement) {
        let Self {
            angle,
            rate,
            sampler,
        } = self;
        into.steer = sampler.tick(now, || {
            let steer = angle.measure(truth.steer_rad);
            let steer_rate = match rate {
                RateSource::Absent => f64::NAN,
                RateSource::Difference {
                    rate_hz,
                    gain,
                    last,
                } => {
                    let filtered = match *last {
                        None => 0.0,
                        Some((before, r)) => r + *gain * ((steer - before) * *rate_hz - r),
                    };
                    *last = Some((steer, filtered));
                    filtered
                }
                RateSource::Measured(channel) => channel.measure(truth.steer_rate_rad_s),
            };
            SteerSample {
                stamp_ns: now.as_nanos(),
                steer_rad: steer as f32,
                steer_rate_rad_s: steer_rate as f32,
            }
        });
    }
}
