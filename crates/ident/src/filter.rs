//! What: the predictor, a Kalman filter over the steps of a track, and its free run.
//!
//! Equation: x- = Phi x + d, P- = Phi P Phi' + Q; for each reading in turn e = y - C x- - D u,
//! s = C P- C' + r, x = x- + P- C' e/s, P = P- - P- C' C P-/s.
//!
//! Source: A. C. Harvey, "Forecasting, structural time series models and the Kalman filter" (1989),
//! chapter 3 (innovations, prediction error decomposition, univariate treatment).
//!
//! Assumes and ignores: white noise, readings independent of each other. A law beyond its limit or
//! with a delay acts as a torque computed from the estimate and held over the step; its effect on
//! the covariance is left out then.
//!
//! Valid for: readings in the order of time; missing ones are simply not there.
//!
//! Checked by: consistency of the innovations on simulated rides, and causality (`tests`).

use crate::dense::{dot, mul_vec};
use crate::ride::{NoiseLevel, Ride};
use crate::track::{OpenStep, PROCESS_SOURCES, Step, Stretch, Track};

/// Standard deviations of all noises of one ride.
#[derive(Clone, Debug, PartialEq)]
pub struct Levels {
    /// White roll and steer torque, Nm √s.
    pub process_nm_sqrt_s: [f64; PROCESS_SOURCES],
    /// White noise of each sensor, in its unit.
    pub sensor: Vec<f64>,
}

impl Levels {
    /// From the estimates: the process sources first, then the free sensors by their index.
    pub fn new(ride: &Ride, estimates: &[f64]) -> Self {
        let sensor = ride.sensors.iter().map(|s| match s.noise {
            NoiseLevel::Known(sd) => sd,
            NoiseLevel::Free(index) => estimates[PROCESS_SOURCES + index],
        });
        Self {
            process_nm_sqrt_s: std::array::from_fn(|i| estimates[i]),
            sensor: sensor.collect(),
        }
    }
}

/// The state's estimate, and what delayed laws must remember.
#[derive(Clone, Debug)]
pub struct Estimate {
    /// Mean: roll, steer, roll rate, steer rate, then heading, filters and biases.
    pub x: Vec<f64>,
    /// Covariance, row-major.
    pub p: Vec<f64>,
    /// Time and torque that each law asked for.
    history: Vec<Vec<(f64, f64)>>,
    t_s: f64,
}

/// Hears what the filter meets.
pub trait Listener {
    /// A reading, its innovation and the innovation's variance.
    fn innovation(&mut self, reading: usize, error: f64, variance: f64);
    /// The estimate after all readings of a step.
    fn step(&mut self, _step: usize, _estimate: &Estimate) {}
}

/// The filter over one track.
pub struct Filter<'a> {
    track: &'a Track,
    levels: &'a Levels,
    estimate: Estimate,
    scratch: Vec<f64>,
    gain: Vec<f64>,
    /// Mean at the start of the last step, and its length: for the jitter of the clock.
    before: Vec<f64>,
    passed_s: f64,
}

impl<'a> Filter<'a> {
    pub fn new(track: &'a Track, levels: &'a Levels) -> Self {
        let n = track.layout.states;
        let mut p = vec![0.0; n * n];
        for (i, variance) in track.prior_variance.iter().enumerate() {
            p[i * n + i] = *variance;
        }
        let estimate = Estimate {
            x: vec![0.0; n],
            p,
            history: vec![],
            t_s: 0.0,
        };
        Self {
            track,
            levels,
            estimate,
            scratch: vec![0.0; n * n],
            gain: vec![0.0; n],
            before: vec![0.0; n],
            passed_s: 0.0,
        }
    }

    /// Goes through all windows.
    pub fn run(mut self, listener: &mut impl Listener) {
        for stretch in &self.track.stretches {
            self.restart(stretch);
            for index in stretch.steps.clone() {
                self.advance(&self.track.steps[index]);
                for reading in self.track.steps[index].readings.clone() {
                    self.read(reading, listener);
                }
                listener.step(index, &self.estimate);
            }
        }
    }

    /// A window has a free initial state; the biases are the ride's and stay known.
    fn restart(&mut self, stretch: &Stretch) {
        let (n, nd) = (self.track.layout.states, self.track.layout.dynamic);
        let Estimate { x, p, history, t_s } = &mut self.estimate;
        x[..nd].fill(0.0);
        for i in 0..nd {
            for j in 0..n {
                p[i * n + j] = 0.0;
                p[j * n + i] = 0.0;
            }
            p[i * n + i] = self.track.prior_variance[i];
        }
        let first = &self.track.steps[stretch.steps.start];
        *t_s = first.t_s;
        *history = vec![vec![]; first.open.as_ref().map_or(0, |o| o.laws.len())];
    }

    fn advance(&mut self, step: &Step) {
        let (n, nd) = (self.track.layout.states, self.track.layout.dynamic);
        self.before.copy_from_slice(&self.estimate.x);
        self.passed_s = step.dt_s;
        let phi = self.estimate.advance(step, nd);
        if step.dt_s == 0.0 {
            return;
        }
        let p = &mut self.estimate.p;
        // W = Phi P (dynamic rows), then P_dd = W Phi', P_db = W_b.
        let w = &mut self.scratch[..nd * n];
        crate::dense::mul(w, phi, p, nd, n, n);
        for i in 0..nd {
            for j in 0..=i {
                let mut sum = dot(&w[i * n..(i + 1) * n], &phi[j * n..(j + 1) * n]);
                for (q, level) in step.noise.iter().zip(self.levels.process_nm_sqrt_s) {
                    sum += level * level * q[i * nd + j];
                }
                if let Some(known) = &step.known_noise {
                    sum += known[i * nd + j];
                }
                p[i * n + j] = sum;
                p[j * n + i] = sum;
            }
            for j in nd..n {
                p[i * n + j] = w[i * n + j];
                p[j * n + i] = w[i * n + j];
            }
        }
    }

    fn read(&mut self, index: usize, listener: &mut impl Listener) {
        let n = self.track.layout.states;
        let reading = &self.track.readings[index];
        let Estimate { x, p, .. } = &mut self.estimate;
        mul_vec(&mut self.gain, p, &reading.row);
        let sd = self.levels.sensor[reading.sensor];
        let mut noise = sd * sd + self.track.quantum_variance[reading.sensor];
        if self.track.clock_jitter_sd_s > 0.0 && self.passed_s > 0.0 {
            // The reading moves by its rate times the error of its time stamp.
            let moved: f64 = reading
                .row
                .iter()
                .zip(x.iter().zip(&self.before))
                .map(|(c, (now, then))| c * (now - then))
                .sum();
            let error = moved / self.passed_s * self.track.clock_jitter_sd_s;
            noise += error * error;
        }
        let variance = dot(&reading.row, &self.gain) + noise;
        let error = reading.value - reading.feed - dot(&reading.row, x);
        listener.innovation(index, error, variance);
        let scaled = error / variance;
        for i in 0..n {
            x[i] += self.gain[i] * scaled;
            for j in 0..=i {
                let value = p[i * n + j] - self.gain[i] * self.gain[j] / variance;
                p[i * n + j] = value;
                p[j * n + i] = value;
            }
        }
    }
}

impl Estimate {
    /// Moves the mean over a step and gives the transition that applied to it.
    fn advance<'s>(&mut self, step: &'s Step, dynamic: usize) -> &'s [f64] {
        let started_s = self.t_s;
        self.t_s = step.t_s;
        if step.dt_s == 0.0 {
            return &step.phi;
        }
        let mut next = vec![0.0; dynamic];
        let phi = match &step.open {
            Some(open) if self.needs_open(open) => {
                mul_vec(&mut next, &open.phi, &self.x);
                for (index, law) in open.laws.iter().enumerate() {
                    let torque =
                        self.law_torque(index, open, started_s, started_s + 0.5 * step.dt_s);
                    for (x, push) in next.iter_mut().zip(&law.push) {
                        *x += torque * push;
                    }
                }
                for (x, d) in next.iter_mut().zip(&open.drive) {
                    *x += d;
                }
                &open.phi
            }
            _ => {
                mul_vec(&mut next, &step.phi, &self.x);
                for (x, d) in next.iter_mut().zip(&step.drive) {
                    *x += d;
                }
                &step.phi
            }
        };
        self.x[..dynamic].copy_from_slice(&next);
        phi
    }

    /// Whether a law is delayed or beyond its limit now.
    fn needs_open(&self, open: &OpenStep) -> bool {
        open.laws
            .iter()
            .any(|law| law.delay_s > 0.0 || dot(&law.row, &self.x).abs() > law.limit_nm)
    }

    /// Torque of a law over the step from `now_s`, `middle_s` being its middle.
    fn law_torque(&mut self, index: usize, open: &OpenStep, now_s: f64, middle_s: f64) -> f64 {
        let law = &open.laws[index];
        let wanted = dot(&law.row, &self.x);
        let asked = if law.delay_s == 0.0 {
            wanted
        } else {
            let history = &mut self.history[index];
            history.push((now_s, wanted));
            let then = middle_s - law.delay_s;
            let next = history.partition_point(|h| h.0 <= then);
            // Nothing older is needed again.
            history.drain(..next.saturating_sub(2));
            let next = history.partition_point(|h| h.0 <= then);
            match (next.checked_sub(1).map(|i| history[i]), history.get(next)) {
                (Some((t0, y0)), Some(&(t1, y1))) => y0 + (y1 - y0) * (then - t0) / (t1 - t0),
                (Some((_, y)), None) => y,
                // Before the window: the oldest that is known.
                (None, Some(&(_, y))) => y,
                (None, None) => wanted,
            }
        };
        asked.clamp(-law.limit_nm, law.limit_nm)
    }

    /// Runs free over the steps, without reading: calls `visit` with each reading met and what the
    /// model says it should be.
    pub fn free_run(
        &self,
        track: &Track,
        steps: std::ops::Range<usize>,
        mut visit: impl FnMut(usize, f64),
    ) {
        let mut state = self.clone();
        for step in &track.steps[steps] {
            state.advance(step, track.layout.dynamic);
            for index in step.readings.clone() {
                let reading = &track.readings[index];
                visit(index, reading.feed + dot(&reading.row, &state.x));
            }
        }
    }
}
