#![forbid(unsafe_code)]
//! Identification: measured rides against the benchmark bicycle by prediction.
//!
//! A [`Ride`] says what drove the bicycle and what was read. [`Equations`] turn it into a [`Track`]
//! of exact steps; [`noise::estimate`] finds the noise levels, [`Filter`] predicts, and
//! [`forecast::forecast`] runs the model free from the predictor's state.
//!
//! Apart from that, [`FourPoles`] is the state-space fit of Bulsink (2017): weave from the response
//! to a push.

pub mod dense;
pub mod equations;
#[cfg(test)]
mod equations_test;
pub mod filter;
pub mod forecast;
pub mod four_pole;
pub mod noise;
pub mod ride;
pub mod signal;
pub mod track;
pub mod transition;

pub use equations::Equations;
pub use filter::{Estimate, Filter, Levels, Listener};
pub use four_pole::{FourPoleError, FourPoles, Response};
pub use noise::{NoiseEstimate, Range};
pub use ride::{Drive, Gain, Law, NoiseLevel, Output, Ride, Sensor, Window};
pub use signal::{Hold, Signal};
pub use track::{Reading, Track};
