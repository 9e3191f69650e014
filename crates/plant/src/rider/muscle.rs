//! What every channel does between perceiving and acting: dead time, remnant, limit, muscles.

use super::channel::{DelayLine, NeuromuscularLag};
use super::{MAX_DELAY_S, Perception, RiderError, Signals, in_range};
use crate::noise::{ColouredNoise, stream};

/// Numbers that all channels have. The unit of remnant and limit is that of the channel's demand.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct MuscleParameters {
    /// s.
    pub delay_s: f64,
    /// rad/s.
    pub neuromuscular_rad_s: f64,
    /// Damping ratio.
    pub neuromuscular_damping_ratio: f64,
    /// Standard deviation of the remnant.
    pub remnant_sd: f64,
    /// rad/s.
    pub remnant_bandwidth_rad_s: f64,
    /// Largest demand.
    pub limit: f64,
}

impl MuscleParameters {
    /// Refuses what no rider has; `keys` are those of remnant and limit in the rider file.
    pub(super) fn validate(&self, keys: [&'static str; 2]) -> Result<(), RiderError> {
        in_range("delay_s", self.delay_s, 0.0, MAX_DELAY_S, "0 to 1 s")?;
        in_range(
            "neuromuscular_rad_s",
            self.neuromuscular_rad_s,
            1.0,
            200.0,
            "1 to 200 rad/s",
        )?;
        in_range(
            "neuromuscular_damping_ratio",
            self.neuromuscular_damping_ratio,
            0.1,
            5.0,
            "0.1 to 5",
        )?;
        in_range(
            "remnant_bandwidth_rad_s",
            self.remnant_bandwidth_rad_s,
            0.1,
            200.0,
            "0.1 to 200 rad/s",
        )?;
        in_range(keys[0], self.remnant_sd, 0.0, f64::MAX, "0 or above")?;
        in_range(keys[1], self.limit, 0.0, f64::MAX, "0 or above")
    }
}

/// Delay line, remnant and muscle of one channel.
#[derive(Clone, Debug)]
pub(super) struct Muscle {
    delay: DelayLine<5>,
    lag: NeuromuscularLag,
    remnant: ColouredNoise,
    limit: f64,
}

impl Muscle {
    /// At rest; the remnant has the random stream called `name`.
    pub(super) fn new(p: &MuscleParameters, seed: u64, name: &str, step_s: f64) -> Self {
        Self {
            delay: DelayLine::new(p.delay_s, step_s),
            lag: NeuromuscularLag::new(p.neuromuscular_rad_s, p.neuromuscular_damping_ratio),
            remnant: ColouredNoise::new(
                p.remnant_sd,
                p.remnant_bandwidth_rad_s,
                stream(seed, name),
            ),
            limit: p.limit,
        }
    }

    /// Takes in the present and gives what was perceived a delay ago. Once a tick.
    pub(super) fn perceive(&mut self, now: &Perception) -> Signals {
        let [roll, roll_rate, heading, steer, steer_rate] = self.delay.push([
            now.roll_rad,
            now.roll_rate_rad_s,
            now.yaw_rad,
            now.steer_rad,
            now.steer_rate_rad_s,
        ]);
        Signals {
            roll,
            roll_rate,
            heading,
            steer,
            steer_rate,
        }
    }

    /// What the muscles give when `wanted` is asked for. Once a tick.
    pub(super) fn pull(&mut self, wanted: f64, step_s: f64) -> f64 {
        let wanted = wanted + self.remnant.step(step_s);
        self.lag.step(wanted.clamp(-self.limit, self.limit), step_s)
    }
}
