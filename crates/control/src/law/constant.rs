//! The same pair at every speed.

use twinhub_types::Estimate;

use super::trim::{SpeedTrim, trim_nm};
use super::{Demand, Mechanism};
use crate::config::{ConfigError, Profile, in_range};

/// The same pair at every speed, as in Bulsink (2017), chapter 7.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct Constant {
    /// Magnitude of the pair, Nm, 0 to the profile's largest torque.
    pub pair_nm: f32,
    /// Speed trim; none if left out.
    #[cfg_attr(feature = "serde", serde(default))]
    pub trim: Option<SpeedTrim>,
}

impl Mechanism for Constant {
    fn demand(&self, _: &Demand, x: &Estimate, _: f32) -> Demand {
        Demand {
            pair_nm: self.pair_nm,
            trim_nm: trim_nm(&self.trim, x),
            ..Demand::default()
        }
    }
    fn check(&self, profile: Profile) -> Result<(), ConfigError> {
        in_range(
            "law.constant.pair_nm",
            self.pair_nm,
            0.0,
            profile.torque_max_nm(),
        )?;
        self.trim.map_or(Ok(()), |trim| trim.check())
    }
    fn settled_nm(&self, _: f32) -> [f32; 2] {
        [self.pair_nm; 2]
    }
}
