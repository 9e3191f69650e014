#![no_std]
#![forbid(unsafe_code)]
//! The vocabulary that every crate of twinhub shares: messages, time, signs, health flags and
//! the `registry!` macro. `no_std`, no allocation, no dependency.

pub mod conventions;
pub mod health;
pub mod messages;
mod registry;
pub mod stream;
pub mod time;
pub mod wire;

pub use health::{Health, HealthEntry, LimitEntry, LimitedBy, Mode};
pub use messages::{
    Command, ControllerFrame, Estimate, Header, ImuSample, Measurement, MotorSample, Output,
    PlantFrame, RideState, RiderIntent, RollSample, SteerSample, WheelSample,
};
pub use time::{Duration, Instant, NEVER_NS};
pub use wire::{Field, Message, Wire};
