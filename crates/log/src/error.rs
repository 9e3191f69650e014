//! What can go wrong with a log.

use std::path::PathBuf;

/// What went wrong with a log: which file, what was found, what would be accepted.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum LogError {
    /// The file could not be created.
    #[error("cannot create the log {path}: {source}", path = path.display())]
    Create {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The file could not be written to.
    #[error("cannot write to the log {path}: {source}", path = path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// What the MCAP writer said.
        source: mcap::McapError,
    },
    /// An earlier write failed, and that error was already returned.
    #[error("the log {path} is closed after an earlier error", path = path.display())]
    Closed {
        /// The file.
        path: PathBuf,
    },
    /// The thread that writes the file ended without a result.
    #[error("the thread that writes the log {path} panicked", path = path.display())]
    WriterPanicked {
        /// The file.
        path: PathBuf,
    },
    /// A topic was registered twice, or its name is not a topic name.
    #[error("cannot log topic `{topic}`: {reason}")]
    Topic {
        /// The name as given.
        topic: String,
        /// Why not.
        reason: &'static str,
    },
    /// The file could not be opened or read.
    #[error("cannot read the log {path}: {source}", path = path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The file is no MCAP file.
    #[error("{path} is not an MCAP log: {found}", path = path.display())]
    NotMcap {
        /// The file.
        path: PathBuf,
        /// What it begins with.
        found: String,
    },
    /// The file is too large to read into memory.
    #[error("{path} has {bytes} bytes; at most {limit} are read", path = path.display())]
    TooLarge {
        /// The file.
        path: PathBuf,
        /// Its size.
        bytes: u64,
        /// The limit.
        limit: u64,
    },
    /// The file begins like a log, but nothing in it can be used.
    #[error("nothing can be recovered from {path} ({bytes} bytes): {found}", path = path.display())]
    Nothing {
        /// The file.
        path: PathBuf,
        /// Its size.
        bytes: u64,
        /// What stopped the reader.
        found: String,
    },
    /// A topic that the log does not have.
    #[error("{path} has no topic `{topic}`; it has: {available}", path = path.display())]
    NoTopic {
        /// The file.
        path: PathBuf,
        /// The topic asked for.
        topic: String,
        /// The topics there are.
        available: String,
    },
    /// A column that the topic does not have.
    #[error("{path}: topic `{topic}` has no column `{column}`; it has: {available}", path = path.display())]
    NoColumn {
        /// The file.
        path: PathBuf,
        /// The topic.
        topic: String,
        /// The column asked for.
        column: String,
        /// The columns there are.
        available: String,
    },
    /// The records do not have the digest that the file states.
    #[error("{path}: its records have the digest {found}, but the file states {stated}", path = path.display())]
    DigestMismatch {
        /// The file.
        path: PathBuf,
        /// As written at the end of the ride.
        stated: String,
        /// As computed from the records.
        found: String,
    },
    /// The file states no digest: it was cut off before its end.
    #[error("{path} states no digest (it was cut off, or not written by twinhub); its records have {found}", path = path.display())]
    NoDigest {
        /// The file.
        path: PathBuf,
        /// As computed from the records.
        found: String,
    },
}
