//! The link between plant and controller: one frame each way and tick.
//!
//! * [`ControllerPort`] is the controller as the plant sees it. A ride does not know what stands
//!   behind it: [`InProcess`] calls a closure, `ipc::PlantEnd` talks to another process.
//! * [`protocol`] is the one place that says what goes over the link, in what order, and what
//!   each side does when the other is gone.

mod error;
mod port;
pub mod protocol;

pub use error::LinkError;
pub use port::{ControllerPort, InProcess};
