//! The controller in the plant's own process.

use twinhub_control::{Config, Controller};
use twinhub_types::{ControllerFrame, PlantFrame};

/// The controller behind [`InProcess`](twinhub_link::InProcess): frame in, frame out, the same bits
/// as the controller's process gives.
pub fn in_process(config: &Config) -> impl FnMut(&PlantFrame) -> ControllerFrame + Send + use<> {
    let mut controller = Controller::new(config);
    move |frame| controller.answer(frame)
}
