//! The controller's end of a ride.

use super::closed;
use super::settings::{Patience, Settings};
use crate::LinkError;
use crate::account::Account;
use crate::hello::{HELLO_BYTES, Hello, Role};
use crate::pacing::{Pacing, monotonic_ns};
use crate::page::{Page, SENT_EVERY};
use crate::peer::{Peer, wait_readable};
use crate::protocol::{check_frame, check_hash};
use crate::ride::{RunDir, session_root, sweep};
use crate::shm::{Channels, ControllerSlot, PlantSlot};
use crate::wait::{NAP, Waiter};
use rustix::net::{RecvAncillaryBuffer, RecvAncillaryMessage, RecvFlags, recvmsg};
use std::io::{IoSliceMut, Write};
use std::mem::MaybeUninit;
use std::os::fd::OwnedFd;
use std::os::unix::net::UnixStream;
use std::time::{Duration, Instant};
use twinhub_types::{ControllerFrame, PlantFrame};

/// The controller's end.
pub struct ControllerEnd {
    channels: Option<Channels<ControllerSlot, PlantSlot>>,
    peer: Peer,
    page: Page,
    waiter: Waiter,
    run_dir: RunDir,
    pacing: Pacing,
    /// Sequence of the next frame.
    next: u64,
    lost: u64,
    plant_gone: bool,
}

impl ControllerEnd {
    /// Joins the ride, waiting for its plant to offer it.
    pub fn connect(settings: Settings) -> Result<Self, LinkError> {
        let mut patience = Patience::new(&settings, Role::Plant);
        let path = settings.socket();
        loop {
            patience.check()?;
            // A directory that others can enter could hold anybody's plant.
            if settings.run_dir.path().exists() {
                settings.run_dir.check()?;
            }
            let Ok(socket) = UnixStream::connect(&path) else {
                std::thread::sleep(Duration::from_millis(5));
                continue;
            };
            let peer = match Peer::new(socket) {
                Err(LinkError::PeerDied { .. }) => continue,
                other => other?,
            };
            if let Some(end) = Self::greet(&settings, peer, &mut patience)? {
                return Ok(end);
            }
        }
    }

    /// `None` if the plant hung up before it answered.
    fn greet(
        settings: &Settings,
        peer: Peer,
        patience: &mut Patience,
    ) -> Result<Option<Self>, LinkError> {
        let ours = Hello::new(Role::Controller, &settings.identity, 0, settings.pacing);
        if (&peer.socket).write_all(&ours.bytes()).is_err() {
            return Ok(None);
        }
        let mut bytes = [0; HELLO_BYTES];
        let mut filled = 0;
        let mut page = None;
        while filled < HELLO_BYTES {
            patience.check()?;
            if !wait_readable(&peer.socket, NAP) {
                continue;
            }
            match receive_hello(&peer.socket, &mut bytes[filled..], &mut page) {
                Ok(n) if n > 0 => filled += n,
                Err(rustix::io::Errno::INTR | rustix::io::Errno::AGAIN) => {}
                _ => return Ok(None),
            }
        }
        let theirs = Hello::parse(&bytes).ok_or_else(|| {
            LinkError::shared_memory("joining the ride", "its owner is no twinhub program")
        })?;
        ours.accept(&theirs, peer.pid)?;
        let page = page.ok_or_else(|| {
            LinkError::shared_memory("joining the ride", "the plant sent no shared page")
        })?;
        let page = Page::open(Role::Controller, &page)?;
        let root = session_root(&settings.run_dir.ride(&settings.ride), theirs.session);
        let channels = match Channels::new(Role::Controller, &root, theirs.session) {
            // A plant that was killed meanwhile may have been swept away.
            Err(_) if peer.dead_within(Duration::from_millis(50)) => return Ok(None),
            other => other?,
        };
        if (&peer.socket).write_all(b"r").is_err() {
            return Ok(None);
        }
        Ok(Some(Self {
            channels: Some(channels),
            peer,
            page,
            waiter: settings.waiter(Role::Plant),
            run_dir: settings.run_dir.clone(),
            pacing: theirs.pacing,
            next: 0,
            lost: 0,
            plant_gone: false,
        }))
    }

    /// Process id of the plant.
    pub fn peer_pid(&self) -> u32 {
        self.peer.pid
    }

    /// What says when a tick begins, as the plant told.
    pub fn pacing(&self) -> Pacing {
        self.pacing
    }

    /// Frames that never came, seen by gaps in their count; only real time has gaps.
    pub fn frames_lost(&self) -> u64 {
        self.lost
    }

    /// From the plant's sending of `frame` to now, as far as the plant says; in lockstep it says so
    /// of one frame out of 16.
    #[inline]
    pub fn since_sent(&self, frame: &PlantFrame) -> Option<Duration> {
        let noted =
            self.pacing == Pacing::RealTime || frame.header.sequence.is_multiple_of(SENT_EVERY);
        noted.then(|| Duration::from_nanos(monotonic_ns().saturating_sub(self.page.sent_ns())))
    }

    /// The plant's next frame, validated. Waits without limit for a plant that lives.
    ///
    /// # Errors
    /// If the plant dies, leaves or breaks the protocol, or the stop flag is raised.
    #[inline]
    pub fn receive(&mut self) -> Result<PlantFrame, LinkError> {
        self.receive_until(None)?.ok_or_else(closed)
    }

    /// The plant's next frame, validated; `None` if none came before `deadline`.
    ///
    /// # Errors
    /// As [`receive`](Self::receive).
    #[inline]
    pub fn receive_until(
        &mut self,
        deadline: Option<Instant>,
    ) -> Result<Option<PlantFrame>, LinkError> {
        loop {
            let channels = self.channels.as_mut().ok_or_else(closed)?;
            let next = self.next;
            let frame = self
                .waiter
                .wait(&self.peer, &self.page, next, deadline, || {
                    channels.receive()
                });
            let frame = match frame {
                Ok(Some(frame)) => frame,
                Ok(None) => return Ok(None),
                Err(error) => {
                    self.plant_gone = true;
                    return Err(error);
                }
            };
            match self.pacing {
                Pacing::Lockstep => check_frame(&frame, next, next)?,
                Pacing::RealTime => {
                    check_hash("plant", &frame.header, next)?;
                    // A blackboard that is written to while it is read may give a frame twice.
                    if frame.header.sequence < next {
                        if deadline.is_some_and(|end| Instant::now() >= end) {
                            return Ok(None);
                        }
                        continue;
                    }
                    self.lost = self.lost.saturating_add(frame.header.sequence - next);
                }
            }
            self.next = frame.header.sequence.saturating_add(1);
            return Ok(Some(frame));
        }
    }

    /// Waits until the next frame is there, and leaves it there; false if none came before
    /// `deadline`.
    ///
    /// # Errors
    /// If the plant dies or leaves, or the stop flag is raised.
    pub fn wait_until(&mut self, deadline: Option<Instant>) -> Result<bool, LinkError> {
        let channels = self.channels.as_ref().ok_or_else(closed)?;
        let came = self
            .waiter
            .wait(&self.peer, &self.page, self.next, deadline, || {
                channels.has_news().then_some(())
            });
        self.plant_gone |= came.is_err();
        Ok(came?.is_some())
    }

    /// Answers the plant.
    ///
    /// # Errors
    /// If the link is closed.
    #[inline]
    pub fn send(&mut self, frame: &ControllerFrame) -> Result<(), LinkError> {
        let channels = self.channels.as_ref().ok_or_else(closed)?;
        channels.send(frame);
        if self.page.other_sleeps() {
            self.peer.ring(&self.page);
        }
        Ok(())
    }

    /// Tells the plant how the controller does; put down before the answer to the last frame.
    pub fn tell(&self, account: &Account) {
        self.page.put_account(account);
    }

    /// After the answer to the last frame: waits until the plant has taken it and hangs up.
    pub fn finish(mut self) -> Result<(), LinkError> {
        let nothing = || None::<()>;
        let ended = self
            .waiter
            .wait(&self.peer, &self.page, self.next, None, nothing);
        self.plant_gone = true;
        match ended {
            Err(LinkError::PeerLeft { .. }) | Ok(_) => Ok(()),
            Err(error) => Err(error),
        }
    }
}

impl Drop for ControllerEnd {
    fn drop(&mut self) {
        self.channels = None;
        // A plant that died cannot clean up: the survivor does.
        if self.plant_gone && self.peer.dead_within(Duration::ZERO) {
            sweep(&self.run_dir);
        }
    }
}

fn receive_hello(
    socket: &UnixStream,
    bytes: &mut [u8],
    page: &mut Option<OwnedFd>,
) -> rustix::io::Result<usize> {
    let mut space = [MaybeUninit::uninit(); rustix::cmsg_space!(ScmRights(1))];
    let mut rights = RecvAncillaryBuffer::new(&mut space);
    let flags = RecvFlags::DONTWAIT | RecvFlags::CMSG_CLOEXEC;
    let got = recvmsg(socket, &mut [IoSliceMut::new(bytes)], &mut rights, flags)?;
    for message in rights.drain() {
        if let RecvAncillaryMessage::ScmRights(files) = message {
            *page = files.last().or(page.take());
        }
    }
    Ok(got.bytes)
}
