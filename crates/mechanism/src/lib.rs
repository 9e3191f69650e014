#![forbid(unsafe_code)]
//! Mechanisms: causes that a simulation may lack, each with its claim, equation, parameters, source,
//! what it is confounded with and which experiment separates them.
//!
//! A mechanism acts on a lateral-longitudinal model of a bicycle through six hooks, so that the
//! same definition serves whoever simulates, fits or designs:
//!
//! * [`Mechanism::reshape`] changes the bicycle's parameters (payload, wheel radius);
//! * [`Mechanism::terms`] adds to the matrices of roll and steer (dampers, springs, inertias);
//! * [`Mechanism::wrench`] pushes with a torque, a force, or a yaw rate that slip adds, from the
//!   state, the inputs and a memory of its own (friction, play, tyre lag, wind, pedals);
//! * [`Mechanism::random_force`] is a force that no input tells of (gusts): it widens what is predicted;
//! * [`Mechanism::input`] says what the true input is when another one was commanded or read;
//! * [`Mechanism::sensor`] says what a sensor reads when the truth is another.
//!
//! With all parameters at their null values a mechanism does nothing: a test holds every one to it.

pub mod body;
pub mod card;
#[cfg(test)]
mod conformance;
pub mod extended;
pub mod hooks;
pub mod moment;
pub mod quantity;
mod registry;

mod environment;
mod input;
mod resistance;
mod rider;
mod sensor;
mod steering;
mod structure;
mod tyre;

pub use body::{Body, Terms};
pub use card::{Card, Equation, Family, Param, Requirement};
pub use extended::{Accepted, ExtendedError};
pub use hooks::{InputModel, Mechanism, RandomForce, SensorModel};
pub use moment::{Inputs, Moment, Wrench};
pub use quantity::Quantity;
pub use registry::{ALL, find, names};
