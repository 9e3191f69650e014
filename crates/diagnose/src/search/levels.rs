//! What: noise levels of the predictor on the fit rides.
//!
//! Equation: scoring on the likelihood of the innovations, in the logarithms of the levels.
//!
//! Source: A. C. Harvey, Forecasting, structural time series models and the Kalman filter (1989),
//! section 3.4.5.
//!
//! Assumes and ignores: levels shared by all rides.
//!
//! Valid for: some hundred readings a level.
//!
//! Checked by: `tests` of the search on simulated rides.

use super::rides::{Passes, Rides};
use crate::engine::small::solve;
use crate::engine::{FreeNoise, Model, Pass};

/// First guess of the random torques and force that act on a bicycle: a good road and a steady rider.
pub const FIRST_PROCESS: [f64; 3] = [1.0, 0.2, 2.0];

/// First guess of the model.
pub fn start(bicycle: &twinhub_linear::Bicycle, free: &FreeNoise) -> Model {
    Model {
        bicycle: bicycle.clone(),
        active: vec![],
        levels: crate::engine::Levels {
            process: FIRST_PROCESS,
            sensors: free.range.iter().map(|r| r[0]).collect(),
        },
        latent: [None; 2],
    }
}

/// Re-estimates the noise levels, `rounds` scoring steps at most.
pub fn fit_levels(rides: &Rides, free: &FreeNoise, model: &Model, rounds: usize) -> Model {
    const DIFFERENCE: f64 = 1e-3;
    const PRIOR: f64 = 1.0 / (3.4 * 3.4);
    let longitudinal = rides.0.iter().any(|r| r.ride.speed.is_none());
    let mut model = model.clone();
    let count = 3 + free.range.len();
    let get = |m: &Model| -> Vec<f64> {
        m.levels
            .process
            .iter()
            .chain(&m.levels.sensors)
            .map(|x| libm::log(*x))
            .collect()
    };
    let set = |m: &Model, x: &[f64]| -> Model {
        let mut m = m.clone();
        for i in 0..count {
            let (least, most) = match i {
                0..3 => (1e-4, 1e3),
                _ => (free.range[i - 3][1], free.range[i - 3][2]),
            };
            let value = libm::exp(x[i]).clamp(least, most);
            if i < 3 {
                m.levels.process[i] = value;
            } else {
                m.levels.sensors[i - 3] = value;
            }
        }
        m
    };
    let used: Vec<usize> = (0..count).filter(|i| *i != 2 || longitudinal).collect();
    let origin = get(&model);
    let prior = |x: &[f64]| -> f64 {
        x.iter()
            .zip(&origin)
            .map(|(a, b)| 0.5 * PRIOR * (a - b) * (a - b))
            .sum()
    };
    let Some(mut now) = Passes::run(rides, &model, false) else {
        return model;
    };
    let mut value = now.minus_log_likelihood();
    for _ in 0..rounds {
        let x = get(&model);
        let slopes: Vec<Option<Passes>> = used
            .iter()
            .map(|i| {
                let mut there = x.clone();
                there[*i] += DIFFERENCE;
                Passes::run(rides, &set(&model, &there), false)
            })
            .collect();
        let m = used.len();
        let mut gradient = vec![0.0; m];
        let mut information = vec![0.0; m * m];
        for (ride, pass) in now.passes.iter().enumerate() {
            let there: Vec<&Pass> = slopes
                .iter()
                .map(|s| s.as_ref().map_or(pass, |s| &s.passes[ride]))
                .collect();
            let mut de = vec![0.0; m];
            let mut ds = vec![0.0; m];
            for (k, (e, s)) in pass.error.iter().zip(&pass.variance).enumerate() {
                for i in 0..m {
                    de[i] = (there[i].error[k] - e) / DIFFERENCE;
                    ds[i] = (there[i].variance[k] - s) / (DIFFERENCE * s);
                }
                for i in 0..m {
                    gradient[i] += e * de[i] / s + 0.5 * ds[i] * (1.0 - e * e / s);
                    for j in 0..=i {
                        information[i * m + j] += de[i] * de[j] / s + 0.5 * ds[i] * ds[j];
                    }
                }
            }
        }
        for i in 0..m {
            gradient[i] += PRIOR * (x[used[i]] - origin[used[i]]);
            information[i * m + i] += PRIOR;
            for j in 0..i {
                information[j * m + i] = information[i * m + j];
            }
        }
        let right: Vec<f64> = gradient.iter().map(|g| -g).collect();
        let Some(step) = solve(&information, &[right]) else {
            break;
        };
        let before = value + prior(&x);
        let mut share = 1.0;
        let mut better = false;
        while share > 0.05 {
            let mut there = x.clone();
            for (i, k) in used.iter().enumerate() {
                there[*k] += (share * step[0][i]).clamp(-1.5, 1.5);
            }
            let trial = set(&model, &there);
            if let Some(passes) = Passes::run(rides, &trial, false) {
                let cost = passes.minus_log_likelihood();
                if cost + prior(&get(&trial)) < before {
                    (model, now, value) = (trial, passes, cost);
                    better = true;
                    break;
                }
            }
            share *= 0.3;
        }
        if !better || before - value - prior(&get(&model)) < 0.5 {
            break;
        }
    }
    model
}
