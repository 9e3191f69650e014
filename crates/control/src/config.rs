//! What a stabilizer is told once: profile, bicycle, limits and law.

use crate::certificate::Certificate;
use crate::law::{Law, Mechanism as _, Off};

mod error;

pub use error::ConfigError;

/// The version of the law file that this crate reads.
pub const SCHEMA_VERSION: u32 = 1;

/// Friction that holds while nothing better is known: a wet or dusty road.
pub const FRICTION_UNKNOWN_RATIO: f32 = 0.3;

/// The speed at which assistance ends, m/s (25 km/h, EN 15194).
pub const ASSIST_SPEED_MAX_M_S: f32 = 25.0 / 3.6;

/// Fastest ramp up that the guard accepts, Nm/s.
pub const RAMP_UP_MAX_NM_S: f32 = 50.0;

/// A named set of hard limits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum Profile {
    /// The thesis's test bicycle on closed ground: 100 Nm, no power limit.
    Laboratory,
    /// A bicycle on European roads: 80 Nm for seconds, 250 W as thermal average of each motor.
    En15194,
}

impl Profile {
    /// Names of the profiles, as in law files.
    pub const NAMES: [&'static str; 2] = ["laboratory", "en15194"];

    /// The name, as in law files.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Laboratory => "laboratory",
            Self::En15194 => "en15194",
        }
    }

    /// Largest torque of either motor, Nm.
    pub const fn torque_max_nm(self) -> f32 {
        match self {
            Self::Laboratory => 100.0,
            Self::En15194 => 80.0,
        }
    }

    /// Largest thermal average of the mechanical power of either motor, W.
    pub const fn power_average_max_w(self) -> Option<f32> {
        match self {
            Self::Laboratory => None,
            Self::En15194 => Some(250.0),
        }
    }
}

/// What the controller has to know about its bicycle, rider on it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct Bicycle {
    /// Radius of the front wheel, m, 0.1 to 0.6.
    pub front_wheel_radius_m: f32,
    /// Radius of the rear wheel, m, 0.1 to 0.6.
    pub rear_wheel_radius_m: f32,
    /// Distance of the contact points, m, 0.3 to 3.
    pub wheelbase_m: f32,
    /// Tilt of the steer axis from the vertical, rad, -0.2 to 1.2.
    pub steer_tilt_rad: f32,
    /// Load of the front wheel at rest, N, 10 to 5000.
    pub front_load_n: f32,
    /// Load of the rear wheel at rest, N, 10 to 5000.
    pub rear_load_n: f32,
    /// Height of the centre of mass, m, 0.1 to 2.
    pub com_height_m: f32,
}

/// Limits that the user sets; they tighten the profile and never widen it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct Limits {
    /// Largest torque of either motor, Nm, 0 to the profile's.
    pub torque_max_nm: f32,
    /// Slowest speed at which the pair acts, m/s, at least 0.5.
    pub speed_min_m_s: f32,
    /// Fastest speed at which the pair acts, m/s, above the slowest, at most 20.
    pub speed_max_m_s: f32,
    /// How fast the pair may grow, Nm/s, above 0, at most 50.
    pub ramp_up_nm_s: f32,
    /// How long a healthy torque path takes from any torque to zero, s, 0.5 to 5.
    pub ramp_down_s: f32,
    /// Declared friction of the road, 0.05 to 1.2; leave it out where it is unknown, then 0.3
    /// holds.
    #[cfg_attr(feature = "serde", serde(default))]
    pub friction_assumed_ratio: Option<f32>,
    /// What the battery gives at most, W, 10 to 10000; left out, nothing limits it.
    #[cfg_attr(feature = "serde", serde(default))]
    pub battery_out_max_w: Option<f32>,
    /// What it takes back at most, W, 0 to 10000; left out, nothing limits it.
    #[cfg_attr(feature = "serde", serde(default))]
    pub battery_in_max_w: Option<f32>,
    /// Largest mechanical power of either motor, W, 10 to 10000; left out, nothing limits it.
    #[cfg_attr(feature = "serde", serde(default))]
    pub motor_power_max_w: Option<f32>,
}

/// Everything that a controller is built from.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct Config {
    /// Version of the file, [`SCHEMA_VERSION`].
    pub schema_version: u32,
    /// Hard limits by name.
    pub profile: Profile,
    /// The bicycle.
    pub bicycle: Bicycle,
    /// The user's limits.
    pub limits: Limits,
    /// The law.
    pub law: Law,
    /// The tube that the law's schedule has to keep to; none: nothing is proved.
    #[cfg_attr(feature = "serde", serde(default))]
    pub certificate: Option<Certificate>,
}

/// `Ok` if `found` is finite and within `min` and `max`.
pub(crate) fn in_range(
    key: &'static str,
    found: f32,
    min: f32,
    max: f32,
) -> Result<(), ConfigError> {
    if found >= min && found <= max {
        Ok(())
    } else {
        Err(ConfigError::OutOfRange {
            key,
            found,
            min,
            max,
        })
    }
}

impl Bicycle {
    /// The first number that is out of range, if any.
    pub fn check(&self) -> Result<(), ConfigError> {
        in_range(
            "bicycle.front_wheel_radius_m",
            self.front_wheel_radius_m,
            0.1,
            0.6,
        )?;
        in_range(
            "bicycle.rear_wheel_radius_m",
            self.rear_wheel_radius_m,
            0.1,
            0.6,
        )?;
        in_range("bicycle.wheelbase_m", self.wheelbase_m, 0.3, 3.0)?;
        in_range("bicycle.steer_tilt_rad", self.steer_tilt_rad, -0.2, 1.2)?;
        in_range("bicycle.front_load_n", self.front_load_n, 10.0, 5000.0)?;
        in_range("bicycle.rear_load_n", self.rear_load_n, 10.0, 5000.0)?;
        in_range("bicycle.com_height_m", self.com_height_m, 0.1, 2.0)
    }

    /// Rear torque per front torque at which the forces of the wheels balance.
    pub fn balance_ratio(&self) -> f32 {
        self.rear_wheel_radius_m / self.front_wheel_radius_m
    }
}

impl Limits {
    /// The first number that is out of range, if any.
    pub fn check(&self, profile: Profile) -> Result<(), ConfigError> {
        in_range(
            "limits.torque_max_nm",
            self.torque_max_nm,
            0.0,
            profile.torque_max_nm(),
        )?;
        in_range("limits.speed_min_m_s", self.speed_min_m_s, 0.5, 20.0)?;
        in_range(
            "limits.speed_max_m_s",
            self.speed_max_m_s,
            self.speed_min_m_s,
            20.0,
        )?;
        in_range(
            "limits.ramp_up_nm_s",
            self.ramp_up_nm_s,
            0.01,
            RAMP_UP_MAX_NM_S,
        )?;
        in_range("limits.ramp_down_s", self.ramp_down_s, 0.5, 5.0)?;
        for (key, found, min, max) in [
            (
                "limits.friction_assumed_ratio",
                self.friction_assumed_ratio,
                0.05,
                1.2,
            ),
            (
                "limits.battery_out_max_w",
                self.battery_out_max_w,
                10.0,
                10_000.0,
            ),
            (
                "limits.battery_in_max_w",
                self.battery_in_max_w,
                0.0,
                10_000.0,
            ),
            (
                "limits.motor_power_max_w",
                self.motor_power_max_w,
                10.0,
                10_000.0,
            ),
        ] {
            if let Some(found) = found {
                in_range(key, found, min, max)?;
            }
        }
        Ok(())
    }

    /// The friction that holds.
    pub fn friction_ratio(&self) -> f32 {
        self.friction_assumed_ratio
            .unwrap_or(FRICTION_UNKNOWN_RATIO)
    }
}

impl Config {
    /// A legal configuration that never asks for torque; stands in for one that is refused.
    pub const NO_TORQUE: Self = Self {
        schema_version: SCHEMA_VERSION,
        profile: Profile::En15194,
        bicycle: Bicycle {
            front_wheel_radius_m: 0.34,
            rear_wheel_radius_m: 0.34,
            wheelbase_m: 1.1,
            steer_tilt_rad: 0.35,
            front_load_n: 300.0,
            rear_load_n: 600.0,
            com_height_m: 1.0,
        },
        limits: Limits {
            torque_max_nm: 0.0,
            speed_min_m_s: 0.5,
            speed_max_m_s: 20.0,
            ramp_up_nm_s: 1.0,
            ramp_down_s: 2.0,
            friction_assumed_ratio: None,
            battery_out_max_w: None,
            battery_in_max_w: None,
            motor_power_max_w: None,
        },
        law: Law::Off(Off {}),
        certificate: None,
    };

    /// The first rule that the configuration breaks, if any. A controller built from a
    /// configuration that breaks one never asks for torque.
    pub fn check(&self) -> Result<(), ConfigError> {
        if self.schema_version != SCHEMA_VERSION {
            return Err(ConfigError::SchemaVersion {
                found: self.schema_version,
            });
        }
        self.bicycle.check()?;
        self.limits.check(self.profile)?;
        self.law.check(self.profile)?;
        match &self.certificate {
            Some(certificate) => certificate.check(&self.bicycle, &self.law),
            None => Ok(()),
        }
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use std::string::ToString;

    /// The configuration of a law file that ships.
    pub(crate) fn shipped(name: &str) -> Config {
        let text = match name {
            "off" => include_str!("../laws/off.toml"),
            "constant" => include_str!("../laws/constant.toml"),
            "scheduled" => include_str!("../laws/scheduled.toml"),
            "roll_steer_feedback" => include_str!("../laws/roll_steer_feedback.toml"),
            "steering_spring" => include_str!("../laws/steering_spring.toml"),
            "steering_motor" => include_str!("../laws/steering_motor.toml"),
            other => panic!("no law file {other} ships"),
        };
        toml::from_str(text).expect("a law file that ships can be read")
    }

    #[test]
    fn shipped_laws_are_legal_and_survive_the_round_trip() {
        for name in Law::NAMES {
            let config = shipped(name);
            assert_eq!(config.law.name(), *name);
            assert_eq!(config.check(), Ok(()));
            let text = toml::to_string(&config).expect("writes");
            assert_eq!(toml::from_str::<Config>(&text).expect("reads back"), config);
        }
    }

    #[test]
    fn typos_and_foreign_units_are_refused_with_their_place() {
        let text =
            include_str!("../laws/scheduled.toml").replace("torque_max_nm", "torque_max_knm");
        let error = toml::from_str::<Config>(&text)
            .expect_err("unknown key")
            .to_string();
        assert!(
            error.contains("torque_max_knm") && error.contains("line"),
            "{error}"
        );
        let text = include_str!("../laws/scheduled.toml").replace("scheduled]", "sheduled]");
        let error = toml::from_str::<Config>(&text)
            .expect_err("unknown law")
            .to_string();
        assert!(
            error.contains("sheduled") && error.contains("constant"),
            "{error}"
        );
    }

    #[test]
    fn numbers_beyond_the_profile_are_refused() {
        let mut config = shipped("scheduled");
        config.profile = Profile::En15194;
        config.limits.torque_max_nm = 80.1;
        let error = config.check().expect_err("80 Nm is the most").to_string();
        assert!(
            error.contains("limits.torque_max_nm is 80.1") && error.contains("80"),
            "{error}"
        );
        config.limits.torque_max_nm = f32::NAN;
        assert!(config.check().is_err());
    }
}
