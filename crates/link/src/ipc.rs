//! Both ends of a ride between two processes.
//!
//! The ends belong to the thread that made them. A stop flag ends every wait within 20 ms; it is
//! looked at only while waiting, so that a ride that is stopped can still exchange its last frame.

use crate::bell::Bell;
use crate::hello::{HELLO_BYTES, Hello, Identity, Role};
use crate::peer::{Peer, Woken, wait_readable};
use crate::protocol::{check_answer, check_frame};
use crate::ride::{Claim, RideName, RunDir, session_root, sweep};
use crate::shm::{Channels, ControllerSlot, PlantSlot};
use crate::wait::{NAP, Notice, Waiter, Waiting};
use crate::{ControllerPort, LinkError};
use rustix::net::{
    RecvAncillaryBuffer, RecvAncillaryMessage, RecvFlags, SendAncillaryBuffer,
    SendAncillaryMessage, SendFlags, recv, recvmsg, sendmsg,
};
use std::io::{IoSlice, IoSliceMut, Write};
use std::mem::MaybeUninit;
use std::os::fd::{AsFd, OwnedFd};
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};
use twinhub_types::{ControllerFrame, PlantFrame, RideState};

/// How to join a ride.
#[derive(Clone)]
pub struct Settings {
    /// Name of the ride.
    pub ride: RideName,
    /// How this side waits for the other.
    pub waiting: Waiting,
    /// How long to wait for the other side to turn up; `None` waits without limit.
    pub patience: Option<Duration>,
    /// Raised from outside (Ctrl-C), ends every wait with [`LinkError::Interrupted`].
    pub stop: Arc<AtomicBool>,
    /// Where messages to the user go; standard error unless changed.
    pub notice: Notice,
    /// The directory of the rides.
    pub run_dir: RunDir,
    /// What this side says about itself.
    pub identity: Identity,
}

impl Settings {
    /// Joins `ride`: spinning, waiting 10 s for the other side, messages to standard error.
    pub fn new(ride: RideName) -> Self {
        Self {
            ride,
            waiting: Waiting::Spin,
            patience: Some(Duration::from_secs(10)),
            stop: Arc::new(AtomicBool::new(false)),
            notice: Arc::new(|text| eprintln!("{text}")),
            run_dir: RunDir::from_env(),
            identity: Identity::default(),
        }
    }

    fn socket(&self) -> PathBuf {
        self.run_dir.socket(&self.ride)
    }

    fn waiter(&self, other: Role) -> Waiter {
        Waiter::new(
            self.waiting,
            self.stop.clone(),
            self.notice.clone(),
            other.name(),
        )
    }
}

/// Time until the other side has to be there.
struct Patience<'a> {
    settings: &'a Settings,
    wanted: Role,
    start: Instant,
    report: Instant,
}

impl<'a> Patience<'a> {
    const REPORT: Duration = Duration::from_secs(5);

    fn new(settings: &'a Settings, wanted: Role) -> Self {
        let start = Instant::now();
        Self {
            settings,
            wanted,
            start,
            report: start + Self::REPORT,
        }
    }

    /// Fails when the time is up or the stop flag is raised.
    fn check(&mut self) -> Result<(), LinkError> {
        let settings = self.settings;
        if settings.stop.load(Ordering::Relaxed) {
            return Err(LinkError::Interrupted);
        }
        let waited = self.start.elapsed();
        if settings.patience.is_some_and(|limit| waited >= limit) {
            return Err(LinkError::NobodyThere {
                ride: settings.ride.to_string(),
                wanted: self.wanted.name(),
                waited_s: waited.as_secs_f64(),
                path: settings.socket(),
            });
        }
        if Instant::now() >= self.report {
            let (ride, wanted) = (&settings.ride, self.wanted.name());
            (settings.notice)(&format!("ride `{ride}`: waiting for the {wanted}"));
            self.report = Instant::now() + Self::REPORT;
        }
        Ok(())
    }
}

/// A ride that waits for its controller: its services exist, nobody has joined yet.
pub struct PlantOffer {
    settings: Settings,
    listener: UnixListener,
    channels: Channels<PlantSlot, ControllerSlot>,
    bell: Bell,
    page: OwnedFd,
    claim: Claim,
}

impl PlantOffer {
    /// Takes the name of the ride, clears away dead rides, and creates everything that the
    /// controller will find.
    pub fn open(settings: Settings) -> Result<Self, LinkError> {
        let claim = Claim::new(&settings.run_dir, &settings.ride)?;
        let root = session_root(&settings.run_dir.ride(&settings.ride), claim.session());
        let channels = Channels::new(Role::Plant, &root, claim.session())?;
        let (bell, page) = Bell::create(Role::Plant)?;
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
            bell,
            page,
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
                    let waiter = self.settings.waiter(Role::Controller);
                    let _ = std::fs::remove_file(self.settings.socket());
                    let Self {
                        channels,
                        bell,
                        claim,
                        ..
                    } = self;
                    return Ok(PlantEnd {
                        channels: Some(channels),
                        peer,
                        bell,
                        waiter,
                        claim,
                    });
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
        let mut ours = Hello::new(Role::Plant, &self.settings.identity, self.claim.session());
        let verdict = ours.accept(&theirs, peer.pid);
        ours.refused = verdict.is_err();
        let page = [self.page.as_fd()];
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

/// The plant's end: the controller as the plant sees it, in another process.
pub struct PlantEnd {
    channels: Option<Channels<PlantSlot, ControllerSlot>>,
    peer: Peer,
    bell: Bell,
    waiter: Waiter,
    // Last: its destruction removes what the others leave in shared memory.
    #[allow(dead_code, reason = "held for its Drop")]
    claim: Claim,
}

impl PlantEnd {
    /// Offers the ride and waits for the controller.
    pub fn connect(settings: Settings) -> Result<Self, LinkError> {
        PlantOffer::open(settings)?.accept()
    }

    /// Process id of the controller.
    pub fn peer_pid(&self) -> u32 {
        self.peer.pid
    }

    /// Sends `frame` without waiting.
    #[inline]
    pub fn send(&mut self, frame: &PlantFrame) -> Result<(), LinkError> {
        let channels = self.channels.as_ref().ok_or(closed())?;
        channels.send(frame)?;
        if self.bell.other_sleeps() {
            self.peer.ring();
        }
        Ok(())
    }

    /// The next answer, whatever tick it belongs to; not validated. Waits until `deadline`, or
    /// without limit if there is none. `tick` only serves messages.
    pub fn receive(
        &mut self,
        tick: u64,
        deadline: Option<Instant>,
    ) -> Result<Option<ControllerFrame>, LinkError> {
        let channels = self.channels.as_ref().ok_or(closed())?;
        self.waiter
            .wait(&self.peer, &self.bell, tick, deadline, || {
                channels.receive()
            })
    }
}

impl ControllerPort for PlantEnd {
    #[inline]
    fn exchange(&mut self, frame: &PlantFrame) -> Result<ControllerFrame, LinkError> {
        let (tick, sequence) = (frame.header.tick, frame.header.sequence);
        self.send(frame)?;
        let answer = self.receive(tick, None)?.ok_or(closed())?;
        check_answer(&answer, tick, sequence)?;
        Ok(answer)
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

/// The controller's end.
pub struct ControllerEnd {
    channels: Option<Channels<ControllerSlot, PlantSlot>>,
    peer: Peer,
    bell: Bell,
    waiter: Waiter,
    run_dir: RunDir,
    received: u64,
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
        let ours = Hello::new(Role::Controller, &settings.identity, 0);
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
        let bell = Bell::open(Role::Controller, &page)?;
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
            bell,
            waiter: settings.waiter(Role::Plant),
            run_dir: settings.run_dir.clone(),
            received: 0,
            plant_gone: false,
        }))
    }

    /// Process id of the plant.
    pub fn peer_pid(&self) -> u32 {
        self.peer.pid
    }

    /// The plant's next frame, validated. Waits without limit for a plant that lives.
    #[inline]
    pub fn receive(&mut self) -> Result<PlantFrame, LinkError> {
        let frame = self.receive_until(None)?.ok_or(closed())?;
        Ok(frame)
    }

    /// The plant's next frame, validated; `None` if none came before `deadline`.
    #[inline]
    pub fn receive_until(
        &mut self,
        deadline: Option<Instant>,
    ) -> Result<Option<PlantFrame>, LinkError> {
        let channels = self.channels.as_ref().ok_or(closed())?;
        let tick = self.received;
        let frame = self
            .waiter
            .wait(&self.peer, &self.bell, tick, deadline, || {
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
        check_frame(&frame, tick, tick)?;
        self.received += 1;
        Ok(Some(frame))
    }

    /// Answers the plant.
    #[inline]
    pub fn send(&mut self, frame: &ControllerFrame) -> Result<(), LinkError> {
        let channels = self.channels.as_ref().ok_or(closed())?;
        channels.send(frame)?;
        if self.bell.other_sleeps() {
            self.peer.ring();
        }
        Ok(())
    }

    /// After the answer to the last frame: waits until the plant has taken it and hangs up.
    pub fn finish(mut self) -> Result<(), LinkError> {
        let tick = self.received;
        let nothing = || Ok(None::<()>);
        let ended = self
            .waiter
            .wait(&self.peer, &self.bell, tick, None, nothing);
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

fn closed() -> LinkError {
    LinkError::shared_memory("using the link", "it is closed")
}

/// The state that a frame's header tells.
pub fn state(frame: &PlantFrame) -> RideState {
    RideState::from_u32(frame.header.state)
}
