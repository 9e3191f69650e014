//! The loop of the controller process.

use crate::summary::Tally;
use crate::{Ended, Firmware, Summary};
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};
use twinhub_control::Config;
use twinhub_link::{ControllerEnd, LinkError, Settings};
use twinhub_types::{PlantFrame, RideState};

/// What the controller process is started with.
pub struct Options {
    /// Which ride to join, and how.
    pub settings: Settings,
    /// What the controller is built from.
    pub config: Config,
}

/// How long a plant may take to send its last frame after the stop flag was raised here: one
/// Ctrl-C reaches both processes, and the plant's last frame lets both end in order.
const GRACE: Duration = Duration::from_millis(80);
/// A ramp that has not ended after this many ticks never will.
const RAMP_TICKS_MAX: u32 = 60_000;

/// Joins a ride and answers its plant until the last frame.
///
/// When the link is lost, the controller runs on without frames until its watchdog has brought
/// the torques to zero, says so through `settings.notice`, and returns what happened to the link.
pub fn run(options: Options) -> Result<Summary, LinkError> {
    let Options { settings, config } = options;
    let notice = settings.notice.clone();
    let stop = settings.stop.clone();
    let mut end = ControllerEnd::connect(settings)?;
    let mut firmware = Firmware::new(&config);
    let mut tally = Tally::new();
    let mut asked_to_stop: Option<Instant> = None;
    let result = loop {
        let before = Instant::now();
        if stop.load(Ordering::Relaxed)
            && before.duration_since(*asked_to_stop.get_or_insert(before)) > GRACE
        {
            break Err(LinkError::Interrupted);
        }
        match answer(&mut end, &mut firmware, &mut tally, before) {
            Ok(RideState::Running) => {}
            Ok(state) => break Ok(state),
            Err(error) => break Err(error),
        }
    };
    match result {
        Ok(state) => {
            let ended = match state {
                RideState::Fell => Ended::Fell,
                RideState::Stopped => Ended::Stopped,
                RideState::Finished | RideState::Running => Ended::Finished,
            };
            // The plant has its answer, or is gone with it: either way the ride is complete.
            if let Err(error) = end.finish() {
                notice(&format!("after the last frame: {error}"));
            }
            Ok(tally.summary(ended))
        }
        Err(error) => {
            notice(&wind_down(&mut firmware, &error));
            Err(error)
        }
    }
}

/// One tick; `before` is when the waiting for its frame began.
#[inline]
fn answer(
    end: &mut ControllerEnd,
    firmware: &mut Firmware,
    tally: &mut Tally,
    before: Instant,
) -> Result<RideState, LinkError> {
    let frame: PlantFrame = end.receive()?;
    let arrived = Instant::now();
    let answer = firmware.tick(&frame);
    end.send(&answer)?;
    tally
        .compute_ns
        .saturating_record(arrived.elapsed().as_nanos() as u64);
    tally
        .wait_ns
        .saturating_record((arrived - before).as_nanos() as u64);
    tally.see(&answer.output);
    Ok(RideState::from_u32(frame.header.state))
}

/// Runs the controller without frames until its torques are zero; returns what to say.
fn wind_down(firmware: &mut Firmware, error: &LinkError) -> String {
    let pair = |firmware: &Firmware| {
        let command = firmware.output().command;
        (command.front_brake_nm, command.rear_traction_nm)
    };
    let (front, rear) = pair(firmware);
    let mut ticks = 0;
    while pair(firmware) != (0.0, 0.0) && ticks < RAMP_TICKS_MAX {
        firmware.tick_without_frame();
        ticks += 1;
    }
    let after = pair(firmware);
    let torque = if (front, rear) == (0.0, 0.0) {
        "there was no torque".to_owned()
    } else if after == (0.0, 0.0) {
        format!("torques ramped from {front:.1} and {rear:.1} Nm to zero in {ticks} ms")
    } else {
        format!(
            "torques are {:.1} and {:.1} Nm after {ticks} ms",
            after.0, after.1
        )
    };
    format!("{error}; {torque}")
}
