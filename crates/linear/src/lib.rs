#![forbid(unsafe_code)]
//! The Whipple-Carvallo benchmark bicycle: parameters, linearised equations, modes, and the speeds
//! at which they become stable or unstable.
//!
//! ```
//! use twinhub_linear::{Bicycle, Canonical, MotorPair};
//! let bicycle = Bicycle::load("meijaard2007_benchmark")?;
//! let equations = Canonical::new(&bicycle)?;
//! let pair = MotorPair::balanced(20.0, &bicycle);
//! let a = equations.state_matrix(5.0, pair);
//! assert_eq!(a[(0, 2)], 1.0);
//! # Ok::<(), twinhub_linear::BicycleError>(())
//! ```

mod added;
mod benchmark_file;
mod bicycle;
mod bulsink;
mod canonical;
mod critical;
mod double_double;
mod eigen;
mod error;
mod follow;
mod load;
mod modes;
mod motor_pair;
mod names;
mod parameters;
mod quartic;
mod rigid_body;
pub mod sets;
mod validate;

pub use added::{Added, NamedMechanism};
pub use bicycle::Bicycle;
pub use canonical::Canonical;
pub use critical::Crossing;
pub use eigen::{EigenError, Eigenpair, eigenpairs};
pub use error::BicycleError;
pub use follow::{continuation, follow};
pub use modes::{Critical, Mode, Modes, Point, Verdict};
pub use motor_pair::MotorPair;
pub use names::{Layout, ModeName, name};
pub use parameters::{Parameters, SYMBOLS, unit};
