//! A ride that a living plant owns: its name, its session, and the locks that die with it.

use super::sweep::{remove_all_but, remove_ride, remove_session, sweep};
use super::{RideName, RunDir, SHM_DIR, session_prefix};
use crate::LinkError;
use rustix::fs::{FlockOperation, flock};
use std::fs::{DirBuilder, File, OpenOptions};
use std::hash::{BuildHasher, Hasher};
use std::io::{ErrorKind, Read, Seek, Write};
use std::os::unix::fs::{DirBuilderExt, MetadataExt, OpenOptionsExt};
use std::path::{Path, PathBuf};

/// A file whose lock says that its owner lives.
pub(super) struct LockFile {
    file: File,
    pub(super) path: PathBuf,
}

impl LockFile {
    /// Locks `path`; `None` if somebody else holds it, or if it vanished meanwhile.
    pub(super) fn take(path: &Path, create: bool) -> std::io::Result<Option<Self>> {
        let file = OpenOptions::new()
            .read(true)
            .write(true)
            .create(create)
            .truncate(false)
            .mode(0o600)
            .custom_flags(libc::O_NOFOLLOW)
            .open(path)?;
        if flock(&file, FlockOperation::NonBlockingLockExclusive).is_err() {
            return Ok(None);
        }
        let locked = file.metadata()?;
        // The last owner may have removed the file between our opening and our locking it.
        match std::fs::symlink_metadata(path) {
            Ok(now) if now.ino() == locked.ino() && now.dev() == locked.dev() => Ok(Some(Self {
                file,
                path: path.to_owned(),
            })),
            _ => Ok(None),
        }
    }

    /// Removes the file while the lock is held, then lets go.
    pub(super) fn remove(self) {
        let _ = std::fs::remove_file(&self.path);
    }
}

/// A ride that this process, the plant, owns.
pub(crate) struct Claim {
    session: u64,
    ride_dir: PathBuf,
    name_lock: Option<LockFile>,
    session_lock: Option<LockFile>,
}

impl Claim {
    /// Takes the name, removes what dead rides left behind, and opens a new session.
    pub(crate) fn new(run_dir: &RunDir, ride: &RideName) -> Result<Self, LinkError> {
        run_dir.ensure()?;
        sweep(run_dir);
        let ride_dir = run_dir.ride(ride);
        let name_lock = take_name(&ride_dir, ride)?;
        let (session, session_lock) = open_session()?;
        let claim = Self {
            session,
            ride_dir,
            name_lock: Some(name_lock),
            session_lock: Some(session_lock),
        };
        let root = session_root(&claim.ride_dir, session);
        DirBuilder::new()
            .mode(0o700)
            .create(&root)
            .map_err(|e| LinkError::io("creating the session directory", &root, e))?;
        Ok(claim)
    }

    pub(crate) fn session(&self) -> u64 {
        self.session
    }
}

impl Drop for Claim {
    fn drop(&mut self) {
        if let Some(lock) = self.session_lock.take() {
            remove_session(self.session, lock);
        }
        if let Some(lock) = self.name_lock.take() {
            remove_ride(&self.ride_dir, lock);
        }
    }
}

/// Where the middleware keeps its files of one session.
pub(crate) fn session_root(ride_dir: &Path, session: u64) -> PathBuf {
    ride_dir.join(format!("{session:016x}"))
}

fn take_name(ride_dir: &Path, ride: &RideName) -> Result<LockFile, LinkError> {
    let path = ride_dir.join("lock");
    // A few rounds: another process may be removing the directory of the last ride right now.
    for _ in 0..50 {
        match DirBuilder::new().mode(0o700).create(ride_dir) {
            Err(e) if e.kind() != ErrorKind::AlreadyExists => {
                return Err(LinkError::io("creating the ride's directory", ride_dir, e));
            }
            _ => {}
        }
        match LockFile::take(&path, true) {
            Ok(Some(mut lock)) => {
                remove_all_but(ride_dir, &path);
                let pid = std::process::id();
                lock.file
                    .set_len(0)
                    .and_then(|()| lock.file.rewind())
                    .and_then(|()| write!(lock.file, "{pid}"))
                    .map_err(|e| LinkError::io("writing the ride's lock", &path, e))?;
                return Ok(lock);
            }
            Ok(None) | Err(_) if !path.exists() => {}
            Ok(None) => std::thread::sleep(std::time::Duration::from_millis(1)),
            Err(e) => return Err(LinkError::io("opening the ride's lock", path, e)),
        }
    }
    let mut pid = String::new();
    let _ = File::open(&path).and_then(|file| file.take(20).read_to_string(&mut pid));
    let pid = if pid.is_empty() {
        "unknown".to_owned()
    } else {
        pid
    };
    Err(LinkError::RideTaken {
        ride: ride.to_string(),
        pid,
    })
}

fn open_session() -> Result<(u64, LockFile), LinkError> {
    let draw = std::collections::hash_map::RandomState::new();
    for attempt in 0..50u32 {
        let mut hasher = draw.build_hasher();
        hasher.write_u32(attempt);
        hasher.write_u32(std::process::id());
        let session = hasher.finish();
        let path = Path::new(SHM_DIR).join(session_prefix(session) + "lock");
        if path.exists() {
            continue;
        }
        match LockFile::take(&path, true) {
            Ok(Some(lock)) => return Ok((session, lock)),
            Ok(None) => {}
            Err(e) => return Err(LinkError::io("creating shared memory", path, e)),
        }
    }
    Err(LinkError::shared_memory(
        "opening a session",
        "no free session number in 50 attempts",
    ))
}
