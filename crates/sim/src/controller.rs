//! The controller crate in the process of the plant, behind the same frames as over the link.

use twinhub_control::{Config, Controller};
use twinhub_types::messages::PROTOCOL_HASH;
use twinhub_types::{ControllerFrame, Header, Instant, PlantFrame};

/// A controller at rest, for a [`twinhub_link::InProcess`] port: it answers each frame with the
/// bits that the controller process answers it with.
pub fn in_process(config: &Config) -> impl FnMut(&PlantFrame) -> ControllerFrame + Send + use<> {
    let mut controller = Controller::new(config);
    move |frame| {
        let now = Instant::from_nanos(frame.header.time_ns);
        let output = controller.step(now, &frame.measurement, &frame.intent);
        let header = Header {
            protocol_hash: PROTOCOL_HASH,
            ..frame.header
        };
        ControllerFrame { header, output }
    }
}
