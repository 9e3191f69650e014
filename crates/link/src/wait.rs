//! Waiting for the other side: spin, then sleep until it rings.
//!
//! Spinning answers within microseconds but takes a core; it pays while both sides run on cores
//! of their own. The time spent on it follows success: a wait that ends while spinning doubles
//! the next one's limit, one that does not halves it down to none. Now and then a wait tries the
//! full limit and keeps it where that succeeds: every 64th, and more rarely the more often
//! spinning fails. So a single core, or a machine with other work, falls back to sleeping by
//! itself. Two sides that find themselves on one core of several part. There is no yielding in
//! between: it hands the core to whatever else runs for a whole
//! time slice, while a sleeper that is rung gets it back at once.

use crate::LinkError;
use crate::cores::step_off;
use crate::hello::Role;
use crate::page::Page;
use crate::peer::{Peer, Woken};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// How a side waits for the other.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Waiting {
    /// Spin as long as that succeeds: fastest, takes the core.
    #[default]
    Spin,
    /// Sleep at once: 30 to 100 µs a tick, leaves the core to others.
    Block,
}

impl Waiting {
    /// The name, as options have it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Spin => "spin",
            Self::Block => "block",
        }
    }
}

impl std::str::FromStr for Waiting {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "spin" => Ok(Self::Spin),
            "block" => Ok(Self::Block),
            _ => Err(format!("`{text}` is no way of waiting: spin or block")),
        }
    }
}

/// Longest spin: more than what a thread that writes a log takes from a core at a time.
const SPIN_MAX: Duration = Duration::from_micros(500);
/// A shorter spin than this catches nothing; sleep at once instead.
const SPIN_MIN: Duration = Duration::from_micros(6);
/// Waits between two tries of the longest spin, while spinning succeeds.
const PROBE_MIN: u64 = 64;
/// The same, while it fails again and again.
const PROBE_MAX: u64 = 4096;
/// Sleeps between two looks whether both sides are on one core.
const STEP_OFF_EVERY: u64 = 64;
/// Longest sleep before the stop flag is looked at.
pub(crate) const NAP: Duration = Duration::from_millis(20);
/// How often a long wait is reported.
const REPORT: Duration = Duration::from_secs(5);

/// Where messages to the user go.
pub type Notice = Arc<dyn Fn(&str) + Send + Sync>;

pub(crate) struct Waiter {
    waiting: Waiting,
    limit: Duration,
    waits: u64,
    probe_after: u64,
    stop: Arc<AtomicBool>,
    notice: Notice,
    other: Role,
    /// Sleeps so far.
    sleeps: u64,
}

impl Waiter {
    pub(crate) fn new(
        waiting: Waiting,
        stop: Arc<AtomicBool>,
        notice: Notice,
        other: Role,
    ) -> Self {
        Self {
            waiting,
            limit: SPIN_MAX,
            waits: 0,
            probe_after: PROBE_MIN,
            stop,
            notice,
            other,
            sleeps: 0,
        }
    }

    /// Waits until `take` yields something; for tick `tick`, which only messages mention.
    ///
    /// With a `deadline`, gives up then and returns `None`; without, waits as long as the other
    /// process lives and the stop flag is down; only such a wait looks at the flag.
    #[inline]
    pub(crate) fn wait<T>(
        &mut self,
        peer: &Peer,
        page: &Page,
        tick: u64,
        deadline: Option<Instant>,
        mut take: impl FnMut() -> Option<T>,
    ) -> Result<Option<T>, LinkError> {
        if self.waiting == Waiting::Spin {
            self.waits += 1;
            let probe = self.waits >= self.probe_after;
            // A limit of zero still looks for a frame before it sleeps.
            let limit = if probe { SPIN_MAX } else { self.limit };
            if probe {
                self.waits = 0;
            }
            if let Some(frame) = spin(limit, &mut take) {
                if probe {
                    self.limit = SPIN_MAX;
                } else if !limit.is_zero() {
                    self.limit = (limit * 2).min(SPIN_MAX);
                    self.probe_after = (self.probe_after / 2).max(PROBE_MIN);
                }
                return Ok(Some(frame));
            }
            if !limit.is_zero() {
                self.probe_after = (self.probe_after * 2).min(PROBE_MAX);
            }
            let shorter = self.limit / 2;
            self.limit = if shorter < SPIN_MIN {
                Duration::ZERO
            } else {
                shorter
            };
        }
        self.sleep(peer, page, tick, deadline, take)
    }

    #[cold]
    fn sleep<T>(
        &mut self,
        peer: &Peer,
        page: &Page,
        tick: u64,
        deadline: Option<Instant>,
        mut take: impl FnMut() -> Option<T>,
    ) -> Result<Option<T>, LinkError> {
        let start = Instant::now();
        let mut report = start + REPORT;
        let found = loop {
            page.lie_down();
            if let Some(frame) = take() {
                break Some(frame);
            }
            let now = Instant::now();
            let nap = deadline.map_or(NAP, |end| end.saturating_duration_since(now).min(NAP));
            let woken = if nap.is_zero() {
                Woken::Timeout
            } else {
                peer.sleep(nap)
            };
            page.get_up();
            if let Some(frame) = take() {
                break Some(frame);
            }
            match woken {
                Woken::Died => {
                    return Err(LinkError::PeerDied {
                        pid: peer.pid,
                        tick,
                    });
                }
                Woken::Left => {
                    return Err(LinkError::PeerLeft {
                        pid: peer.pid,
                        tick,
                    });
                }
                Woken::Timeout | Woken::Rung => {}
            }
            // A wait with a deadline ends soon by itself, and its ride with a last frame.
            if deadline.is_none() && self.stop.load(Ordering::Relaxed) {
                return Err(LinkError::Interrupted);
            }
            let now = Instant::now();
            if deadline.is_some_and(|end| now >= end) {
                break None;
            }
            if now >= report {
                let (other, pid, s) = (self.other.name(), peer.pid, (now - start).as_secs());
                (self.notice)(&format!(
                    "waiting for the {other} (pid {pid}) at tick {tick} for {s} s; it lives, but does not answer"
                ));
                report = now + REPORT;
            }
        };
        page.get_up();
        self.keep_apart(page);
        Ok(found)
    }

    /// Spinning fails for good when both sides share a core, and sides that sleep in turn look to
    /// the system as if one core were enough: the controller steps off the plant's.
    fn keep_apart(&mut self, page: &Page) {
        let try_now = self.sleeps.is_multiple_of(STEP_OFF_EVERY);
        self.sleeps += 1;
        if try_now
            && self.waiting == Waiting::Spin
            && self.other == Role::Plant
            && let Some(core) = page.other_core()
            && step_off(core)
        {
            self.limit = SPIN_MAX;
        }
    }
}

#[inline]
fn spin<T>(limit: Duration, take: &mut impl FnMut() -> Option<T>) -> Option<T> {
    let mut end = None;
    loop {
        for _ in 0..16 {
            if let Some(frame) = take() {
                return Some(frame);
            }
            std::hint::spin_loop();
        }
        let now = Instant::now();
        if now >= *end.get_or_insert(now + limit) {
            return None;
        }
    }
}
