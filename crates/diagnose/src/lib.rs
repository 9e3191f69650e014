#![forbid(unsafe_code)]
//! What the simulation gets wrong: measured rides against the model.
//!
//! [`Study`] is the file that names rides, channels and bicycle; [`data`] reads the rides;
//! [`compare`] predicts them and says how far the model is off.

pub mod compare;
pub mod data;
pub mod engine;
pub mod search;
pub mod study;

pub use search::{Answer, DiagnoseError, Options, Verdict, diagnose, diagnose_in};
pub use study::{Study, StudyError};
pub use twinhub_mechanism::{Quantity, quantity};
