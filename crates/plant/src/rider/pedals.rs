//! How a rider holds the speed: a force at the rear contact, proportional to what is missing.

use super::{Perception, RiderError, in_range};
use serde::{Deserialize, Serialize};

/// Numbers of [`Pedals`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PedalsParameters {
    /// Force per missing speed, N s/m.
    pub speed_gain_ns_m: f64,
    /// The largest force that the legs give, N. The legs never brake.
    pub force_limit_n: f64,
}

/// A rider's legs.
#[derive(Clone, Copy, Debug)]
pub struct Pedals {
    speed_gain_ns_m: f64,
    force_limit_n: f64,
}

impl Pedals {
    /// # Errors
    /// Where a number is out of range.
    pub fn new(p: &PedalsParameters) -> Result<Self, RiderError> {
        in_range(
            "pedals.speed_gain_ns_m",
            p.speed_gain_ns_m,
            0.0,
            1e4,
            "0 to 10000 N s/m",
        )?;
        in_range(
            "pedals.force_limit_n",
            p.force_limit_n,
            0.0,
            500.0,
            "0 to 500 N",
        )?;
        Ok(Self {
            speed_gain_ns_m: p.speed_gain_ns_m,
            force_limit_n: p.force_limit_n,
        })
    }

    /// The force of this tick, N, between 0 and the limit.
    pub fn force_n(&self, now: &Perception) -> f64 {
        let missing = now.wanted_speed_m_s - now.speed_m_s;
        (self.speed_gain_ns_m * missing).clamp(0.0, self.force_limit_n)
    }
}
