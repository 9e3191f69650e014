//! The drive's own watchdog.
//!
//! What: a dead controller cannot ramp its torque down; the drive does. Equation: with s the time
//! since the last new, finite command, the share of that command that is still followed is 1 for
//! s <= `silence_s`, falls linearly to 0 at s = `silence_s + ramp_s`, and from there on the bridge
//! is open: no current at all, whatever the lag still holds. A new command ends it at once.
//! Source: our own rule; 20 ms and a torque of zero within 200 ms are the bench's requirement on
//! a lost link. Assumes and ignores: the drive's own processor lives. Valid for: any tick.
//! Checked by: the test below.

use serde::{Deserialize, Serialize};
use twinhub_types::Duration;

use crate::admissible::{OutOfRange, within};

/// When a drive stops following the last command.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Watchdog {
    /// Time without a new command that is still normal, s.
    pub silence_s: f64,
    /// Time of the ramp to zero after that, s.
    pub ramp_s: f64,
}

impl Watchdog {
    /// 20 ms of silence, then 180 ms of ramp: no current 200 ms after the last command.
    pub const STANDARD: Self = Self {
        silence_s: 0.020,
        ramp_s: 0.180,
    };

    /// Checks both times.
    pub fn validate(&self) -> Result<(), OutOfRange> {
        within("silence_s", self.silence_s, 1e-3, 10.0)?;
        within("ramp_s", self.ramp_s, 0.0, 10.0)
    }

    /// Share of the last command that is followed after `silence`; 0 means that the bridge opens.
    pub fn share(&self, silence: Duration) -> f64 {
        let late_s = silence.as_secs_f64() - self.silence_s;
        if late_s <= 1e-9 {
            1.0
        } else if late_s + 1e-9 >= self.ramp_s {
            0.0
        } else {
            1.0 - late_s / self.ramp_s
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn full_until_20_ms_half_at_110_and_nothing_from_200() {
        let share = |ms| Watchdog::STANDARD.share(Duration::from_millis(ms));
        assert_eq!(share(0), 1.0);
        assert_eq!(share(20), 1.0);
        assert!(share(21) < 1.0);
        assert!((share(110) - 0.5).abs() < 1e-12);
        assert!(share(199) > 0.0);
        assert_eq!(share(200), 0.0);
        assert_eq!(share(100_000), 0.0);
    }
}
