//! The controller as the plant sees it.

use crate::LinkError;
use twinhub_types::{ControllerFrame, PlantFrame};

/// Something that answers each frame of the plant with one of the controller.
///
/// The plant sends frame `k` at ride time `k` ms, gets the answer to it, and applies that answer
/// from `k` to `k + 1` ms.
pub trait ControllerPort {
    /// Hands over `frame` and waits for the answer to it.
    fn exchange(&mut self, frame: &PlantFrame) -> Result<ControllerFrame, LinkError>;
}

impl<P: ControllerPort + ?Sized> ControllerPort for &mut P {
    fn exchange(&mut self, frame: &PlantFrame) -> Result<ControllerFrame, LinkError> {
        (**self).exchange(frame)
    }
}

impl<P: ControllerPort + ?Sized> ControllerPort for Box<P> {
    fn exchange(&mut self, frame: &PlantFrame) -> Result<ControllerFrame, LinkError> {
        (**self).exchange(frame)
    }
}

/// A controller in the same process and thread: a closure from frame to frame.
pub struct InProcess<F>(F);

impl<F: FnMut(&PlantFrame) -> ControllerFrame> InProcess<F> {
    /// Wraps `controller`.
    pub fn new(controller: F) -> Self {
        Self(controller)
    }
}

impl<F: FnMut(&PlantFrame) -> ControllerFrame> ControllerPort for InProcess<F> {
    fn exchange(&mut self, frame: &PlantFrame) -> Result<ControllerFrame, LinkError> {
        let answer = (self.0)(frame);
        crate::protocol::check_answer(&answer, frame.header.tick, frame.header.sequence)?;
        Ok(answer)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use twinhub_types::messages::PROTOCOL_HASH;

    #[test]
    fn an_answer_to_another_tick_is_refused_in_process_too() {
        let mut late = InProcess::new(|frame: &PlantFrame| {
            let mut answer = ControllerFrame {
                header: frame.header,
                ..Default::default()
            };
            answer.header.protocol_hash = PROTOCOL_HASH;
            answer.header.tick = frame.header.tick.min(1);
            answer
        });
        let mut frame = PlantFrame::default();
        for tick in 0..2 {
            frame.header.tick = tick;
            frame.header.sequence = tick;
            assert!(late.exchange(&frame).is_ok());
        }
        frame.header.tick = 2;
        frame.header.sequence = 2;
        let error = late
            .exchange(&frame)
            .expect_err("tick 1 is not tick 2")
            .to_string();
        assert!(
            error.contains("tick") && error.contains('1') && error.contains('2'),
            "{error}"
        );
    }
}
