//! The controller behind a byte stream: pipes, a socket, a serial line. `STREAM.md` in this crate
//! describes the stream for those who write the other end.
//!
//! Lockstep, as over shared memory, with the same guards: a peer that lives is waited for without
//! limit, with words every 5 s; one that dies or hangs up ends the ride at once; whatever it sends
//! is checked for length, checksum, layout, sequence and tick before anyone looks at it.

use crate::peer::{pidfd, wait_readable};
use crate::protocol::check_answer;
use crate::wait::{NAP, Notice};
use crate::{ControllerPort, LinkError};
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::io::Errno;
use std::os::fd::{AsFd, OwnedFd};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};
use twinhub_types::stream::{Broken, Decoder, Kind, Packet, ROLE_PLANT, StreamHello, TargetReport};
use twinhub_types::{ControllerFrame, PlantFrame, Wire};

/// How often a long wait is reported.
const REPORT: Duration = Duration::from_secs(5);
/// How long a target may take to send its report after its last answer.
const LAST_WORDS: Duration = Duration::from_secs(2);

/// Two directions of bytes, and the process at their other end.
pub struct Wires {
    /// What the controller sends.
    pub input: OwnedFd,
    /// What the controller receives.
    pub output: OwnedFd,
    /// Process id at the other end.
    pub pid: u32,
}

/// How the plant meets its controller.
pub struct StreamSettings {
    /// The law, in the encoding of our own targets; passed over by everyone else.
    pub law: Vec<u8>,
    /// How long the controller may take to say hello; `None` waits without limit.
    pub patience: Option<Duration>,
    /// Raised from outside (Ctrl-C), ends every wait with [`LinkError::Interrupted`].
    pub stop: Arc<AtomicBool>,
    /// Where messages to the user go.
    pub notice: Notice,
    /// What messages call the controller: a command, a socket.
    pub who: String,
}

/// The plant's end of a byte stream.
pub struct StreamEnd {
    input: OwnedFd,
    output: OwnedFd,
    life: OwnedFd,
    pid: u32,
    settings: StreamSettings,
    decoder: Decoder,
    chunk: [u8; 4096],
    used: usize,
    len: usize,
    met: bool,
}

impl StreamEnd {
    /// Says hello over `wires` and waits for the controller's.
    ///
    /// # Errors
    /// If the controller says nothing in time, does not fit, dies or hangs up.
    pub fn meet(wires: Wires, settings: StreamSettings) -> Result<Self, LinkError> {
        let Wires { input, output, pid } = wires;
        for fd in [&input, &output] {
            let flags = rustix::fs::fcntl_getfl(fd)
                .map_err(|e| LinkError::os("preparing the byte stream", e))?;
            rustix::fs::fcntl_setfl(fd, flags | rustix::fs::OFlags::NONBLOCK)
                .map_err(|e| LinkError::os("preparing the byte stream", e))?;
        }
        let mut end = Self {
            life: pidfd(pid)?,
            input,
            output,
            pid,
            settings,
            decoder: Decoder::default(),
            chunk: [0; 4096],
            used: 0,
            len: 0,
            met: false,
        };
        end.greet()?;
        Ok(end)
    }

    fn greet(&mut self) -> Result<(), LinkError> {
        let ours = StreamHello::new(ROLE_PLANT);
        let law = std::mem::take(&mut self.settings.law);
        let deadline = self.settings.patience.map(|limit| Instant::now() + limit);
        self.send(&Packet::of(Kind::Hello, &ours), 0)?;
        self.send(&Packet::raw(Kind::Law, &law), 0)?;
        let hello = self
            .receive::<StreamHello>(Kind::Hello, 0, deadline)?
            .ok_or_else(|| LinkError::Silent {
                who: self.settings.who.clone(),
                waited_s: self.settings.patience.map_or(0.0, |p| p.as_secs_f64()),
            })?;
        self.met = true;
        match ours.mismatch(&hello) {
            None => Ok(()),
            Some(reason) => Err(LinkError::Refused {
                pid: self.pid,
                reason,
                ours: describe(&ours),
                theirs: describe(&hello),
            }),
        }
    }

    /// Process id of the controller.
    pub fn peer_pid(&self) -> u32 {
        self.pid
    }

    /// After the last frame: what the controller measured, if it tells. Waits up to 2 s.
    pub fn finish(mut self) -> Option<TargetReport> {
        let deadline = Instant::now() + LAST_WORDS;
        self.receive::<TargetReport>(Kind::Report, 0, Some(deadline))
            .ok()
            .flatten()
    }

    /// Sends a packet; a controller that does not read is waited for like one that does not answer.
    fn send(&mut self, packet: &Packet, tick: u64) -> Result<(), LinkError> {
        let mut rest = packet.bytes();
        let mut wait = Wait::new(None);
        while !rest.is_empty() {
            match rustix::io::write(&self.output, rest) {
                Ok(n) => rest = rest.get(n..).unwrap_or(&[]),
                Err(Errno::INTR) => {}
                Err(Errno::AGAIN) => {
                    if !self.pause(&mut wait, false, tick)? {
                        return Ok(());
                    }
                }
                Err(Errno::PIPE | Errno::CONNRESET) => return Err(self.gone(tick)),
                Err(e) => return Err(LinkError::os("writing to the controller", e)),
            }
        }
        Ok(())
    }

    /// The next message of `kind`; packets of other kinds are passed over, those of `kind` with
    /// another length are refused. `None` if none came before `deadline`.
    fn receive<M: Wire>(
        &mut self,
        kind: Kind,
        tick: u64,
        deadline: Option<Instant>,
    ) -> Result<Option<M>, LinkError> {
        let mut wait = Wait::new(deadline);
        loop {
            while self.used < self.len {
                let byte = self.chunk[self.used];
                self.used += 1;
                match self.decoder.push(byte) {
                    Ok(true) => {}
                    Ok(false) => continue,
                    // A line may carry noise before both sides have met.
                    Err(Broken::Stray { .. }) if !self.met => continue,
                    Err(broken) => return Err(self.broken(tick, broken.to_string())),
                }
                let (number, payload) = self.decoder.packet();
                if number != kind as u16 {
                    continue;
                }
                match M::get(payload) {
                    Some((message, [])) => return Ok(Some(message)),
                    _ => {
                        let detail = format!(
                            "a {kind:?} packet has {} bytes, expected {}",
                            payload.len(),
                            M::SIZE
                        );
                        return Err(self.broken(tick, detail));
                    }
                }
            }
            match rustix::io::read(&self.input, &mut self.chunk) {
                Ok(0) => return Err(self.gone(tick)),
                Ok(n) => {
                    (self.used, self.len) = (0, n);
                    // A peer that never stops talking would never let the ride pause.
                    let now = Instant::now();
                    if deadline.is_some_and(|end| now >= end) {
                        return Ok(None);
                    }
                    if self.settings.stop.load(Ordering::Relaxed) && now >= wait.start + NAP {
                        return Err(LinkError::Interrupted);
                    }
                }
                Err(Errno::INTR) => {}
                Err(Errno::AGAIN) => {
                    if !self.pause(&mut wait, true, tick)? {
                        return Ok(None);
                    }
                }
                Err(Errno::CONNRESET) => return Err(self.gone(tick)),
                Err(e) => return Err(LinkError::os("reading from the controller", e)),
            }
        }
    }

    /// Sleeps until something can be read (or written); false when the deadline has passed.
    fn pause(&self, wait: &mut Wait, to_read: bool, tick: u64) -> Result<bool, LinkError> {
        let now = Instant::now();
        let nap = match wait.deadline {
            Some(end) if now >= end => return Ok(false),
            Some(end) => (end - now).min(NAP),
            None => NAP,
        };
        let (fd, flags) = if to_read {
            (&self.input, PollFlags::IN)
        } else {
            (&self.output, PollFlags::OUT)
        };
        let mut fds = [
            PollFd::from_borrowed_fd(fd.as_fd(), flags),
            PollFd::new(&self.life, PollFlags::IN),
        ];
        let limit = Timespec {
            tv_sec: nap.as_secs() as i64,
            tv_nsec: nap.subsec_nanos().into(),
        };
        if matches!(poll(&mut fds, Some(&limit)), Ok(n) if n > 0) {
            // What a peer sent before it died is read first.
            return if fds[0].revents().is_empty() {
                Err(self.gone(tick))
            } else {
                Ok(true)
            };
        }
        if self.settings.stop.load(Ordering::Relaxed) {
            return Err(LinkError::Interrupted);
        }
        let now = Instant::now();
        if now >= wait.report {
            let (who, s) = (&self.settings.who, (now - wait.start).as_secs());
            (self.settings.notice)(&format!(
                "waiting for the controller ({who}) at tick {tick} for {s} s; it lives, but does not answer"
            ));
            wait.report = now + REPORT;
        }
        Ok(true)
    }

    /// The peer is gone: dead, or it hung up.
    fn gone(&self, tick: u64) -> LinkError {
        let pid = self.pid;
        // A process that is killed closes its files a moment before it counts as dead.
        if wait_readable(&self.life, Duration::from_millis(100)) {
            LinkError::PeerDied { pid, tick }
        } else {
            LinkError::PeerLeft { pid, tick }
        }
    }

    fn broken(&self, tick: u64, detail: String) -> LinkError {
        LinkError::BrokenStream {
            who: self.settings.who.clone(),
            tick,
            detail,
        }
    }
}

impl ControllerPort for StreamEnd {
    fn exchange_during(
        &mut self,
        frame: &PlantFrame,
        meanwhile: &mut dyn FnMut(),
    ) -> Result<Option<ControllerFrame>, LinkError> {
        let (tick, sequence) = (frame.header.tick, frame.header.sequence);
        self.send(&Packet::of(Kind::Plant, frame), tick)?;
        meanwhile();
        loop {
            if let Some(answer) = self.receive::<ControllerFrame>(Kind::Controller, tick, None)? {
                check_answer(&answer, tick, sequence)?;
                return Ok(Some(answer));
            }
        }
    }
}

/// One wait.
struct Wait {
    start: Instant,
    report: Instant,
    deadline: Option<Instant>,
}

impl Wait {
    fn new(deadline: Option<Instant>) -> Self {
        let start = Instant::now();
        Self {
            start,
            report: start + REPORT,
            deadline,
        }
    }
}

fn describe(hello: &StreamHello) -> String {
    format!(
        "byte stream {}, role {}, protocol {}, layout {:016x}, frames of {} and {} bytes",
        hello.stream_version,
        hello.role,
        hello.protocol_version,
        hello.protocol_hash,
        hello.plant_frame_bytes,
        hello.controller_frame_bytes
    )
}

#[cfg(test)]
#[path = "stream_test.rs"]
mod tests;
