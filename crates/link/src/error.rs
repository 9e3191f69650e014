//! What can go wrong on the link: what was tried, what was found, what would be accepted.

use std::path::PathBuf;

/// Why the link could not be made, or why it ended.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum LinkError {
    /// The other process is gone.
    #[error("the other process (pid {pid}) died at tick {tick}")]
    PeerDied {
        /// Its process id.
        pid: u32,
        /// The tick that was waited for.
        tick: u64,
    },
    /// The other process lives but closed the link in the middle of the ride.
    #[error("the other process (pid {pid}) closed the link at tick {tick}, before the last frame")]
    PeerLeft {
        /// Its process id.
        pid: u32,
        /// The tick that was waited for.
        tick: u64,
    },
    /// The stop flag was raised.
    #[error("interrupted")]
    Interrupted,
    /// Nobody joined, or nobody offers the ride.
    #[error("ride `{ride}`: no {wanted} within {waited_s:.1} s (looked at {path})")]
    NobodyThere {
        /// Name of the ride.
        ride: String,
        /// "plant" or "controller".
        wanted: &'static str,
        /// How long was waited, s.
        waited_s: f64,
        /// The socket of the ride.
        path: PathBuf,
    },
    /// The two sides do not fit together.
    #[error(
        "the other process (pid {pid}) was refused: {reason}\n  ours:   {ours}\n  theirs: {theirs}"
    )]
    Refused {
        /// Its process id.
        pid: u32,
        /// What does not fit.
        reason: &'static str,
        /// Our side: role, tool, protocol version, layout hash.
        ours: String,
        /// Their side.
        theirs: String,
    },
    /// The process at the other end belongs to another user.
    #[error(
        "the other process (pid {pid}) belongs to user {uid}; only user {own} may join this ride"
    )]
    OtherUser {
        /// Its process id.
        pid: u32,
        /// Its user id.
        uid: u32,
        /// Our user id.
        own: u32,
    },
    /// A frame that breaks the protocol.
    #[error(
        "a frame from the {sender} broke the protocol at tick {tick}: {field} is {found:#x}, expected {expected:#x}"
    )]
    BadFrame {
        /// "plant" or "controller".
        sender: &'static str,
        /// The tick that was waited for.
        tick: u64,
        /// The field of the header.
        field: &'static str,
        /// Its value.
        found: u64,
        /// The value that the protocol asks for.
        expected: u64,
    },
    /// A controller at the end of a byte stream that does not say hello.
    #[error("{who}: no controller said hello within {waited_s:.1} s")]
    Silent {
        /// The command, or the socket.
        who: String,
        /// How long was waited, s.
        waited_s: f64,
    },
    /// Bytes that are no packet, or a packet that is no message.
    #[error("the controller ({who}) broke the byte stream at tick {tick}: {detail}")]
    BrokenStream {
        /// The command, or the socket.
        who: String,
        /// The tick that was waited for.
        tick: u64,
        /// What was found, and what was expected.
        detail: String,
    },
    /// A name that no ride can have.
    #[error(
        "`{name}` cannot be the name of a ride: 1 to 40 characters out of a-z, A-Z, 0-9, `_` and `-`"
    )]
    BadRideName {
        /// The name.
        name: String,
    },
    /// A living plant already offers this ride.
    #[error("ride `{ride}` is already being ridden by process {pid}; choose another name")]
    RideTaken {
        /// Name of the ride.
        ride: String,
        /// Process id of its plant.
        pid: String,
    },
    /// The directory of the rides is open to others.
    #[error("{path} must be a directory of user {own} with permissions 0700, but it is {found}")]
    NotPrivate {
        /// The directory.
        path: PathBuf,
        /// What it is instead.
        found: String,
        /// Our user id.
        own: u32,
    },
    /// The operating system refused.
    #[error("{what} failed{}", .path.as_ref().map(|p| format!(" on {}", p.display())).unwrap_or_default())]
    Io {
        /// What was tried.
        what: &'static str,
        /// On which file.
        path: Option<PathBuf>,
        /// Its answer.
        source: std::io::Error,
    },
    /// The shared-memory middleware refused.
    #[error("shared memory: {what} failed: {detail}")]
    SharedMemory {
        /// What was tried.
        what: &'static str,
        /// Its answer.
        detail: String,
    },
}

impl LinkError {
    /// The exit code of a process that this error ends: 2 bad input, 3 the environment cannot
    /// (a peer that died counts as that), 130 interrupted.
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::Interrupted => 130,
            Self::BadRideName { .. } => 2,
            _ => 3,
        }
    }

    pub(crate) fn io(
        what: &'static str,
        path: impl Into<PathBuf>,
        source: impl Into<std::io::Error>,
    ) -> Self {
        Self::Io {
            what,
            path: Some(path.into()),
            source: source.into(),
        }
    }

    pub(crate) fn os(what: &'static str, source: impl Into<std::io::Error>) -> Self {
        Self::Io {
            what,
            path: None,
            source: source.into(),
        }
    }

    pub(crate) fn shared_memory(what: &'static str, detail: impl std::fmt::Debug) -> Self {
        Self::SharedMemory {
            what,
            detail: format!("{detail:?}"),
        }
    }
}
