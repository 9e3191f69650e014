//! The predictor that diagnosis rests on: a bicycle with mechanisms, over measured rides.
//!
//! [`Prepared`] is a ride cut into steps; a [`Model`] predicts it in one [`Pass`]; and
//! [`sensitivity`] says how the innovations change with the plant without another pass.

mod acting;
pub mod course;
mod flow;
pub mod forecast;
mod free;
mod lateral;
mod layout;
mod linear;
pub mod pass;
mod readings;
pub mod ride;
pub mod sensitivity;
pub mod setup;
pub mod small;
mod speed;
mod state;
pub mod way;

pub use layout::latent_state;
pub use pass::{Pass, Prepared};
pub use ride::{FreeNoise, Refusal, Ride};
pub use setup::{Active, Latent, Levels, Model, Plant};
