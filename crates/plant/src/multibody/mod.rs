//! The multibody bicycle and cyclist: 14 degrees of freedom, nonlinear, on tyres or without slip.
//!
//! Rear frame (6), steer, two wheel spins, trunk on a spherical joint at L4-L5 (3), each leg about
//! its hip-ankle line (2). Any joint can be locked, so rigid rider, passive rider and the
//! benchmark bicycle are one code. Everything is generic over [`crate::Scalar`].

// Loops run over components of several vectors at once, index by index as in the formulas.
#![allow(clippy::needless_range_loop, clippy::manual_memcpy)]

mod batch;
mod constraint;
mod contact;
mod dynamics;
mod energy;
mod error;
mod factored;
mod inertia;
mod input_power;
mod interaction;
mod joints;
mod linearise;
mod map;
mod meanings;
mod model;
mod modes;
mod named_modes;
mod parameters;
mod paths;
mod pedalling;
mod reduced;
mod ride;
mod rider_body;
mod sensitivity;
mod sets;
mod start;
pub mod state;
mod steady;
mod step;
mod symmetry;
#[cfg(test)]
mod tests;
mod tree;
mod trunk;
mod validate;
mod vector;

pub use batch::{advance_lanes, rhs_lanes};
pub use contact::WheelContact;
pub use energy::Energy;
pub use error::MultibodyError;
pub use input_power::InputPower;
pub use interaction::{Interaction, RiderForces};
pub use linearise::{INPUTS, Linear};
pub use map::{MapPoint, map, stable_ranges_m_s};
pub use meanings::{meaning, unit};
pub use model::{Input, Multibody};
pub use modes::{Change, ModesAt, Sweep};
pub use named_modes::{NamedModes, dominant_state};
pub use parameters::{
    Air, Arms, Body, Geometry, Joint, Joints, Leg, Parameters, Rider, Tyres, Wheel,
};
pub use paths::Entry;
pub use pedalling::{PEDALLING, Pedalling, Stroke};
pub use ride::{Ride, mirrored};
pub use rider_body::{Posture, RiderBody};
pub use sensitivity::{Sensitivity, SpeedSensitivity};
pub use sets::{BULSINK_POSTURE, BulsinkBicycle, Case, Reading};
pub use start::Disturbed;
pub use state::{STATES, State, StateAccess};
pub use steady::{Course, Rear, Steady};
