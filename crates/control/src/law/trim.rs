//! Speed trim with the rear motor.

use twinhub_types::Estimate;

use crate::bounded::Bounded as _;
use crate::config::{ConfigError, in_range};

/// Holds the speed with the rear motor: its losses and the rider's legs leave an error.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct SpeedTrim {
    /// Speed to hold, m/s, 0 to 20.
    pub target_m_s: f32,
    /// Rear torque per error of speed, Nm per m/s, 0 to 100.
    pub gain_nm_s_m: f32,
    /// Largest trim, Nm, 0 to 40. Driving is further limited to pedalling below 25 km/h.
    pub largest_nm: f32,
}

impl SpeedTrim {
    pub(super) fn check(&self) -> Result<(), ConfigError> {
        in_range("law.trim.target_m_s", self.target_m_s, 0.0, 20.0)?;
        in_range("law.trim.gain_nm_s_m", self.gain_nm_s_m, 0.0, 100.0)?;
        in_range("law.trim.largest_nm", self.largest_nm, 0.0, 40.0)
    }
}

/// The trim that holds the speed, Nm; 0 without one.
pub(super) fn trim_nm(trim: &Option<SpeedTrim>, x: &Estimate) -> f32 {
    trim.map_or(0.0, |trim| {
        let wanted_nm = trim.gain_nm_s_m * (trim.target_m_s - x.speed_m_s);
        wanted_nm
            .at_least(-trim.largest_nm)
            .at_most(trim.largest_nm)
    })
}
