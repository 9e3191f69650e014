#![no_std]
#![forbid(unsafe_code)]
//! The stabilizer: from what the bicycle's sensors say to the torques of its two hub motors,
//! once per tick. `no_std`, no allocation, no clock of its own, no panic, `f32`.
//!
//! Read [`step`] first. One tick is
//! [`Senses`](senses::Senses) (which samples can be believed), the [`estimator`], [`doubt`] (which of
//! them contradict each other), the [`supervisor`] (mode and health), the [`law`] (how large a pair), the [`allocation`] (how much
//! of it the tyres carry) and the [`guard`], which trusts none of the others. The [`fork`] counts what
//! comes out.
//!
//! The pair is parametric: straight and upright it pushes the bicycle nowhere, it stiffens the
//! steering. So its magnitude is scheduled over speed and changed slowly; it is not fed back.
//!
//! ```
//! use twinhub_control::{Config, Controller};
//! use twinhub_types::{Instant, Measurement, RiderIntent};
//! # let text = include_str!("../laws/scheduled.toml");
//! let config: Config = toml::from_str(text)?;
//! let mut controller = Controller::new(&config);
//! let output = controller.step(Instant::START, &Measurement::default(), &RiderIntent::default());
//! assert_eq!(output.command.front_brake_nm, 0.0);
//! # Ok::<(), toml::de::Error>(())
//! ```

#[cfg(test)]
extern crate std;

pub mod allocation;
pub mod belief;
mod bounded;
pub mod certificate;
pub mod clock;
pub mod config;
pub mod doubt;
pub mod estimator;
pub mod fork;
pub mod guard;
pub mod law;
pub mod schedule;
pub mod senses;
pub mod step;
pub mod supervisor;
pub mod supply;

pub use certificate::Certificate;
pub use config::{Bicycle, Config, ConfigError, Limits, Profile};
pub use fork::ForkLife;
pub use law::Law;
pub use schedule::{Point, Schedule};
pub use step::Controller;
