//! How large the pair should be. Laws are pure: their only memory is the demand of the last tick.
//!
//! A law is a file in `law/` and a line of the registry below. Two of them are comparators: they
//! leave the hub motors alone and act by a [`Device`] of their own on the handlebar, which the
//! bench mounts; the stabilizer itself has no steering actuator.

mod constant;
mod feedback;
mod off;
mod scheduled;
mod steering;
mod trim;

pub use constant::Constant;
pub use feedback::RollSteerFeedback;
pub use off::Off;
pub use scheduled::{Activity, Scheduled};
pub use steering::{SteeringMotor, SteeringSpring};
pub use trim::SpeedTrim;

use twinhub_types::Estimate;

use crate::config::{ConfigError, Profile};

/// What a law asks for, and what it remembers.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Demand {
    /// Magnitude of the pair (front brake torque), Nm, at least 0.
    pub pair_nm: f32,
    /// Rear torque on top of what balances the front, Nm; negative brakes.
    pub trim_nm: f32,
    /// Mean square of roll and steer rate over the last seconds, rad²/s²; laws that do not look at
    /// activity leave it 0.
    pub activity_rad2_s2: f32,
    /// The ride is busy: activity has passed the upper threshold and not yet fallen below the lower.
    pub busy: bool,
}

/// A device on the handlebar that a comparator law brings along.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Device {
    /// None: the law speaks to the hub motors alone.
    #[default]
    None,
    /// A passive spring between frame and handlebar: T = -k steer.
    Spring {
        /// k, Nm/rad.
        stiffness_nm_rad: f32,
    },
    /// A motor that steers into the fall: T = k (v_0 - v) roll rate below v_0, limited.
    Motor {
        /// k, Nm s/rad per m/s.
        gain_nms_rad_per_m_s: f32,
        /// v_0, m/s.
        speed_m_s: f32,
        /// Largest torque, Nm.
        torque_max_nm: f32,
    },
}

/// What every law can do.
pub trait Mechanism {
    /// What the law asks for in state `x`, `dt_s` after it asked for `last`.
    fn demand(&self, last: &Demand, x: &Estimate, dt_s: f32) -> Demand;
    /// The first number of the law that is out of range, if any.
    fn check(&self, profile: Profile) -> Result<(), ConfigError>;
    /// The least and the largest pair that the law settles at, upright at `speed_m_s`, Nm, before
    /// limits: what a rider who practised with it is used to.
    fn settled_nm(&self, speed_m_s: f32) -> [f32; 2] {
        let _ = speed_m_s;
        [0.0; 2]
    }
    /// Its device on the handlebar.
    fn device(&self) -> Device {
        Device::None
    }
}

twinhub_types::registry! {
    /// The laws, by the names of law files.
    #[derive(Clone, Copy, Debug, PartialEq)]
    #[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
    #[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
    pub enum Law: Mechanism {
        /// No torque.
        Off(Off) = "off",
        /// The same pair at every speed.
        Constant(Constant) = "constant",
        /// A pair by speed, faded with lean.
        Scheduled(Scheduled) = "scheduled",
        /// A pair from roll and steer directly.
        RollSteerFeedback(RollSteerFeedback) = "roll_steer_feedback",
        /// A passive steering spring.
        SteeringSpring(SteeringSpring) = "steering_spring",
        /// A steering motor with the published balance-assist law.
        SteeringMotor(SteeringMotor) = "steering_motor",
    }
    fn demand(&self, last: &Demand, x: &Estimate, dt_s: f32) -> Demand;
    fn check(&self, profile: Profile) -> Result<(), ConfigError>;
    fn settled_nm(&self, speed_m_s: f32) -> [f32; 2];
    fn device(&self) -> Device;
}

#[cfg(test)]
mod tests;
