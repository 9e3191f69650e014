//! What a byte stream runs over: the pipes of a program that is started for it, a socket that
//! waits for one, two named pipes.

use crate::LinkError;
use crate::peer::{Peer, wait_readable};
use crate::stream::Wires;
use crate::wait::NAP;
use rustix::fs::{CWD, FileType, Mode, OFlags};
use rustix::process::{Pid, Signal};
use std::os::fd::OwnedFd;
use std::os::unix::net::{UnixListener, UnixStream};
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// A program that is killed when this goes, with everything that it started, and when the thread
/// that started it ends.
pub struct Started(Child);

impl Started {
    /// Starts `command` in a process group of its own: Ctrl-C does not reach it.
    ///
    /// # Errors
    /// If the program cannot be started.
    pub fn new(command: &mut Command) -> Result<Self, LinkError> {
        command.process_group(0);
        // SAFETY: one system call between fork and exec, which allocates nothing.
        unsafe {
            command.pre_exec(|| {
                rustix::process::set_parent_process_death_signal(Some(Signal::KILL))
                    .map_err(Into::into)
            });
        }
        let program = PathBuf::from(command.get_program());
        let child = command.spawn();
        child
            .map(Self)
            .map_err(|e| LinkError::io("starting the controller", program, e))
    }

    /// Starts `command` with its standard input and output as the byte stream.
    ///
    /// # Errors
    /// If the program cannot be started.
    pub fn piped(command: &mut Command) -> Result<(Self, Wires), LinkError> {
        let mut started = Self::new(command.stdin(Stdio::piped()).stdout(Stdio::piped()))?;
        let (Some(output), Some(input)) = (started.0.stdin.take(), started.0.stdout.take()) else {
            return Err(LinkError::os(
                "starting the controller",
                std::io::Error::other("no pipes"),
            ));
        };
        let wires = Wires {
            input: input.into(),
            output: output.into(),
            pid: started.pid(),
        };
        Ok((started, wires))
    }

    /// Its process id.
    pub fn pid(&self) -> u32 {
        self.0.id()
    }

    /// Waits up to `limit` for it to end by itself.
    pub fn wait(&mut self, limit: Duration) -> Option<std::process::ExitStatus> {
        let end = Instant::now() + limit;
        loop {
            match self.0.try_wait() {
                Ok(Some(status)) => return Some(status),
                Ok(None) if Instant::now() < end => std::thread::sleep(Duration::from_millis(2)),
                _ => return None,
            }
        }
    }
}

impl Drop for Started {
    fn drop(&mut self) {
        if let Ok(None) = self.0.try_wait() {
            if let Some(group) = Pid::from_raw(self.0.id() as i32) {
                let _ = rustix::process::kill_process_group(group, Signal::KILL);
            }
            let _ = self.0.wait();
        }
    }
}

/// Two named pipes in `dir`, opened at this end: `to_target` and `from_target`.
///
/// # Errors
/// If they cannot be made.
pub fn named_pipes(dir: &Path) -> Result<(OwnedFd, OwnedFd), LinkError> {
    let open = |name: &str| {
        let path = dir.join(name);
        let made = rustix::fs::mknodat(CWD, &path, FileType::Fifo, Mode::RUSR | Mode::WUSR, 0);
        // Both ways, so that opening waits for nobody; the end of the peer shows by its pidfd.
        let flags = OFlags::RDWR | OFlags::NONBLOCK | OFlags::CLOEXEC;
        made.and_then(|()| rustix::fs::open(&path, flags, Mode::empty()))
            .map_err(|e| LinkError::io("making a pipe", &path, e))
    };
    Ok((open("from_target")?, open("to_target")?))
}

/// A socket on which a controller may join; its file goes with it.
pub struct StreamListener {
    listener: UnixListener,
    path: PathBuf,
}

impl StreamListener {
    /// Listens on the new Unix socket `path`.
    ///
    /// # Errors
    /// If there is already something called `path`, or the socket cannot be made.
    pub fn bind(path: &Path) -> Result<Self, LinkError> {
        let failed = |e| {
            LinkError::io(
                "listening (remove what is there, or choose another name)",
                path,
                e,
            )
        };
        let listener = UnixListener::bind(path).map_err(failed)?;
        let this = Self {
            listener,
            path: path.to_owned(),
        };
        rustix::fs::chmod(path, Mode::RUSR | Mode::WUSR).map_err(|e| failed(e.into()))?;
        this.listener.set_nonblocking(true).map_err(failed)?;
        Ok(this)
    }

    /// Waits for a process of this user to connect; others are turned away.
    ///
    /// # Errors
    /// If nobody came within `patience`, or `stop` is raised.
    pub fn accept(
        &self,
        patience: Option<Duration>,
        stop: &AtomicBool,
    ) -> Result<Wires, LinkError> {
        let start = Instant::now();
        loop {
            if stop.load(Ordering::Relaxed) {
                return Err(LinkError::Interrupted);
            }
            if patience.is_some_and(|limit| start.elapsed() >= limit) {
                return Err(LinkError::Silent {
                    who: self.path.display().to_string(),
                    waited_s: start.elapsed().as_secs_f64(),
                });
            }
            if !wait_readable(&self.listener, NAP) {
                continue;
            }
            let Ok((socket, _)) = self.listener.accept() else {
                continue;
            };
            match wires(socket) {
                Err(LinkError::PeerDied { .. } | LinkError::OtherUser { .. }) => {}
                other => return other,
            }
        }
    }
}

impl Drop for StreamListener {
    fn drop(&mut self) {
        let _ = std::fs::remove_file(&self.path);
    }
}

/// Both directions of a socket, with the process at its other end, who is of this user.
fn wires(socket: UnixStream) -> Result<Wires, LinkError> {
    let Peer { socket, pid, .. } = Peer::new(socket)?;
    let input = socket
        .try_clone()
        .map_err(|e| LinkError::os("preparing the socket", e))?;
    Ok(Wires {
        input: input.into(),
        output: socket.into(),
        pid,
    })
}
