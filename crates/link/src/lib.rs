//! The link between plant and controller: one frame each way and tick.
//!
//! * [`ControllerPort`] is the controller as the plant sees it. A ride does not know what stands
//!   behind it: [`InProcess`] calls a closure, [`ipc::PlantEnd`] talks to another process.
//! * [`protocol`] is the one place that says what goes over the link, in what order, and what
//!   each side does when the other is gone.
//! * [`ride`] says where rides live, who may join, and how what dead rides leave is removed.
//!
//! Linux only: it watches the other process by a pidfd (5.3 or newer).

mod bell;
mod error;
pub mod hello;
pub mod ipc;
mod parent;
mod peer;
mod port;
pub mod protocol;
pub mod ride;
mod shm;
mod wait;

pub use error::LinkError;
pub use hello::Identity;
pub use ipc::{ControllerEnd, PlantEnd, PlantOffer, Settings};
pub use parent::watch_parent;
pub use port::{ControllerPort, InProcess};
pub use ride::{RideName, RunDir, leftovers};
pub use wait::{Notice, Waiting};
