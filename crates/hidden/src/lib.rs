#![forbid(unsafe_code)]
//! Sealed data: studies with a known answer, made by physics that shares no code with what
//! diagnoses them.
//!
//! ```
//! use twinhub_hidden::{Kind, Scenario};
//! let scenario = Scenario::new(Kind::OneEffect, 7);
//! let sealed = scenario.seal()?;
//! assert_eq!(sealed.answer.effects.len(), 1);
//! # Ok::<(), twinhub_hidden::SealError>(())
//! ```
//!
//! [`Scenario`] says what is hidden, [`motion`] rides it, [`sensors`] records it, [`seal`] writes
//! study and answer apart from each other. The crates that diagnose may not depend on this one; a test
//! holds them to it.

pub mod bicycle;
pub mod course;
pub mod effect;
mod grip;
pub mod lateral;
pub mod motion;
#[cfg(test)]
mod motion_test;
pub mod random;
pub mod ride;
pub mod rider;
pub mod scenario;
#[cfg(test)]
mod scenario_test;
pub mod seal;
pub mod sensors;
pub mod state;
pub mod truth;

pub use effect::{BEYOND_TOLERANCE, Effect, LIBRARY, OUTSIDE, PAIRS, Pair, Separate, same_one_way};
pub use scenario::{Hidden, Kind, Scenario};
pub use seal::{HiddenEffect, SealError, Sealed, SealedAnswer};
