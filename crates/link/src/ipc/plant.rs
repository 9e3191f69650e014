//! The plant's end of a ride.

use super::settings::Settings;
use super::{PlantOffer, closed};
use crate::account::ControllerTiming;
use crate::hello::Role;
use crate::newest::Newest;
use crate::pacing::{ANSWER_WAIT, Pacing, monotonic_ns};
use crate::page::{Page, SENT_EVERY};
use crate::peer::{Peer, Woken};
use crate::protocol::{check_answer, check_hash};
use crate::ride::Claim;
use crate::shm::{Channels, ControllerSlot, PlantSlot};
use crate::wait::{NAP, Waiter};
use crate::{ControllerPort, LinkError};
use std::time::{Duration, Instant};
use twinhub_types::{ControllerFrame, PlantFrame};

/// The plant's end: the controller as the plant sees it, in another process.
pub struct PlantEnd {
    channels: Option<Channels<PlantSlot, ControllerSlot>>,
    peer: Peer,
    page: Page,
    waiter: Waiter,
    pacing: Pacing,
    newest: Newest,
    // Last: its destruction removes what the others leave in shared memory.
    #[allow(dead_code, reason = "held for its Drop")]
    claim: Claim,
}

impl PlantEnd {
    /// Offers the ride and waits for the controller.
    ///
    /// # Errors
    /// If the ride cannot be offered, or nobody joins.
    pub fn connect(settings: Settings) -> Result<Self, LinkError> {
        PlantOffer::open(settings)?.accept()
    }

    pub(super) fn new(
        settings: &Settings,
        channels: Channels<PlantSlot, ControllerSlot>,
        peer: Peer,
        page: Page,
        claim: Claim,
    ) -> Self {
        Self {
            channels: Some(channels),
            peer,
            page,
            waiter: settings.waiter(Role::Controller),
            pacing: settings.pacing,
            newest: Newest::default(),
            claim,
        }
    }

    /// Process id of the controller.
    pub fn peer_pid(&self) -> u32 {
        self.peer.pid
    }

    /// Sends `frame` without waiting.
    ///
    /// # Errors
    /// If the link is closed.
    #[inline]
    pub fn send(&mut self, frame: &PlantFrame) -> Result<(), LinkError> {
        let channels = self.channels.as_ref().ok_or_else(closed)?;
        if self.pacing == Pacing::RealTime || frame.header.sequence.is_multiple_of(SENT_EVERY) {
            self.page.sent(monotonic_ns());
        }
        channels.send(frame);
        if self.page.other_sleeps() {
            self.peer.ring(&self.page);
        }
        Ok(())
    }

    /// The next answer, whatever tick it belongs to; not validated. Waits until `deadline`, or
    /// without limit if there is none. `tick` only serves messages.
    ///
    /// # Errors
    /// If the controller dies or leaves, or the stop flag is raised.
    #[inline]
    pub fn receive(
        &mut self,
        tick: u64,
        deadline: Option<Instant>,
    ) -> Result<Option<ControllerFrame>, LinkError> {
        let channels = self.channels.as_mut().ok_or_else(closed)?;
        self.waiter
            .wait(&self.peer, &self.page, tick, deadline, || {
                channels.receive()
            })
    }

    /// The answer to be applied in real time: the newest one that comes in time.
    fn receive_in_time(
        &mut self,
        frame: &PlantFrame,
        deadline: Instant,
    ) -> Result<Option<ControllerFrame>, LinkError> {
        let (tick, sequence) = (frame.header.tick, frame.header.sequence);
        let mut found = None;
        while let Some(answer) = self.receive(tick, Some(deadline))? {
            check_hash("controller", &answer.header, tick)?;
            if self.newest.take(&answer, sequence) {
                found = Some(answer);
                if answer.header.sequence == sequence {
                    break;
                }
            }
        }
        Ok(found)
    }
}

impl ControllerPort for PlantEnd {
    #[inline]
    fn exchange_during(
        &mut self,
        frame: &PlantFrame,
        meanwhile: &mut dyn FnMut(),
    ) -> Result<Option<ControllerFrame>, LinkError> {
        self.send(frame)?;
        let deadline = (self.pacing == Pacing::RealTime).then(|| Instant::now() + ANSWER_WAIT);
        meanwhile();
        if let Some(deadline) = deadline {
            return self.receive_in_time(frame, deadline);
        }
        let (tick, sequence) = (frame.header.tick, frame.header.sequence);
        let answer = self.receive(tick, None)?.ok_or_else(closed)?;
        check_answer(&answer, tick, sequence)?;
        Ok(Some(answer))
    }

    fn controller_timing(&self) -> Option<ControllerTiming> {
        Some(ControllerTiming::from(&self.page.account()))
    }
}

impl Drop for PlantEnd {
    fn drop(&mut self) {
        // The controller leaves when it sees this, and closes its files before ours vanish.
        self.peer.half_close();
        let end = Instant::now() + Duration::from_secs(1);
        while Instant::now() < end {
            if matches!(self.peer.sleep(NAP), Woken::Died | Woken::Left) {
                break;
            }
        }
        self.channels = None;
    }
}
