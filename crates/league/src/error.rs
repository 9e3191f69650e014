//! Why a league cannot be run or put together.

use std::path::PathBuf;
use twinhub_sim::{RideError, SetupError};

/// Why a league cannot be run or put together.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum LeagueError {
    /// A number is out of range.
    #[error("{key} is {found}; accepted is {accepted}")]
    OutOfRange {
        /// What.
        key: &'static str,
        /// What was found.
        found: String,
        /// What would be accepted.
        accepted: String,
    },
    /// A controller is named twice.
    #[error("controller `{name}` is named twice; every controller rides once")]
    Twice {
        /// Its name.
        name: String,
    },
    /// A controller, course or rider cannot be set up.
    #[error(transparent)]
    Setup(#[from] SetupError),
    /// A ride did not end.
    #[error("part {part}, controller `{controller}`: {source}")]
    Ride {
        /// Number of the part.
        part: u64,
        /// The controller.
        controller: String,
        /// Why.
        source: RideError,
    },
    /// The bicycle has no steady state to practise at, or no rider can be made for it.
    #[error("riders for `{bicycle}`: {detail}")]
    Riders {
        /// The bicycle.
        bicycle: String,
        /// Why.
        detail: String,
    },
    /// A file cannot be used.
    #[error("{path}: {source}")]
    File {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// A file is not what it should be.
    #[error(
        "{path}, line {line}: {detail}; accepted: a file that `twinhub league --out` has written"
    )]
    Format {
        /// The file.
        path: PathBuf,
        /// Line, from 1.
        line: usize,
        /// What is wrong.
        detail: String,
    },
    /// A file belongs to another league.
    #[error(
        "{path}: written for another league: {detail}; accepted: the same seed, riders, classes, controllers and profile"
    )]
    OtherLeague {
        /// The file.
        path: PathBuf,
        /// What differs.
        detail: String,
    },
    /// Two files disagree about a part.
    #[error(
        "{path}: part {part} differs from what another file says; the files come from different programs or machines that do not compute alike"
    )]
    Conflict {
        /// The file.
        path: PathBuf,
        /// The part.
        part: u64,
    },
}
