//! Riders: what they perceive, and what they do about it.
//!
//! A rider acts once a tick on what it perceived `delay_s` earlier. Its gains follow speed. All
//! riders are entries of one registry; a rider file names one of them with its numbers.

mod channel;
mod pedals;
mod steer_torque;

pub use channel::{DelayLine, MAX_DELAY_S, NeuromuscularLag};
pub use pedals::{Pedals, PedalsParameters};
pub use steer_torque::{Gains, SteerTorque, SteerTorqueParameters};

use serde::{Deserialize, Serialize};

/// What a rider can perceive in one tick, SI, signs of `twinhub_types::conventions`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Perception {
    /// Roll angle, rad.
    pub roll_rad: f64,
    /// Roll rate, rad/s.
    pub roll_rate_rad_s: f64,
    /// Steer angle, rad.
    pub steer_rad: f64,
    /// Steer rate, rad/s.
    pub steer_rate_rad_s: f64,
    /// Heading, rad.
    pub yaw_rad: f64,
    /// Forward speed, m/s.
    pub speed_m_s: f64,
    /// The speed that the course asks for, m/s.
    pub wanted_speed_m_s: f64,
}

/// What a rider does in one tick.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Action {
    /// Torque on the handlebar about the steer axis, Nm.
    pub steer_torque_nm: f64,
    /// Driving force of the pedals at the rear contact, N.
    pub pedal_force_n: f64,
}

/// A rider in motion: parameters, delay lines and noise.
pub trait RiderModel {
    /// One tick of `step_s` seconds.
    fn act(&mut self, perception: &Perception, step_s: f64) -> Action;
}

twinhub_types::registry! {
    /// The riders.
    #[derive(Clone, Debug)]
    pub enum Rider: RiderModel {
        /// Hands off the bar; only the pedals are used.
        HandsOff(HandsOff) = "hands_off",
        /// Steer torque from roll, roll rate and heading, delayed.
        SteerTorque(SteerTorque) = "steer_torque",
    }
    fn act(&mut self, perception: &Perception, step_s: f64) -> Action;
}

/// The rider part of a rider file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum RiderParameters {
    /// See [`HandsOff`].
    HandsOff(HandsOffParameters),
    /// See [`SteerTorque`].
    SteerTorque(SteerTorqueParameters),
}

/// A rider file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RiderFile {
    /// Version of the format: 1.
    pub schema_version: u32,
    /// One sentence: who this is.
    pub about: String,
    /// Where the numbers come from.
    pub source: String,
    /// The rider.
    pub rider: RiderParameters,
    /// How the rider holds the speed.
    pub pedals: PedalsParameters,
}

/// Why a rider cannot ride.
#[derive(Debug, thiserror::Error, PartialEq)]
#[non_exhaustive]
pub enum RiderError {
    /// A number is out of range.
    #[error("rider: `{key}` is {found}, accepted is {accepted}")]
    OutOfRange {
        /// The key in the rider file.
        key: &'static str,
        /// What was found.
        found: f64,
        /// What would be accepted.
        accepted: &'static str,
    },
    /// No gains, or speeds out of order.
    #[error("rider: `gains` needs at least one row, with `speed_m_s` rising from row to row")]
    GainTable,
    /// Unknown version.
    #[error("rider: `schema_version` is {found}, accepted is 1")]
    Version {
        /// What was found.
        found: u32,
    },
}

pub(crate) fn in_range(
    key: &'static str,
    found: f64,
    low: f64,
    high: f64,
    accepted: &'static str,
) -> Result<(), RiderError> {
    if found >= low && found <= high {
        Ok(())
    } else {
        Err(RiderError::OutOfRange {
            key,
            found,
            accepted,
        })
    }
}

impl RiderFile {
    /// The rider at the start of a ride; `seed` sets its remnant noise, `step_s` its tick.
    ///
    /// # Errors
    /// Where a number is out of range; the message names the key.
    pub fn start(&self, seed: u64, step_s: f64) -> Result<Rider, RiderError> {
        if self.schema_version != 1 {
            return Err(RiderError::Version {
                found: self.schema_version,
            });
        }
        let pedals = Pedals::new(&self.pedals)?;
        Ok(match &self.rider {
            RiderParameters::HandsOff(_) => Rider::HandsOff(HandsOff { pedals }),
            RiderParameters::SteerTorque(p) => {
                Rider::SteerTorque(SteerTorque::new(p, pedals, seed, step_s)?)
            }
        })
    }
}

/// Hands off the bar.
#[derive(Clone, Debug)]
pub struct HandsOff {
    pedals: Pedals,
}

/// Hands off the bar has no numbers.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HandsOffParameters {}

impl RiderModel for HandsOff {
    fn act(&mut self, perception: &Perception, _step_s: f64) -> Action {
        Action {
            steer_torque_nm: 0.0,
            pedal_force_n: self.pedals.force_n(perception),
        }
    }
}
