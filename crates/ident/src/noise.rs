//! What: noise levels by maximum likelihood.
//!
//! Equation: minus log likelihood = 1/2 sum (e²/s + ln s) over all innovations, as a function of
//! the logarithms of the levels, minimised by scoring: the gradient
//! sum [e e_i/s + s_i (1 - e²/s)/(2 s)] and the information sum [e_i e_j/s + s_i s_j/(2 s²)] from
//! the derivatives of e and s, which are taken by forward differences of the whole filter.
//!
//! Source: Harvey (1989), section 3.4.5 (scoring on the prediction error decomposition).
//!
//! Assumes and ignores: levels are constant and shared by all rides. A wide log-normal prior (a
//! factor of `PRIOR_FACTOR` about the starting value, one standard deviation) keeps a level that the
//! data does not determine in reach.
//!
//! Valid for: rides of some hundred readings a level.
//!
//! Checked by: recovery of known levels from simulated rides (`tests`).

use crate::dense::solve_spd;
use crate::filter::{Filter, Levels, Listener};
use crate::ride::Ride;
use crate::track::{PROCESS_SOURCES, Track};

const PRIOR_FACTOR: f64 = 30.0;
const DIFFERENCE: f64 = 1e-4;
const MAX_ROUNDS: usize = 60;
/// Levels have settled when the next step would change their logarithms by less than this, or gain
/// less than `GAIN_TOLERANCE` in log likelihood.
const STEP_TOLERANCE: f64 = 1e-3;
const GAIN_TOLERANCE: f64 = 1e-2;
/// Or when so many rounds in a row have gained less than that.
const STILL_ROUNDS: usize = 3;
const LONGEST_LOG_STEP: f64 = 1.5;

/// Where a level may lie.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    pub start: f64,
    pub least: f64,
    pub most: f64,
}

/// Default range of the process noise: from far below a draught to far beyond any rider.
pub const PROCESS_RANGE: Range = Range {
    start: 1.0,
    least: 1e-4,
    most: 1e3,
};

/// The estimate.
#[derive(Clone, Debug, PartialEq)]
pub struct NoiseEstimate {
    /// Roll and steer torque, Nm √s, then the free sensors.
    pub levels: Vec<f64>,
    /// Standard error of each level's logarithm.
    pub log_standard_error: Vec<f64>,
    /// Whether a level stands at the end of its range.
    pub at_limit: Vec<bool>,
    pub minus_log_likelihood: f64,
    /// Mean of e²/s over all innovations: near one for a consistent predictor.
    pub consistency: f64,
    pub converged: bool,
}

/// Why levels cannot be estimated.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum NoiseError {
    #[error("the predictor's likelihood is not finite at its starting noise levels")]
    NotFinite,
    #[error("no readings")]
    NoReadings,
}

#[derive(Default)]
struct Innovations {
    error: Vec<f64>,
    variance: Vec<f64>,
}

impl Listener for Innovations {
    fn innovation(&mut self, _reading: usize, error: f64, variance: f64) {
        self.error.push(error);
        self.variance.push(variance);
    }
}

impl Innovations {
    fn of(rides: &[Ride], tracks: &[Track], log_levels: &[f64]) -> Self {
        let levels: Vec<f64> = log_levels.iter().map(|x| libm::exp(*x)).collect();
        let mut all = Self::default();
        for (ride, track) in rides.iter().zip(tracks) {
            Filter::new(track, &Levels::new(ride, &levels)).run(&mut all);
        }
        all
    }

    fn minus_log_likelihood(&self) -> f64 {
        let pairs = self.error.iter().zip(&self.variance);
        pairs
            .map(|(e, s)| {
                if *s > 0.0 {
                    0.5 * (e * e / s + libm::log(*s))
                } else {
                    f64::INFINITY
                }
            })
            .sum()
    }
}

/// Estimates the levels; `ranges` holds the two process sources first, then each free sensor.
pub fn estimate(
    rides: &[Ride],
    tracks: &[Track],
    ranges: &[Range],
    mut progress: impl FnMut(usize),
) -> Result<NoiseEstimate, NoiseError> {
    assert!(
        ranges.len() >= PROCESS_SOURCES,
        "two process sources come first"
    );
    let count = ranges.len();
    let start: Vec<f64> = ranges.iter().map(|r| libm::log(r.start)).collect();
    let clamp = |i: usize, x: f64| x.clamp(libm::log(ranges[i].least), libm::log(ranges[i].most));
    let precision = 1.0 / (libm::log(PRIOR_FACTOR) * libm::log(PRIOR_FACTOR));
    let prior = |x: &[f64]| -> f64 {
        x.iter()
            .zip(&start)
            .map(|(x, m)| 0.5 * precision * (x - m) * (x - m))
            .sum()
    };
    let mut x = start.clone();
    let mut now = Innovations::of(rides, tracks, &x);
    if now.error.is_empty() {
        return Err(NoiseError::NoReadings);
    }
    let mut value = now.minus_log_likelihood() + prior(&x);
    if !value.is_finite() {
        return Err(NoiseError::NotFinite);
    }
    let mut damping = 1e-3;
    let mut converged = false;
    let mut still = 0;
    let mut information = vec![0.0; count * count];
    for round in 0..MAX_ROUNDS {
        progress(round);
        let (gradient, fresh) = derivatives(rides, tracks, &x, &now);
        information = fresh;
        let mut gradient = gradient;
        for i in 0..count {
            gradient[i] += precision * (x[i] - start[i]);
            information[i * count + i] += precision;
        }
        // A level at its limit that wants to go on is held there.
        let held: Vec<bool> = (0..count)
            .map(|i| x[i] == clamp(i, x[i] - gradient[i].signum()) && gradient[i] != 0.0)
            .collect();
        let mut moved = 0.0f64;
        let before = value;
        let mut accepted = false;
        while damping < 1e8 {
            let mut system = information.clone();
            let mut right: Vec<f64> = gradient.iter().map(|g| -g).collect();
            for i in 0..count {
                system[i * count + i] *= 1.0 + damping;
                if held[i] {
                    for j in 0..count {
                        system[i * count + j] = 0.0;
                        system[j * count + i] = 0.0;
                    }
                    system[i * count + i] = 1.0;
                    right[i] = 0.0;
                }
            }
            let Some(step) = solve_spd(&system, &right) else {
                damping *= 10.0;
                continue;
            };
            let trial: Vec<f64> = (0..count)
                .map(|i| clamp(i, x[i] + step[i].clamp(-LONGEST_LOG_STEP, LONGEST_LOG_STEP)))
                .collect();
            moved = trial
                .iter()
                .zip(&x)
                .map(|(a, b)| (a - b).abs())
                .fold(0.0, f64::max);
            let gain: f64 = 0.5 * step.iter().zip(&right).map(|(d, g)| d * g).sum::<f64>();
            if gain < GAIN_TOLERANCE && damping <= 1e-2 {
                moved = 0.0;
                break;
            }
            let next = Innovations::of(rides, tracks, &trial);
            let next_value = next.minus_log_likelihood() + prior(&trial);
            if next_value <= value {
                (x, now, value) = (trial, next, next_value);
                damping = (damping * 0.1).max(1e-6);
                accepted = true;
                break;
            }
            if moved < STEP_TOLERANCE {
                break;
            }
            damping *= 10.0;
        }
        still = if before - value < GAIN_TOLERANCE {
            still + 1
        } else {
            0
        };
        if moved < STEP_TOLERANCE || !accepted || still == STILL_ROUNDS {
            converged = accepted || moved < STEP_TOLERANCE;
            break;
        }
    }
    let log_standard_error = (0..count).map(|i| {
        let unit: Vec<f64> = (0..count).map(|j| if i == j { 1.0 } else { 0.0 }).collect();
        solve_spd(&information, &unit).map_or(f64::INFINITY, |column| column[i].max(0.0).sqrt())
    });
    let consistency = now
        .error
        .iter()
        .zip(&now.variance)
        .map(|(e, s)| e * e / s)
        .sum::<f64>()
        / now.error.len() as f64;
    Ok(NoiseEstimate {
        log_standard_error: log_standard_error.collect(),
        at_limit: (0..count)
            .map(|i| x[i] == clamp(i, x[i] - 1e-9) || x[i] == clamp(i, x[i] + 1e-9))
            .collect(),
        levels: x.iter().map(|x| libm::exp(*x)).collect(),
        minus_log_likelihood: now.minus_log_likelihood(),
        consistency,
        converged,
    })
}

/// Gradient and information of the minus log likelihood.
fn derivatives(
    rides: &[Ride],
    tracks: &[Track],
    x: &[f64],
    now: &Innovations,
) -> (Vec<f64>, Vec<f64>) {
    let count = x.len();
    let slopes: Vec<Innovations> = (0..count)
        .map(|i| {
            let mut moved = x.to_vec();
            moved[i] += DIFFERENCE;
            let mut there = Innovations::of(rides, tracks, &moved);
            for (a, b) in there.error.iter_mut().zip(&now.error) {
                *a = (*a - b) / DIFFERENCE;
            }
            for (a, b) in there.variance.iter_mut().zip(&now.variance) {
                *a = (*a - b) / DIFFERENCE;
            }
            there
        })
        .collect();
    let mut gradient = vec![0.0; count];
    let mut information = vec![0.0; count * count];
    for (k, (e, s)) in now.error.iter().zip(&now.variance).enumerate() {
        for i in 0..count {
            let (de, ds) = (slopes[i].error[k], slopes[i].variance[k] / s);
            gradient[i] += e * de / s + 0.5 * ds * (1.0 - e * e / s);
            for j in 0..=i {
                let (fe, fs) = (slopes[j].error[k], slopes[j].variance[k] / s);
                information[i * count + j] += de * fe / s + 0.5 * ds * fs;
            }
        }
    }
    for i in 0..count {
        for j in 0..i {
            information[j * count + i] = information[i * count + j];
        }
    }
    (gradient, information)
}
