//! Plants: what the controller rides on. Bicycles, riders, tyres, roads, motors, batteries and
//! sensors, and their fixed-step integration. No clock, no thread, no randomness of its own.

pub mod admissible;
pub mod benchmark;
pub mod bicycles;
pub mod disturbance;
pub mod dual;
pub mod explain;
pub mod integrate;
pub mod lanes;
#[cfg(target_arch = "x86_64")]
mod lanes_avx;
pub mod motor;
pub mod multibody;
pub mod noise;
pub mod options;
pub mod rider;
pub mod road;
pub mod scalar;
pub mod sensor;
pub mod steering;
pub mod truth;
pub mod tyre;
pub mod wind;

pub use scalar::Scalar;
pub use truth::{PlantInput, PlantModel, Truth};
