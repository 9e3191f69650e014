//! The plant's offer of a ride, until its controller has joined.

use super::plant::PlantEnd;
use super::settings::{Patience, Settings};
use crate::LinkError;
use crate::hello::{HELLO_BYTES, Hello, Role};
use crate::page::Page;
use crate::peer::{Peer, wait_readable};
use crate::ride::{Claim, session_root};
use crate::shm::{Channels, ControllerSlot, PlantSlot};
use crate::wait::NAP;
use rustix::net::{RecvFlags, SendAncillaryBuffer, SendAncillaryMessage, SendFlags, recv, sendmsg};
use std::io::IoSlice;
use std::mem::MaybeUninit;
use std::os::fd::{AsFd, OwnedFd};
use std::os::unix::net::{UnixListener, UnixStream};
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

/// A ride that waits for its controller: its services exist, nobody has joined yet.
pub struct PlantOffer {
    settings: Settings,
    listener: UnixListener,
    channels: Channels<PlantSlot, ControllerSlot>,
    page: Page,
    page_file: OwnedFd,
    claim: Claim,
}

impl PlantOffer {
    /// Takes the name of the ride, clears away dead rides, and creates everything that the
    /// controller will find.
    pub fn open(settings: Settings) -> Result<Self, LinkError> {
        let claim = Claim::new(&settings.run_dir, &settings.ride)?;
        let root = session_root(&settings.run_dir.ride(&settings.ride), claim.session());
        let channels = Channels::new(Role::Plant, &root, claim.session())?;
        let (page, page_file) = Page::create(Role::Plant)?;
        let path = settings.socket();
        let listener =
            UnixListener::bind(&path).map_err(|e| LinkError::io("offering the ride", &path, e))?;
        listener
            .set_nonblocking(true)
            .map_err(|e| LinkError::io("offering the ride", &path, e))?;
        Ok(Self {
            settings,
            listener,
            channels,
            page,
            page_file,
            claim,
        })
    }

    /// Waits for the controller and shakes hands.
    pub fn accept(self) -> Result<PlantEnd, LinkError> {
        let mut patience = Patience::new(&self.settings, Role::Controller);
        loop {
            patience.check()?;
            if !wait_readable(&self.listener, NAP) {
                continue;
            }
            let Ok((socket, _)) = self.listener.accept() else {
                continue;
            };
            match self.greet(socket) {
                Ok(Some(peer)) => {
                    let _ = std::fs::remove_file(self.settings.socket());
                    return Ok(PlantEnd::new(
                        &self.settings,
                        self.channels,
                        peer,
                        self.page,
                        self.claim,
                    ));
                }
                Ok(None) => {}
                Err(LinkError::OtherUser { pid, uid, .. }) => {
                    (self.settings.notice)(&format!("process {pid} of user {uid} was turned away"));
                }
                Err(error) => return Err(error),
            }
        }
    }

    /// `None` if the visitor was no controller, or left before it was ready.
    fn greet(&self, socket: UnixStream) -> Result<Option<Peer>, LinkError> {
        let peer = match Peer::new(socket) {
            Err(LinkError::PeerDied { .. }) => return Ok(None),
            other => other?,
        };
        let silent = |what: &str| {
            (self.settings.notice)(&format!("process {} was turned away: {what}", peer.pid));
            Ok(None)
        };
        let mut bytes = [0; HELLO_BYTES];
        if !self.read(&peer, &mut bytes)? {
            return silent("it said nothing");
        }
        let Some(theirs) = Hello::parse(&bytes) else {
            return silent("it is no twinhub program");
        };
        let mut ours = Hello::new(
            Role::Plant,
            &self.settings.identity,
            self.claim.session(),
            self.settings.pacing,
        );
        let verdict = ours.accept(&theirs, peer.pid);
        ours.refused = verdict.is_err();
        let page = [self.page_file.as_fd()];
        let mut space = [MaybeUninit::uninit(); rustix::cmsg_space!(ScmRights(1))];
        let mut rights = SendAncillaryBuffer::new(&mut space);
        if verdict.is_ok() {
            rights.push(SendAncillaryMessage::ScmRights(&page));
        }
        let sent = sendmsg(
            &peer.socket,
            &[IoSlice::new(&ours.bytes())],
            &mut rights,
            SendFlags::NOSIGNAL,
        );
        verdict?;
        let mut ready = [0];
        if sent != Ok(HELLO_BYTES) || !self.read(&peer, &mut ready)? || ready != *b"r" {
            return silent("it left before it was ready");
        }
        Ok(Some(peer))
    }

    /// Reads what a visitor says; false if it says nothing for 5 s, leaves or dies.
    fn read(&self, peer: &Peer, bytes: &mut [u8]) -> Result<bool, LinkError> {
        let end = Instant::now() + Duration::from_secs(5);
        let mut filled = 0;
        while filled < bytes.len() {
            if self.settings.stop.load(Ordering::Relaxed) {
                return Err(LinkError::Interrupted);
            }
            if Instant::now() >= end {
                return Ok(false);
            }
            if !wait_readable(&peer.socket, NAP) {
                continue;
            }
            match recv(&peer.socket, &mut bytes[filled..], RecvFlags::DONTWAIT) {
                Ok((_, n)) if n > 0 => filled += n,
                Err(rustix::io::Errno::INTR | rustix::io::Errno::AGAIN) => {}
                _ => return Ok(false),
            }
        }
        Ok(true)
    }
}
