//! The six hooks through which a mechanism acts.

use crate::body::Terms;
use crate::card::Card;
use crate::moment::{Moment, Wrench};
use crate::quantity::Quantity;
use twinhub_linear::Parameters;

/// How the true input follows from the one that was commanded or read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InputModel {
    /// True value per value read.
    pub gain: f64,
    /// First-order lag from the command to the truth, s.
    pub lag_s: f64,
    /// The truth follows so much later, s.
    pub delay_s: f64,
    /// The truth stays within this.
    pub limit: f64,
    /// Added to the truth while the command is zero, with the sign that brakes the wheel.
    pub idle_drag: f64,
    pub offset: f64,
}

impl InputModel {
    pub const IDEAL: Self = Self {
        gain: 1.0,
        lag_s: 0.0,
        delay_s: 0.0,
        limit: f64::INFINITY,
        idle_drag: 0.0,
        offset: 0.0,
    };
}

/// How a reading follows from the truth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SensorModel {
    /// Reading per truth.
    pub gain: f64,
    pub offset: f64,
    /// Later than declared, s.
    pub delay_s: f64,
    /// Yaw rate that a roll-rate gyro sees besides, per yaw rate.
    pub yaw_share: f64,
    /// Step that the reading is rounded to, beside the declared one.
    pub quantum: f64,
}

impl SensorModel {
    pub const IDEAL: Self = Self {
        gain: 1.0,
        offset: 0.0,
        delay_s: 0.0,
        yaw_share: 0.0,
        quantum: 0.0,
    };
}

/// A slow random force: a first-order Markov process.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RandomForce {
    /// Standard deviation, in N if the arm is in m.
    pub sd: f64,
    /// Correlation time, s.
    pub time_s: f64,
    /// Roll and steer torque per force.
    pub arm: [f64; 2],
}

/// A cause. `p` holds its parameters in the order of the card.
pub trait Mechanism: Sync + std::fmt::Debug {
    /// What is written about it.
    fn card(&self) -> &'static Card;

    /// Parameters at which it is absent.
    fn null(&self, _bicycle: &Parameters) -> Vec<f64> {
        self.card().parameters.iter().map(|p| p.null).collect()
    }

    /// Parameter sets whose effects span the small effects of the mechanism; by default the first
    /// parameter's probe.
    fn probes(&self, bicycle: &Parameters) -> Vec<Vec<f64>> {
        let mut p = self.null(bicycle);
        p[0] += self.card().parameters[0].probe;
        vec![p]
    }

    /// Parameters of a small effect that is `c` times the probes.
    fn from_probes(&self, c: &[f64], bicycle: &Parameters) -> Vec<f64> {
        let mut p = self.null(bicycle);
        p[0] += c[0] * self.card().parameters[0].probe;
        p
    }

    /// Whether every ride has a phase of its own, which only the ride can tell: the rate of a wheel does not
    /// say how the wheel stood at first. The probes are then the effect and the effect a quarter of a turn
    /// later.
    fn has_phase_by_ride(&self) -> bool {
        false
    }

    /// Changes the bicycle's parameters.
    fn reshape(&self, _p: &[f64], _bicycle: &mut Parameters) {}

    /// Adds to the matrices of roll and steer.
    fn terms(&self, _p: &[f64], _terms: &mut Terms) {}

    /// Whether `wrench` does anything.
    fn pushes(&self) -> bool {
        false
    }

    /// Whether the wrench depends on roll and steer without a memory, so that a predictor should
    /// linearise it.
    fn feeds_back(&self) -> bool {
        false
    }

    /// What it adds to the equations at a moment.
    fn wrench(&self, _p: &[f64], _at: &Moment<'_>, _memory: &[f64]) -> Wrench {
        Wrench::default()
    }

    /// Whether it is random: no input says when it acts, so that it shows in the spread of what is
    /// predicted and not in its mean.
    fn is_random(&self) -> bool {
        false
    }

    /// The random force that it adds.
    fn random_force(&self, _p: &[f64], _bicycle: &Parameters) -> Option<RandomForce> {
        None
    }

    /// Number of values that it remembers.
    fn memory(&self) -> usize {
        0
    }

    /// Moves the memory over the step of `at`; `fresh` at the start of a window.
    fn remember(&self, _p: &[f64], _at: &Moment<'_>, _memory: &mut [f64], _fresh: bool) {}

    /// Changes how an input of a quantity acts.
    fn input(&self, _p: &[f64], _quantity: Quantity, _model: &mut InputModel) {}

    /// Delay that it adds to a known feedback law.
    fn law_delay_s(&self, _p: &[f64]) -> f64 {
        0.0
    }

    /// Whether `reading` does anything.
    fn reads(&self) -> bool {
        false
    }

    /// Added to the reading of a sensor, beyond what `sensor` says.
    fn reading(&self, _p: &[f64], _quantity: Quantity, _at: &Moment<'_>) -> f64 {
        0.0
    }

    /// Changes what a sensor of a quantity reads.
    fn sensor(&self, _p: &[f64], _quantity: Quantity, _model: &mut SensorModel) {}
}
