//! A ride that the caller steps: for those who learn or try controllers.

use crate::bench::Bench;
use crate::error::SetupError;
use crate::metrics::{Metrics, Sums};
use crate::record::{RiderRow, TruthRow};
use crate::setup::Ride;
use crate::{TICK, TICK_S};
use twinhub_control::Controller;
use twinhub_control::law::{Demand, Law, Mechanism as _};
use twinhub_types::{Estimate, Instant, Output, PlantFrame, RideState};

/// A ride in this thread, a tick at a time, under a demand of the caller's own. Estimator, supervisor,
/// allocation and guard are the stabilizer's.
pub struct Stepper {
    bench: Bench<'static>,
    controller: Controller,
    law: Law,
    sums: Sums,
    tick: u64,
    ticks: u64,
    fell: bool,
}

/// What a tick came to.
#[derive(Clone, Debug, PartialEq)]
pub struct Stepped {
    /// What the controller was told.
    pub told: PlantFrame,
    /// The truth as the tick began, and what acted over it.
    pub truth: TruthRow,
    /// The rider over the tick.
    pub rider: RiderRow,
    /// The controller's answer.
    pub output: Output,
}

impl Stepper {
    /// The ride at its beginning.
    ///
    /// # Errors
    /// If the ride cannot be set up.
    pub fn new(ride: &Ride) -> Result<Self, SetupError> {
        Ok(Self {
            bench: Bench::new(ride, None)?,
            controller: Controller::new(&ride.law),
            law: ride.law.law,
            sums: Sums::default(),
            tick: 0,
            ticks: ride.ticks(),
            fell: false,
        })
    }

    /// Goes on by a tick. `pair_nm` is the pair that is asked for; `None` leaves it to the law.
    /// `None` comes back at the end of the ride and after a fall.
    pub fn step(&mut self, pair_nm: Option<f32>) -> Option<Stepped> {
        let truth = self.bench.plant.truth();
        self.fell |= !truth.is_finite() || truth.roll_rad.abs() > self.bench.plant.fall_roll_rad();
        if self.fell || self.tick >= self.ticks {
            return None;
        }
        let now = Instant::from_nanos(self.tick * TICK.as_nanos());
        let frame = self.bench.frame(now, self.tick, RideState::Running, &truth);
        let law = self.law;
        let mut asked = |last: &Demand, x: &Estimate, dt_s: f32| match pair_nm {
            Some(pair_nm) => Demand {
                pair_nm,
                ..Demand::default()
            },
            None => law.demand(last, x, dt_s),
        };
        let answer = self.controller.answer_by(&mut asked, &frame);
        let acts = self.bench.act(now, &truth);
        let (row, rider) = self.bench.step(now, &truth, &acts, Some(&answer));
        self.sums.add(&row, &rider, TICK_S);
        self.tick += 1;
        Some(Stepped {
            told: frame,
            truth: row,
            rider,
            output: answer.output,
        })
    }

    /// Ride time, s.
    pub fn time_s(&self) -> f64 {
        self.tick as f64 * TICK_S
    }

    /// The bicycle lies on the ground.
    pub fn fell(&self) -> bool {
        self.fell
    }

    /// The course is finished.
    pub fn finished(&self) -> bool {
        self.tick >= self.ticks
    }

    /// The numbers of the ride so far.
    pub fn metrics(&self) -> Metrics {
        self.sums.finish(self.fell, 0)
    }
}
