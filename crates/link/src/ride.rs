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

use crate::LinkError;
use rustix::fs::{FlockOperation, flock};
use std::fs::{DirBuilder, File, OpenOptions};
use std::hash::{BuildHasher, Hasher};
use std::io::{ErrorKind, Read, Seek, Write};
use std::os::unix::fs::{DirBuilderExt, MetadataExt, OpenOptionsExt, PermissionsExt};
use std::path::{Path, PathBuf};

/// Directory of POSIX shared memory on Linux.
const SHM_DIR: &str = "/dev/shm";

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

/// A file whose lock says that its owner lives.
struct LockFile {
    file: File,
    path: PathBuf,
}

impl LockFile {
    /// Locks `path`; `None` if somebody else holds it, or if it vanished meanwhile.
    fn take(path: &Path, create: bool) -> std::io::Result<Option<Self>> {
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
    fn remove(self) {
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

/// What the names of all shared memory of one session begin with.
pub(crate) fn session_prefix(session: u64) -> String {
    format!("twinhub.{}.{session:016x}.", own_uid())
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

fn remove_all_but(dir: &Path, keep: &Path) {
    for entry in std::fs::read_dir(dir).into_iter().flatten().flatten() {
        let path = entry.path();
        if path == keep {
            continue;
        }
        if entry.file_type().is_ok_and(|kind| kind.is_dir()) {
            let _ = std::fs::remove_dir_all(path);
        } else {
            let _ = std::fs::remove_file(path);
        }
    }
}

fn remove_ride(ride_dir: &Path, lock: LockFile) {
    remove_all_but(ride_dir, &lock.path);
    lock.remove();
    let _ = std::fs::remove_dir(ride_dir);
}

fn remove_session(session: u64, lock: LockFile) {
    for (number, path) in shared_memory() {
        if number == session && path != lock.path {
            let _ = std::fs::remove_file(path);
        }
    }
    lock.remove();
}

/// All shared memory of this user's rides: session number and path.
fn shared_memory() -> Vec<(u64, PathBuf)> {
    let own = own_uid();
    let start = format!("twinhub.{own}.");
    let mut found = Vec::new();
    for entry in std::fs::read_dir(SHM_DIR).into_iter().flatten().flatten() {
        let name = entry.file_name();
        let session = name.to_str().and_then(|name| {
            let (number, _) = name.strip_prefix(&start)?.split_once('.')?;
            (number.len() == 16).then(|| u64::from_str_radix(number, 16).ok())?
        });
        let ours = || entry.metadata().is_ok_and(|meta| meta.uid() == own);
        if let Some(session) = session.filter(|_| ours()) {
            found.push((session, entry.path()));
        }
    }
    found
}

/// Takes the permissions of everybody else off the shared memory of `session`. The middleware
/// opens all but one of its files for this user alone; that one holds counters, no frames.
pub(crate) fn close_to_others(session: u64) -> Result<(), LinkError> {
    for (_, path) in shared_memory()
        .into_iter()
        .filter(|(number, _)| *number == session)
    {
        let meta = match std::fs::metadata(&path) {
            Err(e) if e.kind() == ErrorKind::NotFound => continue,
            other => other.map_err(|e| LinkError::io("reading the permissions", &path, e))?,
        };
        let mut permissions = meta.permissions();
        if permissions.mode() & 0o077 != 0 {
            permissions.set_mode(permissions.mode() & 0o700);
            std::fs::set_permissions(&path, permissions)
                .map_err(|e| LinkError::io("closing shared memory to others", &path, e))?;
        }
    }
    Ok(())
}

/// Locks of dead sessions, each with its number.
fn dead_sessions() -> Vec<(u64, Option<LockFile>)> {
    let mut sessions: Vec<u64> = shared_memory()
        .into_iter()
        .map(|(session, _)| session)
        .collect();
    sessions.sort_unstable();
    sessions.dedup();
    let lock = |session| {
        let path = Path::new(SHM_DIR).join(session_prefix(session) + "lock");
        match LockFile::take(&path, false) {
            Ok(Some(lock)) => Some((session, Some(lock))),
            Err(e) if e.kind() == ErrorKind::NotFound => Some((session, None)),
            _ => None,
        }
    };
    sessions.into_iter().filter_map(lock).collect()
}

/// Directories of dead rides, each with its lock.
fn dead_rides(run_dir: &RunDir) -> Vec<(PathBuf, LockFile)> {
    let mut dead = Vec::new();
    for entry in std::fs::read_dir(run_dir.path())
        .into_iter()
        .flatten()
        .flatten()
    {
        let path = entry.path();
        if let Ok(Some(lock)) = LockFile::take(&path.join("lock"), false) {
            dead.push((path, lock));
        }
    }
    dead
}

/// Removes what dead rides of this user left behind; never touches a living ride.
pub fn sweep(run_dir: &RunDir) {
    for (session, lock) in dead_sessions() {
        if let Some(lock) = lock {
            remove_session(session, lock);
        } else {
            for (_, path) in shared_memory()
                .into_iter()
                .filter(|(number, _)| *number == session)
            {
                let _ = std::fs::remove_file(path);
            }
        }
    }
    for (ride_dir, lock) in dead_rides(run_dir) {
        remove_ride(&ride_dir, lock);
    }
}

/// Files and directories of rides whose plant is dead. The next start of any ride removes them.
pub fn leftovers(run_dir: &RunDir) -> Vec<PathBuf> {
    let dead = dead_sessions();
    let mut found: Vec<PathBuf> = shared_memory()
        .into_iter()
        .filter(|(session, _)| dead.iter().any(|(number, _)| number == session))
        .map(|(_, path)| path)
        .collect();
    found.extend(dead_rides(run_dir).into_iter().map(|(path, _)| path));
    found
}
