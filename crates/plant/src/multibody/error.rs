//! What can go wrong with a multibody model.

use crate::tyre::TyreError;
use thiserror::Error;

/// Why a model, a parameter or a steady state is refused.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum MultibodyError {
    /// A parameter lies outside its range.
    #[error("{path} = {found}; accepted: {accepted}")]
    OutOfRange {
        /// Dotted path.
        path: String,
        /// What was found.
        found: f64,
        /// What would be accepted.
        accepted: &'static str,
    },
    /// No parameter of that name.
    #[error("no parameter {found}{hint}")]
    UnknownPath {
        /// What was asked for.
        found: String,
        /// A near name, if any.
        hint: String,
    },
    /// A value of the wrong kind.
    #[error("{path} = {found}: accepted: {accepted}")]
    Kind {
        /// Dotted path.
        path: String,
        /// What was given.
        found: String,
        /// What would be accepted.
        accepted: String,
    },
    /// A tyre is refused.
    #[error("{wheel} {source}")]
    Tyre {
        /// Which wheel.
        wheel: &'static str,
        /// Why.
        #[source]
        source: TyreError,
    },
    /// One wheel rolls without slip and the other does not.
    #[error("rear tyre {rear}, front tyre {front}: accepted: both no_slip, or neither")]
    MixedConstraint {
        /// Rear tyre.
        rear: &'static str,
        /// Front tyre.
        front: &'static str,
    },
    /// The file does not parse.
    #[error("{message}")]
    Toml {
        /// What the parser said, with place.
        message: String,
    },
    /// No steady state was found.
    #[error(
        "no steady state at {speed_m_s} m/s after {iterations} iterations (residual {residual:.1e}, \
         accepted 1e-9): the tyres cannot carry the torques, or the state is past a limit"
    )]
    NoSteadyState {
        /// Speed asked for, m/s.
        speed_m_s: f64,
        /// Newton steps taken.
        iterations: usize,
        /// Largest residual left.
        residual: f64,
    },
    /// Eigenvalues were not found.
    #[error("{message}")]
    Eigenvalues {
        /// What the solver said.
        message: String,
    },
    /// Speed outside the range of the model.
    #[error("speed {found} m/s; accepted: {accepted}")]
    Speed {
        /// Speed asked for, m/s.
        found: f64,
        /// What would be accepted.
        accepted: &'static str,
    },
}
