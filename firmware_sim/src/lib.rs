//! The controller process: the control crate in a fixed-step loop behind the link.
//!
//! [`Firmware::tick`] is all that happens in a tick: [`twinhub_control::Controller::answer`], which a
//! plant may also call in its own process, with the same bits. This crate never sees the plant.

pub mod adversarial;
pub mod cortex_m;
mod law_file;
mod loss;
pub mod replay;
mod run;
mod summary;

pub use law_file::{LawFileError, parse_law, read_law};
pub use loss::{Loss, LossEvent};
pub use run::{Options, run};
pub use summary::{Ended, Summary};

use twinhub_control::{Config, Controller};
use twinhub_types::{ControllerFrame, Instant, Output, PlantFrame};

/// The controller with the last frame that it was given.
pub struct Firmware {
    controller: Controller,
    last: PlantFrame,
    output: Output,
}

impl Firmware {
    /// A controller at rest.
    pub fn new(config: &Config) -> Self {
        Self {
            controller: Controller::new(config),
            last: PlantFrame::default(),
            output: Output::default(),
        }
    }

    /// One tick: the answer to the plant's `frame`.
    #[inline]
    pub fn tick(&mut self, frame: &PlantFrame) -> ControllerFrame {
        let answer = self.controller.answer(frame);
        (self.last, self.output) = (*frame, answer.output);
        answer
    }

    /// One tick without a frame: the clock goes on, the samples of the last frame grow older.
    pub fn tick_without_frame(&mut self) -> &Output {
        let tick_ns = twinhub_types::conventions::TICK.as_nanos();
        self.last.header.time_ns = self.last.header.time_ns.saturating_add(tick_ns);
        let now = Instant::from_nanos(self.last.header.time_ns);
        self.output = self
            .controller
            .step(now, &self.last.measurement, &self.last.intent);
        &self.output
    }

    /// True while the controller asks for no torque.
    pub fn is_quiet(&self) -> bool {
        let command = &self.output.command;
        command.front_brake_nm == 0.0 && command.rear_traction_nm == 0.0
    }

    /// What the controller asked for last.
    pub fn output(&self) -> &Output {
        &self.output
    }
}
