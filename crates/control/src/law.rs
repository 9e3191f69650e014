//! How large the pair should be. Laws are pure: their only memory is the demand of the last tick.

use twinhub_types::Estimate;

use crate::bounded::Bounded as _;
use crate::config::{ConfigError, Profile, in_range};
use crate::schedule::Schedule;

/// What a law asks for.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Demand {
    /// Magnitude of the pair (front brake torque), Nm, at least 0.
    pub pair_nm: f32,
    /// Rear torque on top of what balances the front, Nm; negative brakes.
    pub trim_nm: f32,
}

/// What every law can do.
pub trait Mechanism {
    /// What the law asks for in state `x`, `dt_s` after it asked for `last`.
    fn demand(&self, last: &Demand, x: &Estimate, dt_s: f32) -> Demand;
    /// The first number of the law that is out of range, if any.
    fn check(&self, profile: Profile) -> Result<(), ConfigError>;
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
    }
    fn demand(&self, last: &Demand, x: &Estimate, dt_s: f32) -> Demand;
    fn check(&self, profile: Profile) -> Result<(), ConfigError>;
}

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
}

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
    /// Speed trim; none if left out.
    #[cfg_attr(feature = "serde", serde(default))]
    pub trim: Option<SpeedTrim>,
}

impl Mechanism for Scheduled {
    fn demand(&self, last: &Demand, x: &Estimate, dt_s: f32) -> Demand {
        let left =
            (self.fade_end_rad - x.roll_rad.abs()) / (self.fade_end_rad - self.fade_start_rad);
        let target_nm = self.points.pair_nm(x.speed_m_s) * left.at_least(0.0).at_most(1.0);
        let most_nm = self.change_nm_s * dt_s;
        let pair_nm = target_nm
            .at_least(last.pair_nm - most_nm)
            .at_most(last.pair_nm + most_nm);
        Demand {
            pair_nm,
            trim_nm: trim_nm(&self.trim, x),
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
        self.trim.map_or(Ok(()), |trim| trim.check())
    }
}

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
    fn check(&self) -> Result<(), ConfigError> {
        in_range("law.trim.target_m_s", self.target_m_s, 0.0, 20.0)?;
        in_range("law.trim.gain_nm_s_m", self.gain_nm_s_m, 0.0, 100.0)?;
        in_range("law.trim.largest_nm", self.largest_nm, 0.0, 40.0)
    }
}

fn trim_nm(trim: &Option<SpeedTrim>, x: &Estimate) -> f32 {
    trim.map_or(0.0, |trim| {
        let wanted_nm = trim.gain_nm_s_m * (trim.target_m_s - x.speed_m_s);
        wanted_nm
            .at_least(-trim.largest_nm)
            .at_most(trim.largest_nm)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::tests::shipped;

    fn riding(speed_m_s: f32, roll_rad: f32) -> Estimate {
        Estimate {
            speed_m_s,
            roll_rad,
            ..Estimate::default()
        }
    }

    #[test]
    fn every_law_is_even_in_lean_and_bounded() {
        for name in Law::NAMES {
            let law = shipped(name).law;
            for speed_m_s in [0.0, 2.0, 3.5, 6.5, 9.0, 30.0] {
                for roll_rad in [0.0, 0.1, 0.3, 1.0] {
                    let last = Demand::default();
                    let right = law.demand(&last, &riding(speed_m_s, roll_rad), 10.0);
                    let left = law.demand(&last, &riding(speed_m_s, -roll_rad), 10.0);
                    assert_eq!(right, left, "{name}: the pair knows no side");
                    assert!(right.pair_nm >= 0.0 && right.pair_nm <= 100.0, "{name}");
                }
            }
        }
    }

    #[test]
    fn the_scheduled_pair_changes_slowly_and_fades_with_lean() {
        let Law::Scheduled(law) = shipped("scheduled").law else {
            panic!("the file is named after its law")
        };
        let full_nm = law.points.pair_nm(5.0);
        assert!(full_nm > 0.0);
        let mut demand = Demand::default();
        let mut ticks = 0;
        while demand.pair_nm < full_nm {
            let next = law.demand(&demand, &riding(5.0, 0.0), 1e-3);
            assert!(next.pair_nm - demand.pair_nm <= law.change_nm_s * 1e-3 * 1.01);
            demand = next;
            ticks += 1;
        }
        let expected_ticks = full_nm / law.change_nm_s * 1e3;
        assert!(
            (ticks as f32 - expected_ticks).abs() < 0.01 * expected_ticks + 2.0,
            "{ticks}"
        );
        let middle_rad = 0.5 * (law.fade_start_rad + law.fade_end_rad);
        let half = law.demand(&demand, &riding(5.0, middle_rad), 10.0);
        assert!((half.pair_nm - 0.5 * full_nm).abs() < 1e-3 * full_nm);
        assert_eq!(
            law.demand(&demand, &riding(5.0, law.fade_end_rad), 10.0)
                .pair_nm,
            0.0
        );
    }

    #[test]
    fn trim_brakes_when_too_fast() {
        let trim = Some(SpeedTrim {
            target_m_s: 5.0,
            gain_nm_s_m: 10.0,
            largest_nm: 8.0,
        });
        assert_eq!(trim_nm(&trim, &riding(4.5, 0.0)), 5.0);
        assert_eq!(trim_nm(&trim, &riding(9.0, 0.0)), -8.0);
        assert_eq!(trim_nm(&None, &riding(9.0, 0.0)), 0.0);
    }
}
