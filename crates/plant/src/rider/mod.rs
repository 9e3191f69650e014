//! Riders: what they perceive, and what they do about it.
//!
//! A rider acts once a tick on what it perceived a delay earlier. It has channels (steer torque or
//! steer angle, trunk lean, knees), each with its own delay, muscles and remnant, and gains that
//! follow speed; and pedals. Channels are entries of one registry; a rider file holds any of them.
//!
//! [`closed_loop`] says whether a rider keeps a bicycle up (eigenvalues with the exact delay),
//! [`design`] finds gains that do, [`published`] has the riders of Bulsink (2017).

mod angle;
mod channel;
pub mod closed_loop;
pub mod design;
mod file;
mod gains;
mod lateral;
mod linear;
mod muscle;
mod pedals;
pub mod presets;
pub mod published;
mod steer_torque;
#[cfg(test)]
mod tests;
pub mod windows;

pub use angle::{
    Angle, AngleParameters, KneesParameters, SteerAngleParameters, TrunkLeanParameters,
};
pub use channel::{DelayLine, MAX_DELAY_S, NeuromuscularLag};
pub use file::{Channels, HandsOff, Limbs, RiderFile};
pub use gains::{AngleGains, GainRow, TorqueGains, gains_at};
pub use lateral::LateralBicycle;
pub use linear::{LinearChannel, Signals};
pub use pedals::{Pedals, PedalsParameters};
pub use steer_torque::{SteerTorque, SteerTorqueParameters};

use crate::explain::Explain;

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
    /// Lean of the trunk relative to the frame, rad.
    pub trunk_lean_rad: f64,
    /// Its rate, rad/s.
    pub trunk_lean_rate_rad_s: f64,
    /// Left and right leg about the hip-ankle line, outward positive, rad.
    pub legs_rad: [f64; 2],
    /// Their rates, rad/s.
    pub leg_rates_rad_s: [f64; 2],
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
    /// Torque between pelvis and trunk that leans the trunk to the right, Nm.
    pub trunk_lean_torque_nm: f64,
    /// Torques that turn left and right leg outward, Nm.
    pub leg_torque_nm: [f64; 2],
    /// Driving force of the pedals at the rear contact, N.
    pub pedal_force_n: f64,
}

impl Action {
    /// Both together.
    pub fn plus(self, other: Self) -> Self {
        Self {
            steer_torque_nm: self.steer_torque_nm + other.steer_torque_nm,
            trunk_lean_torque_nm: self.trunk_lean_torque_nm + other.trunk_lean_torque_nm,
            leg_torque_nm: [
                self.leg_torque_nm[0] + other.leg_torque_nm[0],
                self.leg_torque_nm[1] + other.leg_torque_nm[1],
            ],
            pedal_force_n: self.pedal_force_n + other.pedal_force_n,
        }
    }
}

/// What a channel moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Limb {
    /// Arms on the handlebar.
    Bar,
    /// Trunk, leaning at the waist.
    Trunk,
    /// Both legs, to one side.
    Knees,
}

impl Limb {
    /// Angle, rad, positive to the right, and its rate, rad/s.
    pub fn angle_and_rate(self, now: &Perception) -> (f64, f64) {
        match self {
            Self::Bar => (now.steer_rad, now.steer_rate_rad_s),
            Self::Trunk => (now.trunk_lean_rad, now.trunk_lean_rate_rad_s),
            Self::Knees => (
                0.5 * (now.legs_rad[1] - now.legs_rad[0]),
                0.5 * (now.leg_rates_rad_s[1] - now.leg_rates_rad_s[0]),
            ),
        }
    }

    /// A torque on this limb alone, positive to the right, Nm.
    pub fn action(self, torque_nm: f64) -> Action {
        let mut action = Action::default();
        match self {
            Self::Bar => action.steer_torque_nm = torque_nm,
            Self::Trunk => action.trunk_lean_torque_nm = torque_nm,
            Self::Knees => action.leg_torque_nm = [-torque_nm, torque_nm],
        }
        action
    }
}

/// A channel in motion: gains, delay line, muscles and noise.
pub trait ChannelModel {
    /// One tick of `step_s` seconds.
    fn act(&mut self, perception: &Perception, step_s: f64) -> Action;
}

/// A channel as configured.
pub trait ChannelKind {
    /// The channel in motion.
    type Started;
    /// What it is, for users.
    fn explain() -> Explain;
    /// Checks every number.
    fn validate(&self) -> Result<(), RiderError>;
    /// The channel at the start of a ride; `seed` sets its remnant, `step_s` its tick.
    fn start(&self, seed: u64, step_s: f64) -> Self::Started;
    /// The channel about zero at one speed, without remnant and limits.
    fn linear(&self, speed_m_s: f64) -> LinearChannel;
}

twinhub_types::registry! {
    /// The channels.
    #[derive(Clone, Debug)]
    pub enum Channel: ChannelModel {
        /// Steer torque from roll, roll rate, heading and steer, delayed.
        SteerTorque(SteerTorque) = "steer_torque",
        /// Steer angle from roll, roll rate and heading, delayed, held by stiff arms.
        SteerAngle(Angle) = "steer_angle",
        /// Lean of the trunk from roll and roll rate, delayed.
        TrunkLean(Angle) = "trunk_lean",
        /// Both knees to one side from roll and roll rate, delayed.
        Knees(Angle) = "knees",
    }
    fn act(&mut self, perception: &Perception, step_s: f64) -> Action;
}

/// A rider in motion.
#[derive(Clone, Debug)]
pub struct Rider {
    channels: Vec<Channel>,
    pedals: Pedals,
}

impl Rider {
    /// One tick of `step_s` seconds: all channels together, and the pedals.
    pub fn act(&mut self, perception: &Perception, step_s: f64) -> Action {
        let pedals = Action {
            pedal_force_n: self.pedals.force_n(perception),
            ..Action::default()
        };
        self.channels.iter_mut().fold(pedals, |sum, channel| {
            sum.plus(channel.act(perception, step_s))
        })
    }
}

/// Why a rider cannot ride.
#[derive(Clone, Debug, thiserror::Error, PartialEq)]
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
    /// Hands off the bar and on it.
    #[error("rider: `hands_off` stands beside `{found}`; accepted is one of the two")]
    HandsOffAndOn {
        /// The other channel.
        found: &'static str,
    },
    /// Two channels for the handlebar.
    #[error("rider: both `steer_torque` and `steer_angle`; accepted is one of the two")]
    TwoHands,
    /// The plant's rider cannot move that.
    #[error(
        "rider: channel `{channel}` moves the {limb}, which this plant does not have; accepted is a \
         multibody plant with `joints.{joint}.free = true`, or a rider without that channel"
    )]
    NoSuchLimb {
        /// The channel.
        channel: &'static str,
        /// What it moves.
        limb: &'static str,
        /// The joint that would have to be free.
        joint: &'static str,
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
