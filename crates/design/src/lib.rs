#![forbid(unsafe_code)]
//! Conic programs, solved by Clarabel: schedules with their certificates, and what the controller
//! does in closed form checked against the problem that it solves.
//!
//! [`plan::run`] finds a schedule and proves it, [`check::check`] checks the proof without a solver,
//! [`oracle`] is the allocation's problem.

pub mod ask;
pub mod certificate;
pub mod check;
pub mod cone;
pub mod family;
pub mod gains;
pub mod inequality;
pub mod law;
pub mod loops;
pub mod march;
pub mod oracle;
pub mod plan;
pub mod program;
pub mod proof;
pub mod schedule;
pub mod start;
pub mod stops;
pub mod summary;
pub mod symmetric;

pub use ask::Ask;
pub use certificate::{Certificate, Plan};
pub use oracle::{Oracle, OracleError, Power, Road, Wish};

/// Why there is no schedule or certificate.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum DesignError {
    /// The bicycle has no such model.
    #[error("{0}")]
    Model(String),
    /// The plan breaks a rule.
    #[error("{0}")]
    Plan(String),
    /// The solver, or the linear algebra around it, has no answer.
    #[error("{0}")]
    Solver(String),
    /// The user stopped it.
    #[error("stopped")]
    Stopped,
}
