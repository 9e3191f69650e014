//! Comparators that act on the handlebar instead of the hubs.

use twinhub_types::Estimate;

use super::{Demand, Device, Mechanism};
use crate::config::{ConfigError, Profile, in_range};

/// A passive spring between frame and handlebar: what the pair amounts to without slip, for no
/// energy. 80 Nm of pair act like 10 Nm/rad.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct SteeringSpring {
    /// Stiffness, Nm/rad, 0 to 100.
    pub stiffness_nm_rad: f32,
}

impl Mechanism for SteeringSpring {
    fn demand(&self, _: &Demand, _: &Estimate, _: f32) -> Demand {
        Demand::default()
    }
    fn check(&self, _: Profile) -> Result<(), ConfigError> {
        in_range(
            "law.steering_spring.stiffness_nm_rad",
            self.stiffness_nm_rad,
            0.0,
            100.0,
        )
    }
    fn device(&self) -> Device {
        Device::Spring {
            stiffness_nm_rad: self.stiffness_nm_rad,
        }
    }
}

/// A steering motor with the balance-assist law of Delft: torque into the fall, by roll rate, that
/// fades out with speed (mechmotum/fall-probability-paper: gains of 8 and 10 Nm s/rad per m/s, 7 Nm).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct SteeringMotor {
    /// Torque per roll rate and speed below `speed_m_s`, Nm s/rad per m/s, 0 to 100.
    pub gain_nms_rad_per_m_s: f32,
    /// Speed at and above which it does nothing, m/s, 0 to 20.
    pub speed_m_s: f32,
    /// Largest torque, Nm, 0 to 20.
    pub torque_max_nm: f32,
}

impl Mechanism for SteeringMotor {
    fn demand(&self, _: &Demand, _: &Estimate, _: f32) -> Demand {
        Demand::default()
    }
    fn check(&self, _: Profile) -> Result<(), ConfigError> {
        in_range(
            "law.steering_motor.gain_nms_rad_per_m_s",
            self.gain_nms_rad_per_m_s,
            0.0,
            100.0,
        )?;
        in_range("law.steering_motor.speed_m_s", self.speed_m_s, 0.0, 20.0)?;
        in_range(
            "law.steering_motor.torque_max_nm",
            self.torque_max_nm,
            0.0,
            20.0,
        )
    }
    fn device(&self) -> Device {
        Device::Motor {
            gain_nms_rad_per_m_s: self.gain_nms_rad_per_m_s,
            speed_m_s: self.speed_m_s,
            torque_max_nm: self.torque_max_nm,
        }
    }
}
