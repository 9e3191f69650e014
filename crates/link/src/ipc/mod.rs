//! Both ends of a ride between two processes.
//!
//! The ends belong to the thread that made them. A stop flag ends every wait within 20 ms; it is
//! looked at only while waiting, so that a ride that is stopped can still exchange its last frame.

mod controller;
mod offer;
mod plant;
mod settings;

pub use controller::ControllerEnd;
pub use offer::PlantOffer;
pub use plant::PlantEnd;
pub use settings::Settings;

use crate::LinkError;

fn closed() -> LinkError {
    LinkError::shared_memory("using the link", "it is closed")
}
