//! The controller as the plant sees it.

use crate::LinkError;
use crate::account::ControllerTiming;
use crate::timing::Timing;
use twinhub_types::{ControllerFrame, PlantFrame};

/// Something that happened on the link and is worth telling.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LinkEvent {
    /// True for a warning, false for news.
    pub warning: bool,
    /// A stable code: `link.late_tick`.
    pub code: &'static str,
    /// A sentence.
    pub text: String,
}

impl LinkEvent {
    /// A warning.
    pub fn warning(code: &'static str, text: String) -> Self {
        Self {
            warning: true,
            code,
            text,
        }
    }

    /// News.
    pub fn info(code: &'static str, text: String) -> Self {
        Self {
            warning: false,
            code,
            text,
        }
    }
}

/// Something that answers the frames of the plant: what every target implements.
///
/// The plant sends frame `k` at ride time `k` ms, gets an answer, and applies it from `k` to
/// `k + 1` ms. Only [`exchange_during`](Self::exchange_during) has to be there; the rest is for reports.
pub trait ControllerPort {
    /// Hands over `frame`, does `meanwhile` once while the answer is on its way, and waits for an
    /// answer that may be applied in its tick; `None` is silence, which the drives notice. In
    /// lockstep every frame has its own answer. An exchange that fails may leave `meanwhile` undone.
    ///
    /// # Errors
    /// If the controller is lost for good. The port is not used any more after that.
    fn exchange_during(
        &mut self,
        frame: &PlantFrame,
        meanwhile: &mut dyn FnMut(),
    ) -> Result<Option<ControllerFrame>, LinkError>;

    /// The same with nothing to do meanwhile.
    ///
    /// # Errors
    /// As [`exchange_during`](Self::exchange_during).
    #[inline]
    fn exchange(&mut self, frame: &PlantFrame) -> Result<Option<ControllerFrame>, LinkError> {
        self.exchange_during(frame, &mut || {})
    }

    /// What happened on the way and was not told yet, oldest first.
    fn next_event(&mut self) -> Option<LinkEvent> {
        None
    }

    /// What the controller's process says about itself.
    fn controller_timing(&self) -> Option<ControllerTiming> {
        None
    }

    /// Instructions that the controller took for its last answer, where its target counts them.
    fn instructions(&self) -> Option<u64> {
        None
    }

    /// How long the exchanges took so far, where somebody measures them.
    fn timing(&self) -> Option<Timing> {
        None
    }
}

macro_rules! forward {
    ($ty:ty) => {
        impl<P: ControllerPort + ?Sized> ControllerPort for $ty {
            #[inline]
            fn exchange_during(
                &mut self,
                frame: &PlantFrame,
                meanwhile: &mut dyn FnMut(),
            ) -> Result<Option<ControllerFrame>, LinkError> {
                (**self).exchange_during(frame, meanwhile)
            }
            fn next_event(&mut self) -> Option<LinkEvent> {
                (**self).next_event()
            }
            fn controller_timing(&self) -> Option<ControllerTiming> {
                (**self).controller_timing()
            }
            fn instructions(&self) -> Option<u64> {
                (**self).instructions()
            }
            fn timing(&self) -> Option<Timing> {
                (**self).timing()
            }
        }
    };
}
forward!(&mut P);
forward!(Box<P>);

/// A controller in the same process and thread: a closure from frame to frame.
pub struct InProcess<F>(F);

impl<F: FnMut(&PlantFrame) -> ControllerFrame> InProcess<F> {
    /// Wraps `controller`.
    pub fn new(controller: F) -> Self {
        Self(controller)
    }
}

impl<F: FnMut(&PlantFrame) -> ControllerFrame> ControllerPort for InProcess<F> {
    #[inline]
    fn exchange_during(
        &mut self,
        frame: &PlantFrame,
        meanwhile: &mut dyn FnMut(),
    ) -> Result<Option<ControllerFrame>, LinkError> {
        let answer = (self.0)(frame);
        meanwhile();
        crate::protocol::check_answer(&answer, frame.header.tick, frame.header.sequence)?;
        Ok(Some(answer))
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
