//! The process at the other end: its socket, and a descriptor that tells when it dies.

use crate::LinkError;
use crate::page::Page;
use crate::ride::own_uid;
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::net::{RecvFlags, SendFlags, recv, send};
use std::os::fd::{AsFd, OwnedFd};
use std::os::unix::net::UnixStream;
use std::time::Duration;

/// What a sleep ended with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Woken {
    /// The time is up, or a signal came.
    Timeout,
    /// The other side rang.
    Rung,
    /// The other side closed its end of the link but lives.
    Left,
    /// The other process is dead.
    Died,
}

pub(crate) struct Peer {
    pub(crate) socket: UnixStream,
    pidfd: OwnedFd,
    pub(crate) pid: u32,
}

impl Peer {
    /// Who is at the other end of `socket`, from the kernel; refuses other users.
    pub(crate) fn new(socket: UnixStream) -> Result<Self, LinkError> {
        let who = rustix::net::sockopt::socket_peercred(&socket)
            .map_err(|e| LinkError::os("asking who is at the other end", e))?;
        let pid = who.pid.as_raw_nonzero().get() as u32;
        let (uid, own) = (who.uid.as_raw(), own_uid());
        if uid != own {
            return Err(LinkError::OtherUser { pid, uid, own });
        }
        let pidfd = pidfd(pid)?;
        socket
            .set_nonblocking(true)
            .map_err(|e| LinkError::os("preparing the socket", e))?;
        Ok(Self { socket, pidfd, pid })
    }

    /// Wakes the other side, and says from which core.
    #[cold]
    pub(crate) fn ring(&self, page: &Page) {
        page.put_core(rustix::thread::sched_getcpu());
        // A full socket means that rings enough are waiting; a broken one shows at the next wait.
        let _ = send(
            &self.socket,
            b"!",
            SendFlags::DONTWAIT | SendFlags::NOSIGNAL,
        );
    }

    /// Sleeps until the other side rings, leaves or dies, at most for `limit`.
    pub(crate) fn sleep(&self, limit: Duration) -> Woken {
        let mut fds = [
            PollFd::new(&self.socket, PollFlags::IN),
            PollFd::new(&self.pidfd, PollFlags::IN),
        ];
        let limit = Timespec {
            tv_sec: limit.as_secs() as i64,
            tv_nsec: limit.subsec_nanos().into(),
        };
        if !matches!(poll(&mut fds, Some(&limit)), Ok(n) if n > 0) {
            return Woken::Timeout;
        }
        if !fds[1].revents().is_empty() {
            return Woken::Died;
        }
        self.drain()
    }

    /// Takes all rings off the socket.
    fn drain(&self) -> Woken {
        let mut bytes = [0u8; 64];
        match recv(&self.socket, &mut bytes, RecvFlags::DONTWAIT) {
            Ok((_, 0)) | Err(rustix::io::Errno::CONNRESET | rustix::io::Errno::PIPE) => {
                // A process that is killed closes its socket a moment before it counts as dead.
                if self.dead_within(Duration::from_millis(50)) {
                    Woken::Died
                } else {
                    Woken::Left
                }
            }
            Ok(_) => Woken::Rung,
            Err(_) => Woken::Timeout,
        }
    }

    /// True if the process is dead or dies within `limit`.
    pub(crate) fn dead_within(&self, limit: Duration) -> bool {
        wait_readable(&self.pidfd, limit)
    }

    /// Says that this side sends nothing more.
    pub(crate) fn half_close(&self) {
        let _ = self.socket.shutdown(std::net::Shutdown::Write);
    }
}

/// A descriptor that becomes readable when process `pid` dies.
pub(crate) fn pidfd(pid: u32) -> Result<OwnedFd, LinkError> {
    let dead = LinkError::PeerDied { pid, tick: 0 };
    let Some(pid) = rustix::process::Pid::from_raw(pid as i32) else {
        return Err(dead);
    };
    rustix::process::pidfd_open(pid, rustix::process::PidfdFlags::empty()).map_err(|_| dead)
}

/// True if `fd` becomes readable (or broken) within `limit`.
pub(crate) fn wait_readable(fd: impl AsFd, limit: Duration) -> bool {
    let mut fds = [PollFd::new(&fd, PollFlags::IN)];
    let limit = Timespec {
        tv_sec: limit.as_secs() as i64,
        tv_nsec: limit.subsec_nanos().into(),
    };
    matches!(poll(&mut fds, Some(&limit)), Ok(n) if n > 0)
}
