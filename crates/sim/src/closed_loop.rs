//! The closed loop, once a tick: sensors, controller, rider, motors, disturbances, plant.
//!
//! At tick k (ride time k ms) the sensors are read and the controller is asked; its torques, the
//! rider's action and the disturbances act from k to k + 1 ms.

use crate::bench::{Bench, OwnRider};
use crate::error::RideError;
use crate::logger::Logger;
use crate::metrics::{Metrics, Sums};
use crate::setup::Ride;
use crate::{TICK, TICK_S};
use std::path::PathBuf;
use twinhub_link::protocol::is_plausible;
use twinhub_link::{ControllerPort, Faulty, LinkError, Pacing, Timing};
use twinhub_log::Level;
use twinhub_types::{Instant, RideState};

/// What a ride needs beside the [`Ride`] itself.
#[derive(Clone, Debug)]
pub struct Settings {
    /// Where the log is written; `None` writes none (and there is no digest).
    pub log: Option<PathBuf>,
    /// Version of the program, for the log.
    pub version: String,
    /// Commit of the program, for the log.
    pub git_hash: String,
}

/// How far a ride is.
#[derive(Clone, Copy, Debug)]
pub struct Progress {
    /// Ticks ridden.
    pub tick: u64,
    /// Ticks of the whole course.
    pub ticks: u64,
}

/// How a ride ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ending {
    /// The course is finished.
    Finished,
    /// The bicycle fell.
    Fell,
    /// The watcher asked to stop.
    Stopped,
}

/// What a ride came to.
#[derive(Clone, Debug, PartialEq)]
pub struct Outcome {
    /// How it ended.
    pub ending: Ending,
    /// Its numbers.
    pub metrics: Metrics,
    /// Digest of its log, 32 hex characters; empty without a log.
    pub digest: String,
    /// Its log.
    pub log: Option<PathBuf>,
}

/// Ticks that the torques get to ramp out when a ride is stopped or the controller is lost: longer
/// than the ramps of the controller (2 s) and of the drives (0.2 s).
const RAMP_OUT_TICKS: u64 = 2_500;

/// Records of the link's timing in the log, every so many ticks.
const LINK_EVERY: u64 = 5_000;
/// Ticks of silence after which the log says so: half of what the drives' watchdogs allow.
pub const SILENCE_TICKS: u64 = 10;

/// Rides `ride` with the controller behind `port`. `watch` is called every tick and returns false
/// to stop the ride.
///
/// # Errors
/// If the ride cannot be set up, the link fails or the log cannot be written. A fall is an
/// outcome. When the link fails, the log is finished and holds everything up to that tick.
pub fn ride(
    ride: &Ride,
    settings: &Settings,
    port: &mut impl ControllerPort,
    watch: &mut dyn FnMut(Progress) -> bool,
) -> Result<Outcome, RideError> {
    ride_as(ride, settings, port, None, watch)
}

/// The same under a rider of the caller's own, if there is one; pedals are theirs too.
///
/// # Errors
/// As [`ride`].
pub fn ride_as(
    ride: &Ride,
    settings: &Settings,
    port: &mut impl ControllerPort,
    own: Option<OwnRider<'_>>,
    watch: &mut dyn FnMut(Progress) -> bool,
) -> Result<Outcome, RideError> {
    let mut bench = Bench::new(ride, own)?;
    let mut logger = match &settings.log {
        Some(path) => {
            let real_time = |t: Timing| t.pacing == Pacing::RealTime.name();
            let real_time = port.timing().is_some_and(real_time);
            Some(Logger::create(path, ride, settings, real_time)?)
        }
        None => None,
    };
    let mut port = Faulty::new(port, &ride.course.link_fault, ride.course.seed);
    let ticks = ride.ticks();
    let mut sums = Sums::default();
    let mut lost: Option<LinkError> = None;
    let mut stop_at = ticks;
    let mut stopped = false;
    let mut tick = 0;
    let mut missed_ticks = 0;
    let mut silent_ticks = 0;
    let ending = loop {
        let now = Instant::from_nanos(tick * TICK.as_nanos());
        let truth = bench.plant.truth();
        if !truth.is_finite() {
            return Err(RideError::NotFinite { tick });
        }
        if !stopped && !watch(Progress { tick, ticks }) {
            // The rider switches off; the controller gets the time to ramp out.
            (stopped, bench.assist_on) = (true, false);
            stop_at = stop_at.min(tick + RAMP_OUT_TICKS);
        }
        let fell = truth.roll_rad.abs() > bench.plant.fall_roll_rad();
        let quiet = stopped && bench.torque_is_zero();
        let state = if fell {
            RideState::Fell
        } else if quiet || (stopped && tick >= stop_at) {
            RideState::Stopped
        } else if tick >= stop_at {
            RideState::Finished
        } else {
            RideState::Running
        };
        let frame = bench.frame(now, tick, state, &truth);
        let mut acts = None;
        let mut act = || acts = Some(bench.act(now, &truth));
        let answer = match &lost {
            None => match port.exchange_during(&frame, &mut act) {
                Ok(answer) => {
                    let usable = answer.filter(is_plausible);
                    if let (Some(log), None, Some(answer)) = (&mut logger, &usable, &answer)
                        && silent_ticks == 0
                    {
                        let command = &answer.output.command;
                        let text = format!("an absurd command counts as silence: {command:?}");
                        log.event(now, Level::Warning, "link.absurd", &text)?;
                    }
                    usable
                }
                Err(error) => {
                    // The drives' own watchdogs take the torque out now.
                    if let Some(log) = &mut logger {
                        log.event(now, Level::Error, "link", &error.to_string())?;
                    }
                    lost = Some(error);
                    stop_at = stop_at.min(tick + RAMP_OUT_TICKS);
                    None
                }
            },
            Some(_) => None,
        };
        if let Some(log) = &mut logger {
            while let Some(event) = port.next_event() {
                log.link_event(now, &event)?;
            }
            if tick.is_multiple_of(LINK_EVERY) && tick > 0 {
                log.link(now, port.timing().as_ref())?;
            }
        }
        if state != RideState::Running || (lost.is_some() && bench.torque_is_zero()) {
            break state;
        }
        missed_ticks += u64::from(answer.is_none());
        silent_ticks = if answer.is_some() {
            0
        } else {
            silent_ticks + 1
        };
        if let Some(log) = &mut logger
            && silent_ticks == SILENCE_TICKS
            && lost.is_none()
        {
            let text = format!("no answer for {SILENCE_TICKS} ms; the drives ramp out after 20 ms");
            log.event(now, Level::Warning, "link.silence", &text)?;
        }
        let acts = acts.unwrap_or_else(|| bench.act(now, &truth));
        let (row, rider) = bench.step(now, &truth, &acts, answer.as_ref());
        sums.add(&row, &rider, TICK_S);
        if let Some(log) = &mut logger {
            log.tick(
                now,
                tick,
                &row,
                &rider,
                &frame,
                answer.as_ref().map(|a| &a.output),
            )?;
        }
        tick += 1;
    };
    let ending = match ending {
        RideState::Fell => Ending::Fell,
        RideState::Stopped => Ending::Stopped,
        RideState::Finished | RideState::Running => Ending::Finished,
    };
    let metrics = sums.finish(ending == Ending::Fell, missed_ticks);
    if let Some(log) = &mut logger
        && ending == Ending::Fell
    {
        let now = Instant::from_nanos(tick * TICK.as_nanos());
        log.event(now, Level::Error, "plant.fell", "the bicycle fell")?;
    }
    if let Some(log) = &mut logger {
        log.link(
            Instant::from_nanos(tick * TICK.as_nanos()),
            port.timing().as_ref(),
        )?;
    }
    let summary = logger.map(|log| log.finish(&metrics)).transpose()?;
    if let Some(error) = lost {
        return Err(error.into());
    }
    let (digest, log) = summary.map_or((String::new(), None), |s| (s.digest, Some(s.path)));
    Ok(Outcome {
        ending,
        metrics,
        digest,
        log,
    })
}
