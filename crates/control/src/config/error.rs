//! Why a configuration is refused, in words.

use core::fmt;

use super::SCHEMA_VERSION;
use crate::schedule::{POINTS_MAX, Point};

/// Why a configuration is refused.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum ConfigError {
    /// The file is of another version.
    SchemaVersion {
        /// The version that the file states.
        found: u32,
    },
    /// A number is not finite or out of range.
    OutOfRange {
        /// Key in the file.
        key: &'static str,
        /// The value found.
        found: f32,
        /// Smallest admissible value.
        min: f32,
        /// Largest admissible value.
        max: f32,
    },
    /// A schedule has too few or too many points.
    ScheduleLength {
        /// Number of points found.
        found: usize,
    },
    /// A point of a schedule is not finite or negative.
    SchedulePoint {
        /// Its place in the table, from 0.
        index: usize,
        /// The point.
        point: Point,
    },
    /// Speeds of a schedule do not rise by at least 1 mm/s.
    ScheduleOrder {
        /// Place of the point before it, from 0.
        index: usize,
        /// The point that is too slow.
        point: Point,
    },
    /// A schedule does not end in zero on both sides.
    ScheduleEnd {
        /// The point.
        point: Point,
    },
    /// The certificate was made for another bicycle.
    CertificateBicycle,
    /// There is a certificate, and a law that has no schedule.
    CertificateLaw,
    /// The schedule leaves the certificate's tube.
    CertificateTube {
        /// Where, m/s.
        speed_m_s: f32,
        /// The pair while the ride is quiet, Nm.
        quiet_nm: f32,
        /// The pair while it is busy, Nm.
        busy_nm: f32,
        /// Lower edge of the tube, Nm.
        from_nm: f32,
        /// Upper edge of the tube, Nm.
        to_nm: f32,
    },
}

impl fmt::Display for ConfigError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::SchemaVersion { found } => {
                write!(
                    f,
                    "schema_version is {found}; this controller reads {SCHEMA_VERSION}"
                )
            }
            Self::OutOfRange {
                key,
                found,
                min,
                max,
            } => {
                write!(f, "{key} is {found}; it has to lie within {min} and {max}")
            }
            Self::ScheduleLength { found } => {
                write!(
                    f,
                    "the schedule has {found} points; it has to have 2 to {POINTS_MAX}"
                )
            }
            Self::SchedulePoint { index, point } => write!(
                f,
                "point {index} of the schedule is {} m/s, {} Nm; both have to be finite and at least 0",
                point.speed_m_s, point.pair_nm
            ),
            Self::ScheduleOrder { index, point } => write!(
                f,
                "the schedule's speeds have to rise by at least 0.001 m/s; {} m/s follows point {index}",
                point.speed_m_s
            ),
            Self::ScheduleEnd { point } => write!(
                f,
                "the schedule is {} Nm at its end at {} m/s; it has to begin and end with 0 Nm, \
                 so that the pair is never toggled",
                point.pair_nm, point.speed_m_s
            ),
            Self::CertificateBicycle => f.write_str(
                "the certificate is for another bicycle; [certificate.bicycle] has to be [bicycle], \
                 number by number: design the schedule again for this bicycle (twinhub design)",
            ),
            Self::CertificateLaw => f.write_str(
                "a certificate holds for a schedule; the law has to be scheduled or off",
            ),
            Self::CertificateTube {
                speed_m_s,
                quiet_nm,
                busy_nm,
                from_nm,
                to_nm,
            } => write!(
                f,
                "at {speed_m_s} m/s the schedule asks for {quiet_nm} to {busy_nm} Nm; the certificate \
                 allows {from_nm} to {to_nm} Nm"
            ),
        }
    }
}

impl core::error::Error for ConfigError {}
