//! Time as integer nanoseconds: exact, ordered, and the same on host and target.

/// The stamp of a sample that was never taken.
pub const NEVER_NS: u64 = u64::MAX;

/// A point in time, nanoseconds since the start of the ride.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Instant(u64);

/// A span of time, nanoseconds, never negative.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Duration(u64);

impl Instant {
    /// The start of the ride.
    pub const START: Self = Self(0);

    /// `ns` nanoseconds after the start of the ride.
    pub const fn from_nanos(ns: u64) -> Self {
        Self(ns)
    }

    /// Nanoseconds since the start of the ride.
    pub const fn as_nanos(self) -> u64 {
        self.0
    }

    /// Seconds since the start of the ride, rounded to the nearest `f64`.
    pub fn as_secs_f64(self) -> f64 {
        self.0 as f64 * 1e-9
    }

    /// Time since `earlier`; zero if `earlier` lies in the future.
    pub const fn since(self, earlier: Self) -> Duration {
        Duration(self.0.saturating_sub(earlier.0))
    }

    /// True if a sample stamped `stamp_ns` was taken, is not from the future, and is at most
    /// `max_age` old.
    pub const fn fresh(self, stamp_ns: u64, max_age: Duration) -> bool {
        stamp_ns != NEVER_NS && stamp_ns <= self.0 && self.0 - stamp_ns <= max_age.0
    }

    /// `self + span`, held at the end of time instead of wrapping.
    pub const fn after(self, span: Duration) -> Self {
        Self(self.0.saturating_add(span.0))
    }
}

impl Duration {
    /// No time at all.
    pub const ZERO: Self = Self(0);

    /// A span of `ns` nanoseconds.
    pub const fn from_nanos(ns: u64) -> Self {
        Self(ns)
    }

    /// A span of `us` microseconds.
    pub const fn from_micros(us: u64) -> Self {
        Self(us.saturating_mul(1_000))
    }

    /// A span of `ms` milliseconds.
    pub const fn from_millis(ms: u64) -> Self {
        Self(ms.saturating_mul(1_000_000))
    }

    /// The span in nanoseconds.
    pub const fn as_nanos(self) -> u64 {
        self.0
    }

    /// The span in seconds, `f64`.
    pub fn as_secs_f64(self) -> f64 {
        self.0 as f64 * 1e-9
    }

    /// The span in seconds, `f32`.
    pub fn as_secs_f32(self) -> f32 {
        self.0 as f32 * 1e-9
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sample_is_fresh_only_between_its_stamp_and_its_age_limit() {
        let now = Instant::from_nanos(10_000_000);
        let limit = Duration::from_millis(5);
        assert!(now.fresh(10_000_000, limit));
        assert!(now.fresh(5_000_000, limit));
        assert!(!now.fresh(4_999_999, limit), "too old");
        assert!(!now.fresh(10_000_001, limit), "from the future");
        assert!(!now.fresh(NEVER_NS, limit), "never taken");
    }

    #[test]
    fn time_saturates_instead_of_wrapping() {
        assert_eq!(Instant::START.since(Instant::from_nanos(5)), Duration::ZERO);
        assert_eq!(
            Instant::from_nanos(u64::MAX)
                .after(Duration::from_nanos(1))
                .as_nanos(),
            u64::MAX
        );
    }
}
