//! The link between plant and controller: one frame each way and tick.
//!
//! * [`ControllerPort`] is the controller as the plant sees it. A ride does not know what stands
//!   behind it: [`InProcess`] calls a closure, [`ipc::PlantEnd`] talks to another process over
//!   shared memory, [`stream::StreamEnd`] to whatever speaks the byte stream.
//!   [`Timed`] wraps any of them, paces it and measures it.
//! * [`pacing`] says when a tick begins, in lockstep and in real time, and what a late one means.
//! * [`protocol`] is the one place that says what goes over the link, in what order, and what
//!   each side does when the other is gone.
//! * [`ride`] says where rides live, who may join, and how what dead rides leave is removed.
//!
//! Linux only: it watches the other process by a pidfd (5.3 or newer).

mod account;
mod cores;
pub mod doctor;
mod error;
pub mod fault;
mod faulty;
pub mod hello;
pub mod ipc;
mod newest;
pub mod pacing;
mod page;
mod parent;
mod peer;
mod port;
pub mod protocol;
pub mod ride;
mod rights;
mod shm;
pub mod stream;
pub mod timing;
mod wait;
pub mod wires;

pub use account::{Account, ControllerTiming};
pub use error::LinkError;
pub use faulty::Faulty;
pub use hello::Identity;
pub use ipc::{ControllerEnd, PlantEnd, PlantOffer, Settings};
pub use pacing::Pacing;
pub use parent::watch_parent;
pub use port::{ControllerPort, InProcess, LinkEvent};
pub use ride::{RideName, RunDir, leftovers};
pub use rights::Rights;
pub use timing::{Timed, Timing};
pub use wait::{Notice, Waiting};
