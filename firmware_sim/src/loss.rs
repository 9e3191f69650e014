//! What the controller does when no frames come.

use crate::Firmware;
use crate::summary::Tally;
use std::time::{Duration, Instant};
use twinhub_link::pacing::{Metronome, PERIOD, monotonic_ns};
use twinhub_link::{ControllerEnd, LinkError, Pacing};

/// A ramp that has not ended after this many ticks never will.
const RAMP_TICKS_MAX: u32 = 60_000;

/// What the controller does about a lost link, as it happens.
#[derive(Clone, Debug, PartialEq)]
pub enum LossEvent {
    /// It has noticed.
    Lost(Loss),
    /// There is no torque any more.
    Quiet {
        /// The monotonic clock, ns.
        at_ns: u64,
        /// Ticks without a frame until then.
        ticks: u64,
    },
}

/// The moment in which the controller noticed that the link is lost.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Loss {
    /// The monotonic clock, ns.
    pub at_ns: u64,
    /// Since the last answer.
    pub silence: Duration,
    /// What was noticed.
    pub what: String,
}

impl Loss {
    pub(crate) fn new(heard: Instant, what: &str) -> Self {
        Self {
            at_ns: monotonic_ns(),
            silence: heard.elapsed(),
            what: what.to_owned(),
        }
    }
}

impl std::fmt::Display for Loss {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "{} for {:.1} ms",
            self.what,
            self.silence.as_secs_f64() * 1e3
        )
    }
}

/// Makes up for the ticks of `silence`, then ticks without frames at 1 kHz until one comes, or
/// until there is no torque; from then on waits for a plant that lives without limit. Leaves the
/// frame that ends the silence where it is.
///
/// # Errors
/// If the plant dies or leaves, or the stop flag is raised.
pub(crate) fn go_on_alone(
    end: &mut ControllerEnd,
    firmware: &mut Firmware,
    tally: &mut Tally,
    silence: Duration,
    tell: &mut dyn FnMut(&LossEvent),
) -> Result<(), LinkError> {
    let before = tally.silent_ticks;
    for _ in 0..silence.as_millis() {
        firmware.tick_without_frame();
        tally.silent_ticks += 1;
    }
    let mut due = Instant::now();
    while !firmware.is_quiet() {
        due += PERIOD;
        if end.wait_until(Some(due))? {
            return Ok(());
        }
        firmware.tick_without_frame();
        tally.silent_ticks += 1;
    }
    tell(&LossEvent::Quiet {
        at_ns: monotonic_ns(),
        ticks: tally.silent_ticks - before,
    });
    end.wait_until(None).map(|_came| ())
}

/// Runs the controller without frames until its torques are zero; returns what to say. In real
/// time these ticks take real time.
pub(crate) fn wind_down(
    firmware: &mut Firmware,
    error: &LinkError,
    pacing: Pacing,
    tell: &mut dyn FnMut(&LossEvent),
) -> String {
    let torques = |firmware: &Firmware| {
        let command = firmware.output().command;
        (command.front_brake_nm, command.rear_traction_nm)
    };
    let mut clock = (pacing == Pacing::RealTime).then(|| Metronome::new(false));
    let (front, rear) = torques(firmware);
    let mut ticks = 0;
    while !firmware.is_quiet() && ticks < RAMP_TICKS_MAX {
        if let Some(clock) = &mut clock {
            clock.wait();
        }
        firmware.tick_without_frame();
        ticks += 1;
    }
    let after = torques(firmware);
    if !firmware.is_quiet() {
        return format!(
            "{error}; torques are {:.1} and {:.1} Nm after {ticks} ms",
            after.0, after.1
        );
    }
    tell(&LossEvent::Quiet {
        at_ns: monotonic_ns(),
        ticks: ticks.into(),
    });
    if (front, rear) == (0.0, 0.0) {
        format!("{error}; there was no torque")
    } else {
        format!("{error}; torques ramped from {front:.1} and {rear:.1} Nm to zero in {ticks} ms")
    }
}
