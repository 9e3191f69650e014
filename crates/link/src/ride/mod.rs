//! Where a ride lives: names, directories, locks, and what dead rides leave behind.
//!
//! * `<run dir>/<ride>/lock` is locked by the plant as long as it lives; `<run dir>/<ride>/hello`
//!   is the socket that the controller connects to. The run dir is `$TWINHUB_RUN_DIR`, or
//!   `/tmp/twinhub-<uid>`; it belongs to the user with permissions 0700, or nothing starts.
//! * Every start of a ride draws a new session number, 16 hexadecimal digits. Shared memory is
//!   named `/dev/shm/twinhub.<uid>.<session>.*`; the first such file, `..lock`, is locked by the
//!   plant. So a survivor of a killed ride can never meet the files of the next ride of that name.
//! * A lock dies with the process that holds it. What belongs to a free lock is a leftover, and
//!   the next start of any ride removes it; what belongs to a held lock is never touched.

mod claim;
mod sweep;

pub(crate) use claim::{Claim, session_root};
pub(crate) use sweep::close_to_others;
pub use sweep::{leftovers, sweep};

use crate::LinkError;
use std::fs::DirBuilder;
use std::io::ErrorKind;
use std::os::unix::fs::{DirBuilderExt, MetadataExt};
use std::path::{Path, PathBuf};

/// Directory of POSIX shared memory on Linux.
pub(crate) const SHM_DIR: &str = "/dev/shm";

/// The name of a ride: 1 to 40 letters, digits, `_` and `-`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RideName(String);

impl RideName {
    /// Checks `name`.
    pub fn new(name: &str) -> Result<Self, LinkError> {
        let allowed = |b: u8| b.is_ascii_alphanumeric() || b == b'_' || b == b'-';
        if (1..=40).contains(&name.len()) && name.bytes().all(allowed) {
            Ok(Self(name.to_owned()))
        } else {
            Err(LinkError::BadRideName {
                name: name.chars().take(80).collect(),
            })
        }
    }

    /// The name as text.
    pub fn as_str(&self) -> &str {
        &self.0
    }
}

impl std::str::FromStr for RideName {
    type Err = LinkError;
    fn from_str(name: &str) -> Result<Self, LinkError> {
        Self::new(name)
    }
}

impl std::fmt::Display for RideName {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.0)
    }
}

pub(crate) fn own_uid() -> u32 {
    rustix::process::geteuid().as_raw()
}

/// The directory that holds one subdirectory for each ride of this user.
#[derive(Clone, Debug)]
pub struct RunDir(PathBuf);

impl RunDir {
    /// `$TWINHUB_RUN_DIR` if set and not empty, else `/tmp/twinhub-<uid>`.
    pub fn from_env() -> Self {
        match std::env::var_os("TWINHUB_RUN_DIR").filter(|dir| !dir.is_empty()) {
            Some(dir) => Self(dir.into()),
            None => Self(PathBuf::from(format!("/tmp/twinhub-{}", own_uid()))),
        }
    }

    /// A run dir at `path`.
    pub fn at(path: impl Into<PathBuf>) -> Self {
        Self(path.into())
    }

    /// Its path.
    pub fn path(&self) -> &Path {
        &self.0
    }

    /// The directory of one ride.
    pub(crate) fn ride(&self, ride: &RideName) -> PathBuf {
        self.0.join(ride.as_str())
    }

    /// The socket of one ride.
    pub fn socket(&self, ride: &RideName) -> PathBuf {
        self.ride(ride).join("hello")
    }

    /// Creates the directory if it is missing, and refuses one that others could enter.
    pub fn ensure(&self) -> Result<(), LinkError> {
        match DirBuilder::new()
            .recursive(false)
            .mode(0o700)
            .create(&self.0)
        {
            Err(e) if e.kind() != ErrorKind::AlreadyExists => {
                return Err(LinkError::io("creating the run directory", &self.0, e));
            }
            _ => {}
        }
        self.check()
    }

    /// Refuses a directory that is not ours alone.
    pub fn check(&self) -> Result<(), LinkError> {
        let own = own_uid();
        let meta = std::fs::symlink_metadata(&self.0)
            .map_err(|e| LinkError::io("reading the permissions", &self.0, e))?;
        let mode = meta.mode() & 0o7777;
        let refuse = |found| {
            Err(LinkError::NotPrivate {
                path: self.0.clone(),
                found,
                own,
            })
        };
        if !meta.is_dir() {
            return refuse("not a directory".to_owned());
        }
        if meta.uid() != own {
            return refuse(format!("owned by user {}", meta.uid()));
        }
        if mode & 0o077 != 0 {
            return refuse(format!("open to others (permissions {mode:04o})"));
        }
        Ok(())
    }
}

/// What the names of all shared memory of one session begin with.
pub(crate) fn session_prefix(session: u64) -> String {
    format!("twinhub.{}.{session:016x}.", own_uid())
}
