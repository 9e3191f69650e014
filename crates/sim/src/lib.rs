#![forbid(unsafe_code)]
//! The plant side of the closed loop: courses, rides, metrics.
//!
//! A ride is deterministic: the same [`setup::Ride`] gives the same log digest, in process or over
//! shared memory, in debug and release. Nothing here has a clock or a thread of its own.
//!
//! Read [`closed_loop`] first: it is the tick.

mod bench;
pub mod bicycle;
pub mod choice;
pub mod closed_loop;
mod controller;
pub mod course;
mod error;
mod logger;
pub mod metrics;
mod overrides;
pub mod plant;
pub mod record;
mod resolve;
pub mod scenario;
pub mod setup;
pub mod shipped;
pub mod stepper;
pub mod things;

pub use bench::{OwnRider, device};
pub use closed_loop::{Ending, Outcome, Progress, Settings, ride, ride_as};
pub use controller::in_process;
pub use error::{RideError, SetupError};
pub use metrics::Metrics;
pub use setup::Ride;
pub use stepper::{Stepped, Stepper};

use twinhub_types::Duration;

/// The tick of the closed loop.
pub const TICK: Duration = twinhub_types::conventions::TICK;

/// The tick of the closed loop, s.
pub const TICK_S: f64 = 1e-3;
