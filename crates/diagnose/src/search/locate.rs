//! What: in which band the residual of an equation lies.
//!
//! Equation: for a torque cos or sin of a frequency in one equation, g is the change of the whitened
//! innovations; |g'e|²/(g'g) is exponential with mean 1 where only noise acts. Summed over rides,
//! both phases: chi² with two degrees for each ride.
//!
//! Source: matched filter; the linear system along the predictor's path as in
//! `engine::sensitivity`.
//!
//! Assumes and ignores: noise levels fitted on the same rides take up part of what is coloured.
//!
//! Valid for: frequencies from one in a window to half the sampling rate.
//!
//! Checked by: `tests` of the search: the band of a hidden torque.

use super::answer::{Answer, Verdict};
use super::greedy::Found;
use super::pictures::Spectrum;
use super::rides::Rides;
use super::thresholds::THRESHOLDS;
use crate::engine::course::Course;
use crate::engine::pass::Record;
use crate::engine::small::dot;
use crate::engine::{Model, Pass, Ride};
use statrs::distribution::{ChiSquared, ContinuousCDF};

/// Frequencies from 0.1 to 8 Hz, four a factor of two.
fn frequencies() -> Vec<f64> {
    (0..=25)
        .map(|k| 0.1 * libm::pow(2.0, f64::from(k) / 4.0))
        .collect()
}

/// Response of the whitened innovations of one ride to a torque on one axis.
fn response(
    ride: &Ride,
    course: &Course,
    pass: &Pass,
    record: &Record,
    axis: usize,
    torque: impl Fn(f64) -> f64,
) -> Vec<f64> {
    let (n, nd) = (record.n, record.nd);
    let mut out = vec![0.0; course.readings.len()];
    let mut dx = vec![0.0; n];
    let mut next = vec![0.0; nd];
    for (index, step) in course.steps.iter().enumerate() {
        if step.fresh {
            dx[..nd].fill(0.0);
        }
        if step.dt_s > 0.0 {
            let (t0, t1) = (torque(step.t_s - step.dt_s), torque(step.t_s));
            let top = &record.top[index * nd * n..(index + 1) * nd * n];
            let held = &record.held[(index * 2 + axis) * nd..];
            let ramp = &record.ramp[(index * 2 + axis) * nd..];
            for i in 0..nd {
                next[i] = dot(&top[i * n..(i + 1) * n], &dx) + held[i] * t0 + ramp[i] * (t1 - t0);
            }
            dx[..nd].copy_from_slice(&next);
        }
        for r in step.readings.clone() {
            if ride.sensors[course.readings[r].sensor].is_longitudinal() {
                continue;
            }
            let row = &record.row[r * n..(r + 1) * n];
            let gain = &record.gain[r * n..(r + 1) * n];
            let de = -dot(row, &dx);
            out[r] = de / pass.variance[r].sqrt();
            for (x, k) in dx.iter_mut().zip(gain) {
                *x += k * de;
            }
        }
    }
    out
}

/// Power by frequency in one equation: mean over rides and phases, 1 where only noise acts.
fn spectrum(rides: &Rides, model: &Model, axis: usize, grid: &[f64]) -> Option<Vec<f64>> {
    let plant = model.plant().ok()?;
    let mut power = vec![0.0; grid.len()];
    for prepared in &rides.0 {
        let (pass, moved) = prepared.run(&plant, model, true);
        // With moved events the record belongs to another course.
        let course = moved.as_ref().unwrap_or(&prepared.course);
        let record = pass.record.as_ref()?;
        let white: Vec<f64> = pass
            .error
            .iter()
            .zip(&pass.variance)
            .map(|(e, s)| e / s.sqrt())
            .collect();
        for (f, sum) in grid.iter().zip(&mut power) {
            let omega = 2.0 * std::f64::consts::PI * f;
            for phase in [0.0, 0.5 * std::f64::consts::PI] {
                let g = response(&prepared.ride, course, &pass, record, axis, |t| {
                    libm::cos(omega * t - phase)
                });
                let (gg, ge) = (dot(&g, &g), dot(&g, &white));
                if gg > 0.0 {
                    *sum += 0.5 * ge * ge / gg / rides.0.len() as f64 * 2.0;
                }
            }
        }
    }
    Some(power.iter().map(|p| 0.5 * p).collect())
}

/// Bands for the places of the answer, and the pictures.
pub fn fill(answer: &mut Answer, fit: &Rides, before: &Model, found: &Found) {
    let grid = frequencies();
    let count = 2.0 * fit.0.len() as f64;
    let Ok(null) = ChiSquared::new(count) else {
        return;
    };
    let limit = null.inverse_cdf(0.99) / count;
    for (axis, equation) in [(0, "roll"), (1, "steer")] {
        let Some(first) = spectrum(fit, before, axis, &grid) else {
            continue;
        };
        let after = if answer.causes.is_empty() {
            first.clone()
        } else {
            spectrum(fit, &found.baseline.model, axis, &grid).unwrap_or_else(|| first.clone())
        };
        let seen = if answer.verdict == Verdict::Unknown {
            &after
        } else {
            &first
        };
        let (peak, power) =
            seen.iter().copied().enumerate().fold(
                (0, 0.0),
                |best, (k, p)| if p > best.1 { (k, p) } else { best },
            );
        let p_value = null.sf(power * count) * grid.len() as f64;
        let strong = |k: usize| seen[k] > limit.max(0.3 * power);
        let mut low = peak;
        while low > 0 && strong(low - 1) {
            low -= 1;
        }
        let mut high = peak;
        while high + 1 < grid.len() && strong(high + 1) {
            high += 1;
        }
        for place in answer.places.iter_mut().filter(|p| p.equation == equation) {
            if p_value < THRESHOLDS.band_p_value {
                place.band_hz = Some([
                    grid[low] / libm::pow(2.0, 1.0 / 8.0),
                    grid[high] * libm::pow(2.0, 1.0 / 8.0),
                ]);
            }
        }
        answer.pictures.spectra.push(Spectrum {
            equation: equation.to_owned(),
            limit: vec![limit; grid.len()],
            frequency_hz: grid.clone(),
            before: first,
            after,
        });
    }
}
