//! Pacing: what says when a tick begins.
//!
//! *Lockstep*: a tick begins when the tick before has its answer. As fast as the machine allows;
//! the result does not depend on speed, load or pauses.
//!
//! *Real time*: tick k begins k ms after the first, by the monotonic clock in absolute terms, so
//! that errors do not add up. The rule for a tick that begins late:
//!
//! * Less than one tick late: it is ridden at once; the next one begins in time. The lateness goes
//!   into the histogram.
//! * One tick or more late: it is counted as an *overrun* and logged. Ticks that are due are ridden
//!   one after the other until the ride has caught up with the clock.
//! * More than [`CATCH_UP_MAX`] ticks late, which is the silence that both watchdogs allow: the
//!   ride does not catch up any more. The clock is moved by whole ticks, which are counted as
//!   *slipped*, and logged.
//!
//! The answer: the plant waits [`ANSWER_WAIT`] for the answer to its frame. Then the newest answer
//! that has come is applied, once, if it belongs to one of the last [`ANSWER_AGE_MAX`] ticks; else
//! the tick is ridden in *silence*, counted as missed: the drives hold the last torque, and after
//! 20 ms of silence their watchdogs ramp it out. The controller that hears nothing for
//! [`LOSS_AFTER`] goes on by its own clock, on samples that grow older: it makes up for the ticks
//! that it missed, then ticks at 1 kHz, until its supervisor calls the link lost (20 ms) and its
//! guard has ramped the torque out (150 ms). Frames that come later than that, with a ride time
//! that the controller has passed by itself, raise `time_jump`, which clears after one second of
//! regular ticks.

//!
//! What must be true for the drives' watchdogs. They are part of the plant and count ride time: 20
//! silent ticks, then a ramp of 180. That is 20 ms and 200 ms of the wall's clock as long as ride
//! time keeps up with it, and this is what the rule above is for. A ride that catches up lets ride
//! time run ahead of the wall's clock for at most 20 ticks, each of which still waits
//! [`ANSWER_WAIT`] for its answer: a controller that answers within that time is never taken for
//! silent. Moving the clock stands ride time still: the watchdogs do not count the time in which
//! the plant's process did not run, and a drive on a real bicycle, which has a clock of its own,
//! would have ramped out meanwhile. So slipped ticks are reported, and a ride with many of them is
//! no real-time ride.

use rustix::thread::ClockId;
use rustix::time::{Timespec, clock_gettime};
use std::time::Duration;

/// Length of a tick of the wall's clock.
pub const PERIOD: Duration = Duration::from_millis(1);
/// Ticks that a real-time ride catches up with at most.
pub const CATCH_UP_MAX: u64 = 20;
/// How long a real-time plant waits for the answer to its frame.
pub const ANSWER_WAIT: Duration = Duration::from_micros(600);
/// Ticks after which an answer is too old to be applied in real time.
pub const ANSWER_AGE_MAX: u64 = 20;
/// Silence after which a real-time controller goes on by its own clock: less than the 20 ms of its
/// supervisor and of the drives' watchdogs, so that there is time to wake up.
pub const LOSS_AFTER: Duration = Duration::from_millis(18);
/// How long before a tick a spinner stops sleeping.
const SPIN_BEFORE: Duration = Duration::from_micros(80);

/// What says when a tick begins.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Pacing {
    /// The answer to the tick before.
    #[default]
    Lockstep,
    /// The clock, 1000 times a second.
    RealTime,
}

impl Pacing {
    /// The name, as options and logs have it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Lockstep => "lockstep",
            Self::RealTime => "realtime",
        }
    }
}

impl std::str::FromStr for Pacing {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "lockstep" => Ok(Self::Lockstep),
            "realtime" => Ok(Self::RealTime),
            _ => Err(format!("`{text}` is no pacing: lockstep or realtime")),
        }
    }
}

/// The monotonic clock, ns; the same in all processes.
pub fn monotonic_ns() -> u64 {
    let now = clock_gettime(rustix::time::ClockId::Monotonic);
    now.tv_sec as u64 * 1_000_000_000 + now.tv_nsec as u64
}

/// Sleeps until `due_ns` of the monotonic clock.
fn sleep_until(due_ns: u64) {
    let due = Timespec {
        tv_sec: (due_ns / 1_000_000_000) as i64,
        tv_nsec: (due_ns % 1_000_000_000) as i64,
    };
    // A signal may wake us early.
    while rustix::thread::clock_nanosleep_absolute(ClockId::Monotonic, &due)
        == Err(rustix::io::Errno::INTR)
    {}
}

/// How a tick began.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Beat {
    /// How late, ns.
    pub late_ns: u64,
    /// Whole ticks by which the clock was moved before this one.
    pub slipped: u64,
}

/// A clock that strikes every [`PERIOD`].
#[derive(Debug)]
pub struct Metronome {
    due_ns: Option<u64>,
    spin: bool,
}

impl Metronome {
    /// A clock whose first strike is at the first call of [`wait`](Self::wait). A spinning one
    /// sleeps until shortly before each strike and then spins.
    pub fn new(spin: bool) -> Self {
        Self { due_ns: None, spin }
    }

    /// Waits for the next strike.
    pub fn wait(&mut self) -> Beat {
        let due_ns = *self.due_ns.get_or_insert_with(monotonic_ns);
        let mut now_ns = monotonic_ns();
        if now_ns < due_ns {
            let ahead_ns = if self.spin {
                SPIN_BEFORE.as_nanos() as u64
            } else {
                0
            };
            if now_ns + ahead_ns < due_ns {
                sleep_until(due_ns - ahead_ns);
            }
            now_ns = monotonic_ns();
            while now_ns < due_ns {
                std::hint::spin_loop();
                now_ns = monotonic_ns();
            }
        }
        let (next_ns, beat) = strike(due_ns, now_ns);
        self.due_ns = Some(next_ns);
        beat
    }
}

/// The rule for late ticks: when the next tick is due, and how this one began.
fn strike(due_ns: u64, now_ns: u64) -> (u64, Beat) {
    let period_ns = PERIOD.as_nanos() as u64;
    let late_ns = now_ns.saturating_sub(due_ns);
    let behind = late_ns / period_ns;
    let slipped = if behind > CATCH_UP_MAX { behind } else { 0 };
    (
        due_ns + (slipped + 1) * period_ns,
        Beat { late_ns, slipped },
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn late_ticks_are_caught_up_with_and_long_stops_move_the_clock() {
        let ms = 1_000_000;
        let beat = |late_ns, slipped| Beat { late_ns, slipped };
        assert_eq!(strike(5 * ms, 5 * ms), (6 * ms, beat(0, 0)));
        assert_eq!(strike(5 * ms, 5 * ms + 7), (6 * ms, beat(7, 0)));
        assert_eq!(strike(5 * ms, 25 * ms), (6 * ms, beat(20 * ms, 0)));
        // 21 ms behind: the next tick is due within a tick from now, not in the past.
        assert_eq!(strike(5 * ms, 26 * ms), (27 * ms, beat(21 * ms, 21)));
    }

    #[test]
    fn strikes_lie_on_the_grid_of_the_first_one() {
        for spin in [false, true] {
            let mut clock = Metronome::new(spin);
            clock.wait();
            let first_ns = clock.due_ns.expect("it has begun");
            for _ in 0..20 {
                clock.wait();
            }
            let last_ns = clock.due_ns.expect("it has begun");
            assert_eq!((last_ns - first_ns) % 1_000_000, 0);
            assert!(last_ns - first_ns >= 20_000_000);
        }
    }
}
