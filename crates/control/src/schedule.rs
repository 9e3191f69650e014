//! A table of the pair's magnitude over speed.

use crate::bounded::Bounded as _;
use crate::config::ConfigError;

/// Most points that a schedule holds.
pub const POINTS_MAX: usize = 16;

/// One point of a schedule.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct Point {
    /// Forward speed, m/s, at least 0.
    pub speed_m_s: f32,
    /// Magnitude of the pair (front brake torque), Nm, at least 0.
    pub pair_nm: f32,
}

const NO_POINT: Point = Point {
    speed_m_s: 0.0,
    pair_nm: 0.0,
};

/// Pair magnitude over speed: 2 to 16 points with rising speed, straight lines between them,
/// zero at both ends and outside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Schedule {
    points: [Point; POINTS_MAX],
    len: usize,
}

impl Schedule {
    /// A schedule of these points, or what is wrong with them.
    pub fn new(points: &[Point]) -> Result<Self, ConfigError> {
        let mut schedule = Self {
            points: [NO_POINT; POINTS_MAX],
            len: points.len(),
        };
        if points.len() < 2 || points.len() > POINTS_MAX {
            return Err(ConfigError::ScheduleLength {
                found: points.len(),
            });
        }
        for (slot, point) in schedule.points.iter_mut().zip(points) {
            *slot = *point;
        }
        schedule.check()?;
        Ok(schedule)
    }

    /// The points in order of speed.
    pub fn points(&self) -> &[Point] {
        self.points.get(..self.len).unwrap_or(&self.points)
    }

    /// The pair at `speed_m_s`, Nm; zero outside the table and for NaN.
    pub fn pair_nm(&self, speed_m_s: f32) -> f32 {
        let points = self.points();
        for (a, b) in points.iter().zip(points.iter().skip(1)) {
            if speed_m_s >= a.speed_m_s && speed_m_s <= b.speed_m_s {
                let span = b.speed_m_s - a.speed_m_s;
                let share = (speed_m_s - a.speed_m_s) / span;
                return a.pair_nm + (b.pair_nm - a.pair_nm) * share;
            }
        }
        0.0
    }

    /// The largest pair in the table, Nm.
    pub fn largest_nm(&self) -> f32 {
        self.points()
            .iter()
            .fold(0.0, |most, point| point.pair_nm.at_least(most))
    }

    /// The rule that this table breaks, if any.
    pub fn check(&self) -> Result<(), ConfigError> {
        let points = self.points();
        if points.len() < 2 {
            return Err(ConfigError::ScheduleLength {
                found: points.len(),
            });
        }
        for (index, point) in points.iter().enumerate() {
            let finite = point.speed_m_s.is_finite() && point.pair_nm.is_finite();
            if !finite || point.speed_m_s < 0.0 || point.pair_nm < 0.0 {
                return Err(ConfigError::SchedulePoint {
                    index,
                    point: *point,
                });
            }
        }
        for (index, (a, b)) in points.iter().zip(points.iter().skip(1)).enumerate() {
            // Also keeps the slope of every cell finite.
            if b.speed_m_s - a.speed_m_s < 1e-3 {
                return Err(ConfigError::ScheduleOrder { index, point: *b });
            }
        }
        let ends = [points.first(), points.last()];
        match ends
            .into_iter()
            .flatten()
            .find(|point| point.pair_nm != 0.0)
        {
            Some(point) => Err(ConfigError::ScheduleEnd { point: *point }),
            None => Ok(()),
        }
    }
}

#[cfg(feature = "serde")]
mod with_serde {
    use super::{NO_POINT, POINTS_MAX, Point, Schedule};
    use serde::de::{Error, SeqAccess, Visitor};
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    impl Serialize for Schedule {
        fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
            serializer.collect_seq(self.points())
        }
    }

    impl<'de> Deserialize<'de> for Schedule {
        fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
            struct Points;
            impl<'de> Visitor<'de> for Points {
                type Value = Schedule;
                fn expecting(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
                    write!(
                        f,
                        "2 to {POINTS_MAX} points {{ speed_m_s, pair_nm }} with rising speed"
                    )
                }
                fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<Schedule, A::Error> {
                    let mut points = [NO_POINT; POINTS_MAX];
                    let mut len = 0;
                    while let Some(point) = seq.next_element::<Point>()? {
                        match points.get_mut(len) {
                            Some(slot) => *slot = point,
                            None => return Err(A::Error::invalid_length(len + 1, &self)),
                        }
                        len += 1;
                    }
                    let points = points.get(..len).unwrap_or(&[]);
                    Schedule::new(points).map_err(A::Error::custom)
                }
            }
            deserializer.deserialize_seq(Points)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(speed_m_s: f32, pair_nm: f32) -> Point {
        Point { speed_m_s, pair_nm }
    }

    #[test]
    fn straight_lines_between_points_and_zero_outside() {
        let schedule = Schedule::new(&[at(2.0, 0.0), at(4.0, 40.0), at(8.0, 0.0)]).expect("legal");
        for (speed_m_s, pair_nm) in [
            (0.0, 0.0),
            (2.0, 0.0),
            (3.0, 20.0),
            (4.0, 40.0),
            (6.0, 20.0),
            (8.0, 0.0),
            (9.0, 0.0),
        ] {
            assert_eq!(schedule.pair_nm(speed_m_s), pair_nm, "{speed_m_s} m/s");
        }
        assert_eq!(schedule.pair_nm(f32::NAN), 0.0);
        assert_eq!(schedule.pair_nm(f32::INFINITY), 0.0);
        assert_eq!(schedule.largest_nm(), 40.0);
    }

    #[test]
    fn a_table_with_a_step_at_its_end_is_refused() {
        let refused = |points: &[Point]| Schedule::new(points).expect_err("must be refused");
        assert!(matches!(
            refused(&[at(2.0, 0.0)]),
            ConfigError::ScheduleLength { found: 1 }
        ));
        assert!(matches!(
            refused(&[at(1.0, 0.0); 17]),
            ConfigError::ScheduleLength { found: 17 }
        ));
        assert!(matches!(
            refused(&[at(2.0, 5.0), at(3.0, 0.0)]),
            ConfigError::ScheduleEnd { .. }
        ));
        assert!(matches!(
            refused(&[at(2.0, 0.0), at(2.0, 0.0)]),
            ConfigError::ScheduleOrder { index: 0, .. }
        ));
        assert!(matches!(
            refused(&[at(2.0, 0.0), at(3.0, f32::NAN)]),
            ConfigError::SchedulePoint { index: 1, .. }
        ));
    }
}
