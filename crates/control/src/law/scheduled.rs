//! A pair by speed.

use twinhub_types::Estimate;

use super::trim::{SpeedTrim, trim_nm};
use super::{Demand, Mechanism};
use crate::bounded::Bounded as _;
use crate::config::{ConfigError, Profile, in_range};
use crate::schedule::Schedule;

/// A pair by speed, faded out with lean, changed slowly.
///
/// The fade keeps the pair out of corners, where the side force needs the tyre and the pair
/// pushes instead of stiffening.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct Scheduled {
    /// How fast the demand follows the schedule, Nm/s, above 0, at most 100.
    pub change_nm_s: f32,
    /// Roll at which the fade begins, rad, at least 0.
    pub fade_start_rad: f32,
    /// Roll beyond which the pair is zero, rad, at least 0.02 more than where the fade begins.
    pub fade_end_rad: f32,
    /// The table.
    pub points: Schedule,
    /// Less of the pair while the ride is quiet; all of it always if left out.
    #[cfg_attr(feature = "serde", serde(default))]
    pub activity: Option<Activity>,
    /// Speed trim; none if left out.
    #[cfg_attr(feature = "serde", serde(default))]
    pub trim: Option<SpeedTrim>,
}

impl Mechanism for Scheduled {
    fn demand(&self, last: &Demand, x: &Estimate, dt_s: f32) -> Demand {
        let left =
            (self.fade_end_rad - x.roll_rad.abs()) / (self.fade_end_rad - self.fade_start_rad);
        let (activity_rad2_s2, busy) = match &self.activity {
            Some(activity) => activity.judge(last, x, dt_s),
            None => (0.0, true),
        };
        let level_ratio = match &self.activity {
            Some(activity) if !busy => activity.quiet_ratio,
            _ => 1.0,
        };
        let target_nm =
            self.points.pair_nm(x.speed_m_s) * level_ratio * left.at_least(0.0).at_most(1.0);
        let most_nm = self.change_nm_s * dt_s;
        let pair_nm = target_nm
            .at_least(last.pair_nm - most_nm)
            .at_most(last.pair_nm + most_nm);
        Demand {
            pair_nm,
            trim_nm: trim_nm(&self.trim, x),
            activity_rad2_s2,
            busy,
        }
    }
    fn check(&self, profile: Profile) -> Result<(), ConfigError> {
        in_range("law.scheduled.change_nm_s", self.change_nm_s, 0.01, 100.0)?;
        in_range(
            "law.scheduled.fade_start_rad",
            self.fade_start_rad,
            0.0,
            1.0,
        )?;
        let fade_min_rad = self.fade_start_rad + 0.02;
        in_range(
            "law.scheduled.fade_end_rad",
            self.fade_end_rad,
            fade_min_rad,
            1.5,
        )?;
        self.points.check()?;
        let largest_nm = self.points.largest_nm();
        in_range(
            "law.scheduled.points.pair_nm",
            largest_nm,
            0.0,
            profile.torque_max_nm(),
        )?;
        self.activity.map_or(Ok(()), |activity| activity.check())?;
        self.trim.map_or(Ok(()), |trim| trim.check())
    }
    fn settled_nm(&self, speed_m_s: f32) -> [f32; 2] {
        let full_nm = self.points.pair_nm(speed_m_s);
        let quiet_ratio = self.activity.map_or(1.0, |activity| activity.quiet_ratio);
        [full_nm * quiet_ratio, full_nm]
    }
}

/// Two levels of the pair by what the ride does: less while it is quiet, all of it while roll and
/// steer are busy, with hysteresis. Both levels have to be rideable with the same gains.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct Activity {
    /// Share of the schedule that is left while the ride is quiet, 0 to 1.
    pub quiet_ratio: f32,
    /// Root mean square of roll and steer rate above which the ride is busy, rad/s, at least that of
    /// `calm_rad_s`, at most 3.
    pub busy_rad_s: f32,
    /// ... and below which it is quiet again, rad/s, 0 to 3.
    pub calm_rad_s: f32,
    /// Time over which the mean is taken, s, 0.1 to 60.
    pub memory_s: f32,
}

impl Activity {
    fn check(&self) -> Result<(), ConfigError> {
        in_range(
            "law.scheduled.activity.quiet_ratio",
            self.quiet_ratio,
            0.0,
            1.0,
        )?;
        in_range(
            "law.scheduled.activity.calm_rad_s",
            self.calm_rad_s,
            0.0,
            3.0,
        )?;
        in_range(
            "law.scheduled.activity.busy_rad_s",
            self.busy_rad_s,
            self.calm_rad_s,
            3.0,
        )?;
        in_range("law.scheduled.activity.memory_s", self.memory_s, 0.1, 60.0)
    }

    /// Mean square of the rates, and whether the ride is busy.
    fn judge(&self, last: &Demand, x: &Estimate, dt_s: f32) -> (f32, bool) {
        let now = x.roll_rate_rad_s * x.roll_rate_rad_s + x.steer_rate_rad_s * x.steer_rate_rad_s;
        let share = (dt_s / self.memory_s).at_most(1.0);
        let mean = last.activity_rad2_s2 + share * (now - last.activity_rad2_s2);
        // A rate that is no number says nothing.
        let mean = if mean.is_finite() {
            mean
        } else {
            last.activity_rad2_s2
        };
        let edge_rad_s = if last.busy {
            self.calm_rad_s
        } else {
            self.busy_rad_s
        };
        (mean, mean > edge_rad_s * edge_rad_s)
    }
}
