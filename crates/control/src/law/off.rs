//! No torque.

use twinhub_types::Estimate;

use super::{Demand, Mechanism};
use crate::config::{ConfigError, Profile};

/// No torque: the bicycle without a stabilizer.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct Off {}

impl Mechanism for Off {
    fn demand(&self, _: &Demand, _: &Estimate, _: f32) -> Demand {
        Demand::default()
    }
    fn check(&self, _: Profile) -> Result<(), ConfigError> {
        Ok(())
    }
}
