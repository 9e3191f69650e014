//! What a pass over a ride leaves: innovations, their variances, and, if asked for, everything that
//! sensitivities need.

use super::course::Course;
use super::flow::Flow;
use super::lateral;
use super::layout::Layout;
use super::ride::Ride;
use super::sensitivity::Along;
use super::setup::{Model, Plant, Setup};
use super::speed;
use super::state::Pace;
use std::sync::OnceLock;

/// Innovations in the order of the course's readings.
#[derive(Clone, Debug)]
pub struct Pass {
    pub error: Vec<f64>,
    pub variance: Vec<f64>,
    pub record: Option<Record>,
}

/// A lateral reading as the filter took it.
pub struct Recorded<'a> {
    pub reading: usize,
    pub row: &'a [f64],
    /// Covariance times row: the gain times the variance.
    pub gain: &'a [f64],
    pub variance: f64,
}

/// The linear system along the predictor's path.
#[derive(Clone, Debug, Default)]
pub struct Record {
    pub n: usize,
    pub nd: usize,
    pub slow: usize,
    /// By step: transition, nd by n.
    pub top: Vec<f64>,
    /// By step: responses to roll and steer torque, held and rising, nd each.
    pub held: Vec<f64>,
    pub ramp: Vec<f64>,
    /// By step: mean before and after the step, n each; the readings come after.
    pub x0: Vec<f64>,
    pub x1: Vec<f64>,
    /// By step: mean after the readings.
    pub x2: Vec<f64>,
    pub pace: Vec<Pace>,
    pub phi_speed: Vec<f64>,
    /// By reading: row and gain, n each for lateral ones.
    pub row: Vec<f64>,
    pub gain: Vec<f64>,
    pub slow_row: Vec<f64>,
    pub slow_gain: Vec<f64>,
    /// What the plant of this pass does along the path, once sensitivities have asked for it.
    pub(super) along: OnceLock<Along>,
}

impl Pass {
    fn new(ride: &Ride, course: &Course, model: &Model, recording: bool) -> Self {
        let readings = course.readings.len();
        let record = recording.then(|| {
            let layout = Layout::new(ride, model);
            let (n, nd) = (layout.states, layout.dynamic);
            let slow = 1 + speed::bias_states(ride).iter().flatten().count();
            let steps = course.steps.len();
            Record {
                n,
                nd,
                slow,
                top: Vec::with_capacity(steps * nd * n),
                held: Vec::with_capacity(steps * 2 * nd),
                ramp: Vec::with_capacity(steps * 2 * nd),
                x0: Vec::with_capacity(steps * n),
                x1: Vec::with_capacity(steps * n),
                x2: Vec::with_capacity(steps * n),
                pace: Vec::with_capacity(steps),
                phi_speed: Vec::with_capacity(steps),
                row: vec![0.0; readings * n],
                gain: vec![0.0; readings * n],
                slow_row: vec![0.0; readings * slow],
                slow_gain: vec![0.0; readings * slow],
                along: OnceLock::new(),
            }
        });
        Self {
            error: vec![0.0; readings],
            variance: vec![1.0; readings],
            record,
        }
    }

    /// One that keeps nothing but innovations.
    pub(super) fn empty(course: &Course) -> Self {
        let readings = course.readings.len();
        Self {
            error: vec![0.0; readings],
            variance: vec![1.0; readings],
            record: None,
        }
    }

    /// Runs the predictor over a ride.
    pub fn run(
        ride: &Ride,
        course: &Course,
        setup: &Setup,
        model: &Model,
        recording: bool,
    ) -> Self {
        let mut pass = Self::new(ride, course, model, recording);
        let paces = speed::run(ride, course, setup, model, &mut pass);
        lateral::run(ride, course, setup, model, &paces, &mut pass);
        pass
    }

    pub(super) fn reading(&mut self, index: usize, error: f64, variance: f64) {
        self.error[index] = error;
        self.variance[index] = variance;
    }

    pub(super) fn record_step(
        &mut self,
        top: &[f64],
        flow: &Flow,
        x0: &[f64],
        x1: &[f64],
        n: usize,
    ) {
        if let Some(r) = &mut self.record {
            r.top.extend_from_slice(top);
            for c in 0..2 {
                r.held.extend_from_slice(&flow.held[c]);
                r.ramp.extend_from_slice(&flow.ramp[c]);
            }
            r.x0.extend_from_slice(&x0[..n]);
            r.x1.extend_from_slice(&x1[..n]);
        }
    }

    /// A step of no length: nothing moves (its transition is not used).
    pub(super) fn record_still(&mut self, nd: usize, n: usize) {
        if let Some(r) = &mut self.record {
            r.top.resize(r.top.len() + nd * n, 0.0);
            r.held.resize(r.held.len() + 2 * nd, 0.0);
            r.ramp.resize(r.ramp.len() + 2 * nd, 0.0);
            r.x0.resize(r.x0.len() + n, 0.0);
            r.x1.resize(r.x1.len() + n, 0.0);
        }
    }

    pub(super) fn end_step(&mut self, x: &[f64]) {
        if let Some(r) = &mut self.record {
            r.x2.extend_from_slice(x);
        }
    }

    pub(super) fn record_reading(&mut self, reading: Recorded<'_>) {
        if let Some(r) = &mut self.record {
            let at = reading.reading * r.n;
            r.row[at..at + r.n].copy_from_slice(reading.row);
            for (g, x) in r.gain[at..at + r.n].iter_mut().zip(reading.gain) {
                *g = x / reading.variance;
            }
        }
    }

    pub(super) fn record_slow(&mut self, reading: usize, row: &[f64], gain: &[f64], variance: f64) {
        if let Some(r) = &mut self.record {
            let at = reading * r.slow;
            r.slow_row[at..at + r.slow].copy_from_slice(row);
            for (g, x) in r.slow_gain[at..at + r.slow].iter_mut().zip(gain) {
                *g = x / variance;
            }
        }
    }

    pub(super) fn record_pace(&mut self, phi: f64, pace: &Pace) {
        if let Some(r) = &mut self.record {
            r.phi_speed.push(phi);
            r.pace.push(*pace);
        }
    }

    /// Minus the log likelihood; infinite where something is not finite.
    pub fn minus_log_likelihood(&self) -> f64 {
        let terms = self.error.iter().zip(&self.variance).map(|(e, s)| {
            if *s > 0.0 {
                0.5 * (e * e / s + libm::log(*s))
            } else {
                f64::INFINITY
            }
        });
        let sum: f64 = terms.sum();
        if sum.is_finite() { sum } else { f64::INFINITY }
    }
}

/// A ride with its base course, ready to be predicted by many models.
#[derive(Clone, Debug)]
pub struct Prepared {
    pub ride: Ride,
    pub course: Course,
    base: Setup,
}

impl Prepared {
    pub fn new(ride: Ride, plant: &Plant) -> Self {
        let base = Setup::new(plant, &ride);
        Self {
            course: Course::new(&ride, &base),
            ride,
            base,
        }
    }

    /// Predicts with a model; readings keep their stamps, not always their order.
    pub fn run(&self, plant: &Plant, model: &Model, recording: bool) -> (Pass, Option<Course>) {
        let setup = Setup::new(plant, &self.ride);
        if setup.same_events(&self.base) {
            (
                Pass::run(&self.ride, &self.course, &setup, model, recording),
                None,
            )
        } else {
            let course = Course::new(&self.ride, &setup);
            let pass = Pass::run(&self.ride, &course, &setup, model, recording);
            (pass, Some(course))
        }
    }
}
