//! How much of the fork's life the motor's braking has used.
//!
//! # What
//! Counts the load cycles of the front wheel's brake force as they come (rainflow) and adds up the
//! shares of life that they take (Miner). As life is used, the largest pair shrinks.
//!
//! # Equation
//! A cycle of range `F` takes `(F / 600 N)^5 / 14400` of the life. The pair keeps its size up to
//! [`FULL_UNTIL_RATIO`] of it and is zero when all is used.
//!
//! # Source
//! Cycle count: ASTM E1049-85, section 5.4.4 (rainflow). Life: the fork test of EN 15194, as an edition
//! that follows it gives it: 14,400 cycles of 600 N at the wheel. Slope 5: usual for welds (guess).
//!
//! # Assumes and ignores
//! The brake force alone: not the rider's brakes, the road, or the weight. Cycles that have not closed
//! (at most [`DEPTH`] turning points) are not counted yet.
//!
//! # Valid for
//! Any sequence of torques. Ripples below [`RIPPLE_N`] are no cycles.
//!
//! # Checked by
//! The example of the standard and the shares of its test, below.

use crate::bounded::Bounded as _;

/// Turning points that are kept.
pub const DEPTH: usize = 16;
/// Range that is no cycle, N.
pub const RIPPLE_N: f32 = 5.0;
/// Range of the test, N, and how often a fork has to bear it.
pub const TEST_RANGE_N: f32 = 600.0;
/// See [`TEST_RANGE_N`].
pub const TEST_CYCLES: f32 = 14_400.0;
/// Share of the life up to which the pair keeps its size.
pub const FULL_UNTIL_RATIO: f32 = 0.5;

/// Life in counts: a share of 1 is this many.
const COUNTS: f32 = 1e15;

/// The counter: to be kept while the bicycle is switched off ([`used`](Self::used)).
#[derive(Clone, Copy, Debug)]
pub struct ForkLife {
    used: u64,
    /// Turning points, N, oldest first.
    points_n: [f32; DEPTH],
    len: usize,
    /// The largest excursion since the last turning point, N, and its direction.
    edge_n: f32,
    rising: bool,
}

impl ForkLife {
    /// A counter of a fork that has used `used` counts ([`used`](Self::used)) before; 0 for a new one.
    pub const fn new(used: u64) -> Self {
        Self {
            used,
            points_n: [0.0; DEPTH],
            len: 1,
            edge_n: 0.0,
            rising: true,
        }
    }

    /// Life used so far, in counts: what to store, and to give to [`new`](Self::new).
    pub const fn used(&self) -> u64 {
        self.used
    }

    /// Share of the life that is used, 0 to 1 and beyond.
    pub fn used_ratio(&self) -> f32 {
        self.used as f32 / COUNTS
    }

    /// Share of the largest pair that is left, 1 to 0.
    pub fn share_ratio(&self) -> f32 {
        ((1.0 - self.used_ratio()) / (1.0 - FULL_UNTIL_RATIO))
            .at_least(0.0)
            .at_most(1.0)
    }

    /// A tick: the brake force at the front wheel, N. A fixed number of operations.
    pub fn add(&mut self, force_n: f32) {
        let ahead = if self.rising {
            force_n >= self.edge_n
        } else {
            force_n <= self.edge_n
        };
        if ahead {
            self.edge_n = force_n;
        } else if (force_n - self.edge_n).abs() > RIPPLE_N {
            self.turn(self.edge_n);
            self.edge_n = force_n;
            self.rising = !self.rising;
        }
    }

    fn point(&self, back: usize) -> Option<f32> {
        self.points_n.get(self.len.checked_sub(back)?).copied()
    }

    /// A turning point: counts the cycles that it closes.
    fn turn(&mut self, force_n: f32) {
        if self.len == DEPTH {
            // The oldest half cycle makes room.
            self.close_first();
        }
        if let Some(place) = self.points_n.get_mut(self.len) {
            *place = force_n;
            self.len = self.len.saturating_add(1);
        }
        for _ in 0..DEPTH {
            let (Some(a), Some(b), Some(c)) = (self.point(3), self.point(2), self.point(1)) else {
                return;
            };
            if (c - b).abs() < (b - a).abs() {
                return;
            }
            if self.len == 3 {
                self.close_first();
            } else {
                self.count((b - a).abs(), 1.0);
                let place = self.len.saturating_sub(3);
                if let Some(kept) = self.points_n.get_mut(place) {
                    *kept = c;
                }
                self.len = self.len.saturating_sub(2);
            }
        }
    }

    /// The range that begins the record is half a cycle.
    fn close_first(&mut self) {
        let [a, b, ..] = self.points_n;
        self.count((b - a).abs(), 0.5);
        self.points_n.rotate_left(1);
        self.len = self.len.saturating_sub(1);
    }

    fn count(&mut self, range_n: f32, cycles: f32) {
        let x = range_n / TEST_RANGE_N;
        let share = cycles * x * x * x * x * x / TEST_CYCLES;
        // A cast keeps to the range of the integer, whatever comes.
        self.used = self.used.saturating_add((share * COUNTS) as u64);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec::Vec;

    /// Shares of life by range and cycles, in units of one cycle of 1 N.
    fn life(cycles: &[(f32, f32)]) -> f64 {
        cycles
            .iter()
            .map(|(range_n, n)| f64::from(*n) * f64::from(*range_n).powi(5))
            .sum()
    }

    #[test]
    fn the_example_of_the_standard_is_counted_as_there() {
        // ASTM E1049-85, figure 6, times 10 N.
        let peaks = [-2.0, 1.0, -3.0, 5.0, -1.0, 3.0, -4.0, 4.0, -2.0];
        let mut fork = ForkLife::new(0);
        fork.points_n[0] = -20.0;
        fork.edge_n = -20.0;
        let ramp: Vec<f32> = peaks
            .windows(2)
            .flat_map(|w| (1..=10).map(move |i| 10.0 * (w[0] + (w[1] - w[0]) * i as f32 / 10.0)))
            .collect();
        ramp.iter().for_each(|force_n| fork.add(*force_n));
        // The last point turns back, so that it counts as one.
        fork.add(0.0);
        // Closed by then: half cycles of 3, 4 and 8, a cycle of 4; the rest is open.
        let expected = life(&[(30.0, 0.5), (40.0, 0.5), (80.0, 0.5), (40.0, 1.0)]);
        let found = f64::from(fork.used_ratio()) * f64::from(TEST_CYCLES) * 600f64.powi(5);
        assert!(
            (found / expected - 1.0).abs() < 1e-3,
            "{found} for {expected}"
        );
    }

    #[test]
    fn the_test_of_the_fork_uses_its_life_and_the_pair_shrinks() {
        let mut fork = ForkLife::new(0);
        let mut last = 1.0;
        for cycle in 0..14_400u32 {
            for force_n in [300.0, 600.0, 300.0, 0.0] {
                fork.add(force_n);
            }
            let share = fork.share_ratio();
            assert!(share <= last);
            last = share;
            if cycle == 7_000 {
                assert_eq!(share, 1.0);
            }
        }
        assert!((fork.used_ratio() - 1.0).abs() < 1e-3 && fork.share_ratio() < 2e-3);
        // What is stored is what goes on.
        assert_eq!(ForkLife::new(fork.used()).share_ratio(), fork.share_ratio());
    }

    #[test]
    fn a_ride_of_slow_pairs_is_next_to_nothing_and_ripple_is_nothing() {
        let mut fork = ForkLife::new(0);
        for _ in 0..1000 {
            (0..40)
                .chain((0..40).rev())
                .for_each(|nm| fork.add(nm as f32 / 0.35));
        }
        assert!(
            fork.used() > 0 && fork.used_ratio() < 1e-4,
            "{}",
            fork.used_ratio()
        );
        let mut fork = ForkLife::new(0);
        (0..10_000).for_each(|i| fork.add(100.0 + (i % 3) as f32));
        assert_eq!(fork.used(), 0);
        [f32::NAN, f32::INFINITY, -f32::INFINITY, 1e30, 0.0]
            .iter()
            .for_each(|x| fork.add(*x));
        assert!((0.0..=1.0).contains(&fork.share_ratio()));
    }
}
