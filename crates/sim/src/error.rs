//! Why a ride cannot be set up or did not end.

use std::path::PathBuf;

/// Why a ride cannot be set up: always the user's to mend.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SetupError {
    /// Neither a name that ships nor a file.
    #[error("no {kind} `{found}`: neither a file nor one that ships ({})", .shipped.join(", "))]
    NotFound {
        /// "course", "rider", "law" or "scenario".
        kind: &'static str,
        /// What was asked for.
        found: String,
        /// What ships.
        shipped: Vec<&'static str>,
    },
    /// A file that cannot be read.
    #[error("{path}: cannot be read: {source}")]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// A file that is not what it should be; the message has line, column and what was expected.
    #[error("{origin}: {detail}")]
    Format {
        /// The file, or the name that ships.
        origin: String,
        /// What the reader says.
        detail: String,
    },
    /// A number out of range.
    #[error("{origin}: `{key}` is {found}, accepted is {accepted}")]
    OutOfRange {
        /// The file, or the name that ships.
        origin: String,
        /// The key.
        key: String,
        /// What was found.
        found: String,
        /// What would be accepted.
        accepted: &'static str,
    },
    /// An assignment on the command line.
    #[error("--set {assignment}: {detail}")]
    Override {
        /// `path=value` as given.
        assignment: String,
        /// What is wrong.
        detail: String,
    },
    /// The bicycle.
    #[error(transparent)]
    Bicycle(#[from] twinhub_linear::BicycleError),
    /// A bicycle of either kind.
    #[error(transparent)]
    Load(#[from] twinhub_plant::bicycles::LoadError),
    /// The multibody model.
    #[error(transparent)]
    Multibody(#[from] twinhub_plant::multibody::MultibodyError),
    /// The rider.
    #[error("{origin}: {source}")]
    Rider {
        /// The file, or the name that ships.
        origin: String,
        /// What is wrong.
        source: twinhub_plant::rider::RiderError,
    },
    /// The law.
    #[error("{origin}: {detail}")]
    Law {
        /// The file, or the name that ships.
        origin: String,
        /// What is wrong.
        detail: String,
    },
}

/// Why a ride that had begun did not end as it should.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RideError {
    /// The plant could not be built.
    #[error(transparent)]
    Setup(#[from] SetupError),
    /// The link to the controller.
    #[error(transparent)]
    Link(#[from] twinhub_link::LinkError),
    /// The log.
    #[error(transparent)]
    Log(#[from] twinhub_log::LogError),
    /// The plant gave a number that is none; the log ends there.
    #[error(
        "the plant's state is not finite at tick {tick}; this is a fault of the model, not of the ride"
    )]
    NotFinite {
        /// The tick.
        tick: u64,
    },
}
