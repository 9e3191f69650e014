//! When a sensor samples and when its samples arrive.
//!
//! What: sample rate, transport delay, lost samples. Equation: samples are taken at the first
//! tick at or after k/f and stamped with that tick; a sample arrives `delay_s` later; each is lost
//! with probability `dropout_ratio`. Source: definition. Assumes and ignores: no jitter (the link
//! adds it), losses independent. Valid for: up to 1 kHz, delays up to 63 samples. Checked by: the
//! tests below (delay exact in ticks, loss rate within its confidence).

use serde::{Deserialize, Serialize};
use twinhub_types::{Duration, Instant};

use crate::admissible::{OutOfRange, within};
use crate::noise::{Gaussian, stream};

/// Most samples under way at one time.
const UNDER_WAY: usize = 64;

/// Rate, delay and losses of a sensor.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Timing {
    /// Samples in a second, Hz.
    pub rate_hz: f64,
    /// Time from a sample to its arrival, s.
    pub delay_s: f64,
    /// Share of samples that never arrive.
    pub dropout_ratio: f64,
}

impl Timing {
    /// Every tick, at once, always.
    pub const IDEAL: Self = Self {
        rate_hz: 1000.0,
        delay_s: 0.0,
        dropout_ratio: 0.0,
    };

    /// Checks every parameter.
    pub fn validate(&self) -> Result<(), OutOfRange> {
        within("rate_hz", self.rate_hz, 0.1, 1000.0)?;
        within(
            "delay_s",
            self.delay_s,
            0.0,
            (UNDER_WAY - 1) as f64 / self.rate_hz,
        )?;
        within("dropout_ratio", self.dropout_ratio, 0.0, 1.0)
    }
}

/// Takes samples of type `S` and delivers them late.
#[derive(Clone, Debug)]
pub struct Sampler<S> {
    period: Duration,
    next: Instant,
    delay: Duration,
    line: [(Instant, S); UNDER_WAY],
    first: usize,
    count: usize,
    newest: S,
    dropout_ratio: f64,
    losses: Gaussian,
}

impl<S: Copy> Sampler<S> {
    /// `never` is what is delivered before the first sample arrives.
    pub fn new(timing: &Timing, seed: u64, name: &str, never: S) -> Self {
        let nanos = |s: f64| Duration::from_nanos(libm::round(s * 1e9) as u64);
        Self {
            period: nanos(1.0 / timing.rate_hz),
            next: Instant::START,
            delay: nanos(timing.delay_s),
            line: [(Instant::START, never); UNDER_WAY],
            first: 0,
            count: 0,
            newest: never,
            dropout_ratio: timing.dropout_ratio,
            losses: stream(seed, &format!("sensor.{name}.dropout")),
        }
    }

    /// One tick: takes a sample if one is due, and returns the newest that has arrived.
    pub fn tick(&mut self, now: Instant, sample: impl FnOnce() -> S) -> S {
        if now >= self.next {
            self.next = self.next.after(self.period);
            if self.next <= now {
                self.next = now.after(self.period);
            }
            let taken = sample();
            let lost = self.dropout_ratio > 0.0 && self.losses.uniform() < self.dropout_ratio;
            if !lost {
                if self.count == UNDER_WAY {
                    self.first = (self.first + 1) % UNDER_WAY;
                    self.count -= 1;
                }
                self.line[(self.first + self.count) % UNDER_WAY] = (now.after(self.delay), taken);
                self.count += 1;
            }
        }
        while self.count > 0 && self.line[self.first].0 <= now {
            self.newest = self.line[self.first].1;
            self.first = (self.first + 1) % UNDER_WAY;
            self.count -= 1;
        }
        self.newest
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(ms: u64) -> Instant {
        Instant::from_nanos(ms * 1_000_000)
    }

    #[test]
    fn the_delay_is_exact_in_ticks_at_every_rate() {
        for (rate_hz, period_ms) in [(1000.0, 1), (500.0, 2), (200.0, 5), (100.0, 10)] {
            for delay_ms in [0u64, 1, 2, 7, 30] {
                let timing = Timing {
                    rate_hz,
                    delay_s: delay_ms as f64 * 1e-3,
                    dropout_ratio: 0.0,
                };
                timing.validate().unwrap();
                let mut sampler = Sampler::new(&timing, 1, "test", None);
                for ms in 0..300 {
                    let got = sampler.tick(at(ms), || Some(ms));
                    let expected = ms.checked_sub(delay_ms).map(|t| t / period_ms * period_ms);
                    assert_eq!(
                        got, expected,
                        "{rate_hz} Hz, {delay_ms} ms late, at {ms} ms"
                    );
                }
            }
        }
    }

    #[test]
    fn losses_have_their_declared_share() {
        let timing = Timing {
            rate_hz: 1000.0,
            delay_s: 0.0,
            dropout_ratio: 0.2,
        };
        let mut sampler = Sampler::new(&timing, 7, "test", u64::MAX);
        let n = 50_000;
        let lost = (0..n)
            .filter(|&ms| sampler.tick(at(ms), || ms) != ms)
            .count() as f64;
        let n = n as f64;
        assert!(
            (lost / n - 0.2).abs() < 5.0 * (0.16 / n).sqrt(),
            "{}",
            lost / n
        );
    }
}
