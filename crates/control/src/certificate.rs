//! What a certificate allows: a tube of the pair over speed, for one bicycle.
//!
//! What: a law file may carry the tube that `twinhub design` has proved. The controller then takes
//! only a schedule inside it, and only on the bicycle that it was proved for.
//!
//! Equation: lower(v) <= quiet pair(v) <= pair(v) <= upper(v) at every speed: all four are straight
//! between their points, so that their points are enough.
//!
//! Source: ours.
//!
//! Assumes and ignores: fades, ramps and what the tyres do not carry leave the tube downwards for a
//! while; for that the certificate bounds the growth after a loss of the whole pair.
//!
//! Valid for: schedules. A law that has none has nothing to be held against, and is refused.
//!
//! Checked by: tests below.

use crate::config::{Bicycle, ConfigError};
use crate::law::{Law, Mechanism as _};
use crate::schedule::Schedule;

/// Rounding of a file's numbers, Nm.
const TOLERANCE_NM: f32 = 0.01;

/// The tube, and what it was proved for.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct Certificate {
    /// The bicycle: every number as in the law file.
    pub bicycle: Bicycle,
    /// Least friction that was counted on, 0.05 to 1.2.
    pub friction_ratio: f32,
    /// Lower edge; zero at its ends and outside.
    pub lower: Schedule,
    /// Upper edge; zero at its ends and outside.
    pub upper: Schedule,
}

impl Certificate {
    /// The first rule that bicycle or law break, if any.
    pub fn check(&self, bicycle: &Bicycle, law: &Law) -> Result<(), ConfigError> {
        crate::config::in_range("certificate.friction_ratio", self.friction_ratio, 0.05, 1.2)?;
        if self.bicycle != *bicycle {
            return Err(ConfigError::CertificateBicycle);
        }
        self.lower.check()?;
        self.upper.check()?;
        let schedule = match law {
            Law::Off(_) => return Ok(()),
            Law::Scheduled(scheduled) => scheduled.points,
            _ => return Err(ConfigError::CertificateLaw),
        };
        let all = [schedule.points(), self.lower.points(), self.upper.points()];
        for point in all.into_iter().flatten() {
            let v = point.speed_m_s;
            let [quiet_nm, busy_nm] = law.settled_nm(v);
            let (from_nm, to_nm) = (self.lower.pair_nm(v), self.upper.pair_nm(v));
            let inside = quiet_nm >= from_nm - TOLERANCE_NM && busy_nm <= to_nm + TOLERANCE_NM;
            if !inside {
                return Err(ConfigError::CertificateTube {
                    speed_m_s: v,
                    quiet_nm,
                    busy_nm,
                    from_nm,
                    to_nm,
                });
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::Config;
    use crate::config::tests::shipped;
    use crate::schedule::Point;
    use std::string::ToString;

    fn tube(points: &[(f32, f32)]) -> Schedule {
        let points: std::vec::Vec<Point> = points
            .iter()
            .map(|&(speed_m_s, pair_nm)| Point { speed_m_s, pair_nm })
            .collect();
        Schedule::new(&points).expect("legal")
    }

    fn certified() -> Config {
        let mut config = shipped("scheduled");
        config.certificate = Some(Certificate {
            bicycle: config.bicycle,
            friction_ratio: 0.6,
            lower: tube(&[(3.0, 0.0), (4.0, 30.0), (7.0, 30.0), (9.0, 0.0)]),
            upper: tube(&[(2.0, 0.0), (3.5, 45.0), (8.0, 45.0), (12.0, 0.0)]),
        });
        config
    }

    #[test]
    fn a_schedule_in_its_tube_on_its_bicycle_is_taken() {
        assert_eq!(certified().check(), Ok(()));
    }

    #[test]
    fn another_bicycle_is_refused() {
        let mut config = certified();
        config.bicycle.com_height_m += 0.01;
        let error = config.check().expect_err("another bicycle");
        assert!(error.to_string().contains("another bicycle"), "{error}");
    }

    #[test]
    fn a_schedule_that_leaves_the_tube_is_refused_with_the_place() {
        let mut config = certified();
        if let Law::Scheduled(law) = &mut config.law {
            law.points = tube(&[(2.5, 0.0), (3.5, 50.0), (7.5, 40.0), (11.0, 0.0)]);
        }
        config.limits.torque_max_nm = 60.0;
        let error = config.check().expect_err("above").to_string();
        assert!(error.contains("3.5 m/s") && error.contains("45"), "{error}");
        let mut config = certified();
        if let Law::Scheduled(law) = &mut config.law {
            law.points = tube(&[(2.5, 0.0), (3.5, 20.0), (7.5, 20.0), (11.0, 0.0)]);
        }
        assert!(config.check().is_err(), "below");
    }

    #[test]
    fn a_law_without_a_schedule_is_refused() {
        let mut config = certified();
        config.law = shipped("constant").law;
        assert_eq!(config.check(), Err(ConfigError::CertificateLaw));
        config.law = shipped("off").law;
        assert_eq!(config.check(), Ok(()));
    }
}
