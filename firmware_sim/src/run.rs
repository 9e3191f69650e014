//! The loop of the controller process.

use crate::loss::{self, Loss, LossEvent};
use crate::summary::Tally;
use crate::{Ended, Firmware, Summary};
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};
use twinhub_control::Config;
use twinhub_link::pacing::LOSS_AFTER;
use twinhub_link::{ControllerEnd, LinkError, Pacing, Rights, Settings};
use twinhub_types::RideState;

/// What the controller process is started with.
pub struct Options {
    /// Which ride to join, and how.
    pub settings: Settings,
    /// What the controller is built from.
    pub config: Config,
    /// Told what happens when the link is lost.
    pub on_loss: Box<dyn FnMut(&LossEvent)>,
}

/// How long a plant may take to send its last frame after the stop flag was raised here: one
/// Ctrl-C reaches both processes, and the plant's last frame lets both end in order.
const GRACE: Duration = Duration::from_millis(80);
/// Ticks between two accounts to the plant.
const ACCOUNT_EVERY: u64 = 5_000;

/// Joins a ride and answers its plant until the last frame.
///
/// When the link is lost, the controller runs on without frames until its guard has brought the
/// torques to zero, says so through `settings.notice`, and returns what happened to the link.
///
/// # Errors
/// If no plant offers the ride, if it dies, leaves or breaks the protocol, or on the stop flag.
pub fn run(options: Options) -> Result<Summary, LinkError> {
    let Options {
        settings,
        config,
        mut on_loss,
    } = options;
    let notice = settings.notice.clone();
    let stop = settings.stop.clone();
    let mut end = ControllerEnd::connect(settings)?;
    let pacing = end.pacing();
    let rights = (pacing == Pacing::RealTime).then(Rights::acquire);
    let mut firmware = Firmware::new(&config);
    let mut tally = Tally::new();
    let mut asked_to_stop: Option<Instant> = None;
    let mut heard = Instant::now();
    let result = loop {
        if stop.load(Ordering::Relaxed) {
            let now = Instant::now();
            if now.duration_since(*asked_to_stop.get_or_insert(now)) > GRACE {
                break Err(LinkError::Interrupted);
            }
        }
        let deadline = match pacing {
            Pacing::Lockstep => None,
            // Before the first frame there is nothing to lose.
            Pacing::RealTime => (tally.ticks > 0).then(|| heard + LOSS_AFTER),
        };
        match answer(&mut end, &mut firmware, &mut tally, &mut heard, deadline) {
            Ok(Some(RideState::Running)) => {}
            Ok(Some(state)) => break Ok(state),
            Ok(None) => {
                let loss = Loss::new(heard, "no frame in time");
                on_loss(&LossEvent::Lost(loss.clone()));
                notice(&format!("{loss}; going on by our own clock"));
                if let Err(error) = loss::go_on_alone(
                    &mut end,
                    &mut firmware,
                    &mut tally,
                    loss.silence,
                    &mut on_loss,
                ) {
                    on_loss(&LossEvent::Lost(Loss::new(heard, &error.to_string())));
                    break Err(error);
                }
                heard = Instant::now();
            }
            Err(error) => {
                on_loss(&LossEvent::Lost(Loss::new(heard, &error.to_string())));
                break Err(error);
            }
        }
    };
    match result {
        Ok(state) => {
            let ended = match state {
                RideState::Fell => Ended::Fell,
                RideState::Stopped => Ended::Stopped,
                RideState::Finished | RideState::Running => Ended::Finished,
            };
            let frames_lost = end.frames_lost();
            // The plant has its answer, or is gone with it: either way the ride is complete.
            if let Err(error) = end.finish() {
                notice(&format!("after the last frame: {error}"));
            }
            Ok(tally.summary(ended, frames_lost, rights))
        }
        Err(error) => {
            notice(&loss::wind_down(
                &mut firmware,
                &error,
                pacing,
                &mut on_loss,
            ));
            Err(error)
        }
    }
}

/// One tick; `heard` is when the last answer was given. `None` if no frame came in time.
#[inline]
fn answer(
    end: &mut ControllerEnd,
    firmware: &mut Firmware,
    tally: &mut Tally,
    heard: &mut Instant,
    deadline: Option<Instant>,
) -> Result<Option<RideState>, LinkError> {
    let Some(frame) = end.receive_until(deadline)? else {
        return Ok(None);
    };
    let arrived = Instant::now();
    if let Some(time) = end.since_sent(&frame) {
        tally.wake_up_ns.saturating_record(time.as_nanos() as u64);
    }
    let answer = firmware.tick(&frame);
    let state = RideState::from_u32(frame.header.state);
    tally.see(&answer.output);
    if state != RideState::Running || tally.ticks.is_multiple_of(ACCOUNT_EVERY) {
        end.tell(&tally.account(end.frames_lost()));
    }
    end.send(&answer)?;
    let done = Instant::now();
    tally.computed(done - arrived);
    tally
        .wait_ns
        .saturating_record((arrived - *heard).as_nanos() as u64);
    *heard = done;
    Ok(Some(state))
}
