//! Removing what dead rides leave behind.

use super::claim::LockFile;
use super::{RunDir, SHM_DIR, own_uid, session_prefix};
use crate::LinkError;
use std::io::ErrorKind;
use std::os::unix::fs::{MetadataExt, PermissionsExt};
use std::path::{Path, PathBuf};

pub(super) fn remove_all_but(dir: &Path, keep: &Path) {
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

pub(super) fn remove_ride(ride_dir: &Path, lock: LockFile) {
    remove_all_but(ride_dir, &lock.path);
    lock.remove();
    let _ = std::fs::remove_dir(ride_dir);
}

pub(super) fn remove_session(session: u64, lock: LockFile) {
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
