//! The span of a tick, from times that may stand still, jump or run backwards.

use twinhub_types::conventions::TICK;
use twinhub_types::{Duration, Instant};

/// The longest span that one tick counts for where more time means more torque or more trust.
pub const LONGEST_TICK: Duration = Duration::from_millis(20);

/// One tick's span.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tick {
    /// The time of the tick.
    pub now: Instant,
    /// Seconds that may be credited, 0 to 0.02: for ramps up, filters, and waiting for health.
    pub credit_s: f32,
    /// Seconds that have to be assumed, above 0: for ramps down. A clock that stands still or
    /// runs backwards counts as one nominal tick, so that no ramp down ever hangs.
    pub debit_s: f32,
    /// False if the time did not advance, or advanced by more than [`LONGEST_TICK`].
    pub regular: bool,
}

/// Remembers the last tick.
#[derive(Clone, Copy, Debug, Default)]
pub struct Clock {
    last: Option<Instant>,
}

impl Clock {
    /// The span from the last tick to `now`; the first tick is regular and of nominal length.
    pub fn tick(&mut self, now: Instant) -> Tick {
        let last = self.last.replace(now);
        let Some(last) = last else {
            return Tick {
                now,
                credit_s: 0.0,
                debit_s: TICK.as_secs_f32(),
                regular: true,
            };
        };
        let span = now.since(last);
        if span == Duration::ZERO {
            return Tick {
                now,
                credit_s: 0.0,
                debit_s: TICK.as_secs_f32(),
                regular: false,
            };
        }
        Tick {
            now,
            credit_s: span.min(LONGEST_TICK).as_secs_f32(),
            debit_s: span.as_secs_f32(),
            regular: span <= LONGEST_TICK,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_regular_time_gives_credit() {
        let mut clock = Clock::default();
        assert!(clock.tick(Instant::from_nanos(5_000_000)).regular);
        let tick = clock.tick(Instant::from_nanos(6_000_000));
        assert!(
            tick.regular && tick.credit_s == tick.debit_s && (tick.debit_s - 1e-3).abs() < 1e-9
        );
        let still = clock.tick(Instant::from_nanos(6_000_000));
        assert!(!still.regular && still.credit_s == 0.0 && still.debit_s > 0.0);
        let back = clock.tick(Instant::from_nanos(1_000_000));
        assert!(!back.regular && back.credit_s == 0.0 && back.debit_s > 0.0);
        let jump = clock.tick(Instant::from_nanos(2_001_000_000));
        assert!(!jump.regular && jump.credit_s <= 0.02 && (jump.debit_s - 2.0).abs() < 1e-6);
    }
}
