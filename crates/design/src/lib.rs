#![forbid(unsafe_code)]
//! Conic programs, solved by Clarabel: what the controller does in closed form, checked against the
//! problem that it solves.

pub mod oracle;

pub use oracle::{Oracle, OracleError, Road};
