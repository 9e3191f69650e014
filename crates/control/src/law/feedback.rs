//! A pair from roll and steer directly.

use twinhub_types::Estimate;

use super::{Demand, Mechanism};
use crate::bounded::Bounded as _;
use crate::config::{ConfigError, Profile, in_range};

/// Torque from roll and steer directly, to show how little authority it has: upright and straight
/// the pair is no input at all, so what it does to roll is of second order.
///
/// T = |k_phi phi + k_p phi' + k_delta delta + k_d delta'|, limited. The size alone: the pair knows
/// no side.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct RollSteerFeedback {
    /// k_phi, Nm/rad, -10,000 to 10,000.
    pub roll_nm_rad: f32,
    /// k_p, Nm s/rad, -10,000 to 10,000.
    pub roll_rate_nms_rad: f32,
    /// k_delta, Nm/rad, -10,000 to 10,000.
    pub steer_nm_rad: f32,
    /// k_d, Nm s/rad, -10,000 to 10,000.
    pub steer_rate_nms_rad: f32,
    /// Largest pair, Nm, 0 to the profile's largest torque.
    pub pair_max_nm: f32,
}

impl Mechanism for RollSteerFeedback {
    fn demand(&self, _: &Demand, x: &Estimate, _: f32) -> Demand {
        let sum_nm = self.roll_nm_rad * x.roll_rad
            + self.roll_rate_nms_rad * x.roll_rate_rad_s
            + self.steer_nm_rad * x.steer_rad
            + self.steer_rate_nms_rad * x.steer_rate_rad_s;
        Demand {
            pair_nm: sum_nm.abs().at_least(0.0).at_most(self.pair_max_nm),
            ..Demand::default()
        }
    }
    fn check(&self, profile: Profile) -> Result<(), ConfigError> {
        for (key, gain) in [
            ("law.roll_steer_feedback.roll_nm_rad", self.roll_nm_rad),
            (
                "law.roll_steer_feedback.roll_rate_nms_rad",
                self.roll_rate_nms_rad,
            ),
            ("law.roll_steer_feedback.steer_nm_rad", self.steer_nm_rad),
            (
                "law.roll_steer_feedback.steer_rate_nms_rad",
                self.steer_rate_nms_rad,
            ),
        ] {
            in_range(key, gain, -1e4, 1e4)?;
        }
        in_range(
            "law.roll_steer_feedback.pair_max_nm",
            self.pair_max_nm,
            0.0,
            profile.torque_max_nm(),
        )
    }
}
