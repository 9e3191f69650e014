//! The tick.

use twinhub_types::messages::PROTOCOL_HASH;
use twinhub_types::{
    ControllerFrame, Estimate, Header, Instant, Measurement, Output, PlantFrame, RiderIntent,
};

use crate::allocation::{Allocation, Envelope};
use crate::clock::Clock;
use crate::config::Config;
use crate::doubt::Doubter;
use crate::estimator::Estimator;
use crate::fork::ForkLife;
use crate::guard::{Guard, GuardLimits};
use crate::law::{Demand, Law, Mechanism as _};
use crate::senses::Senses;
use crate::supervisor::Supervisor;

/// The stabilizer of one bicycle: plain data of fixed size.
#[derive(Clone, Copy, Debug)]
pub struct Controller {
    clock: Clock,
    senses: Senses,
    estimator: Estimator,
    doubter: Doubter,
    supervisor: Supervisor,
    law: Law,
    demand: Demand,
    limits: Envelope,
    allocation: Allocation,
    guard: Guard,
    front_wheel_radius_m: f32,
    fork: ForkLife,
}

impl Controller {
    /// A controller at rest. One that is given a configuration which breaks a rule
    /// ([`Config::check`]) reports `CONFIG_REFUSED` in every tick and never asks for torque.
    pub fn new(config: &Config) -> Self {
        let refused = config.check().is_err();
        let config = if refused { &Config::NO_TORQUE } else { config };
        Self {
            clock: Clock::default(),
            senses: Senses::default(),
            estimator: Estimator::new(&config.bicycle),
            doubter: Doubter::new(&config.bicycle),
            supervisor: Supervisor::new(config, refused),
            law: config.law,
            demand: Demand::default(),
            limits: Envelope::new(config),
            allocation: Allocation::new(config),
            guard: Guard::new(GuardLimits::new(config)),
            front_wheel_radius_m: config.bicycle.front_wheel_radius_m,
            fork: ForkLife::new(0),
        }
    }

    /// The same controller on a fork that has been used before ([`ForkLife::used`]).
    pub fn on_fork(self, fork: ForkLife) -> Self {
        Self { fork, ..self }
    }

    /// How much of its life the fork has used: to be stored while the bicycle is switched off.
    pub fn fork(&self) -> &ForkLife {
        &self.fork
    }

    /// One tick: what the motors should do, given what the sensors and the rider say.
    ///
    /// To be called every millisecond; `now` and all stamps share one clock. Any bit pattern is
    /// accepted: what is missing, stale or absurd raises a health flag and ramps the torque.
    pub fn step(&mut self, now: Instant, meas: &Measurement, rider: &RiderIntent) -> Output {
        self.tick(now, meas, rider, |law, last, x, dt_s| {
            law.demand(last, x, dt_s)
        })
    }

    /// The same tick under a law of the caller's own, which is told its last demand, the estimate and
    /// the time since then, s. Estimator, supervisor, allocation and guard stay what they are, so
    /// nothing that it asks for breaks a limit.
    pub fn step_by(
        &mut self,
        law: &mut dyn FnMut(&Demand, &Estimate, f32) -> Demand,
        now: Instant,
        meas: &Measurement,
        rider: &RiderIntent,
    ) -> Output {
        self.tick(now, meas, rider, |_, last, x, dt_s| law(last, x, dt_s))
    }

    #[inline]
    fn tick(
        &mut self,
        now: Instant,
        meas: &Measurement,
        rider: &RiderIntent,
        law: impl FnOnce(&Law, &Demand, &Estimate, f32) -> Demand,
    ) -> Output {
        let tick = self.clock.tick(now);
        let seen = self.senses.read(now, meas, rider);
        let x = self.estimator.update(&tick, &seen);
        let doubts = self.doubter.update(&tick, &seen, &x);
        let mode = self.supervisor.update(&tick, &seen, &x, doubts);
        let demand = law(&self.law, &self.demand, &x, tick.credit_s);
        let bounds = self
            .limits
            .at(&x, self.supervisor.share_ratio(), self.fork.share_ratio());
        let request = self.allocation.split(&demand, &bounds);
        let command = self.guard.apply(now, meas, rider, mode, &request);
        self.fork
            .add(command.front_brake_nm / self.front_wheel_radius_m);
        self.demand = demand;
        Output {
            command,
            demand_nm: demand.pair_nm,
            mode: mode as u32,
            health: self.supervisor.health().bits(),
            limited_by: self.guard.limited_by().bits(),
            estimate: x,
        }
    }

    /// One tick as the link has it: the answer to the plant's `frame`.
    pub fn answer(&mut self, frame: &PlantFrame) -> ControllerFrame {
        let now = Instant::from_nanos(frame.header.time_ns);
        framed(frame, self.step(now, &frame.measurement, &frame.intent))
    }

    /// The same under a law of the caller's own; see [`step_by`](Self::step_by).
    pub fn answer_by(
        &mut self,
        law: &mut dyn FnMut(&Demand, &Estimate, f32) -> Demand,
        frame: &PlantFrame,
    ) -> ControllerFrame {
        let now = Instant::from_nanos(frame.header.time_ns);
        framed(
            frame,
            self.step_by(law, now, &frame.measurement, &frame.intent),
        )
    }
}

fn framed(frame: &PlantFrame, output: Output) -> ControllerFrame {
    ControllerFrame {
        header: Header {
            protocol_hash: PROTOCOL_HASH,
            ..frame.header
        },
        output,
    }
}
