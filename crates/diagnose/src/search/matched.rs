//! What: how much of a torque of a given course in time the innovations hold.
//!
//! Equation: for a torque cos or sin of a phase in one equation, g is the change of the whitened
//! innovations; |g'e|²/(g'g) is exponential with mean 1 where only noise acts. Summed over rides,
//! both phases: chi² with two degrees for each ride.
//!
//! Source: matched filter; the linear system along the predictor's path as in
//! `engine::sensitivity`.
//!
//! Assumes and ignores: noise levels fitted on the same rides take up part of what is coloured.
//!
//! Valid for: turns from one in a window to half the sampling rate.
//!
//! Checked by: `tests` of the search: the band of a hidden torque, the order of a wheel.

use super::rides::Rides;
use crate::engine::course::Course;
use crate::engine::pass::Record;
use crate::engine::small::dot;
use crate::engine::{Model, Pass, Ride};

/// One model's innovations over one ride, ready to be matched.
pub struct Filtered<'a> {
    pub ride: &'a Ride,
    pub white: Vec<f64>,
    pass: Pass,
    moved: Option<Course>,
    still: &'a Course,
}

impl<'a> Filtered<'a> {
    /// Of all rides; none if the model cannot be.
    pub fn all(rides: &'a Rides, model: &Model) -> Option<Vec<Self>> {
        let plant = model.plant().ok()?;
        Some(
            rides
                .0
                .iter()
                .map(|prepared| {
                    let (pass, moved) = prepared.run(&plant, model, true);
                    let terms = pass.error.iter().zip(&pass.variance);
                    Self {
                        ride: &prepared.ride,
                        white: terms.map(|(e, s)| e / s.sqrt()).collect(),
                        moved,
                        still: &prepared.course,
                        pass,
                    }
                })
                .collect(),
        )
    }

    /// With moved events the record belongs to another course.
    pub fn course(&self) -> &Course {
        self.moved.as_ref().unwrap_or(self.still)
    }

    /// Power of the torque cos(phase) and its quarter turn on one axis, 2 where only noise acts.
    pub fn power(&self, axis: usize, phase_rad: impl Fn(f64) -> f64) -> f64 {
        let Some(record) = &self.pass.record else {
            return 0.0;
        };
        [0.0, 0.5 * std::f64::consts::PI]
            .into_iter()
            .map(|quarter| {
                let torque = |t: f64| libm::cos(phase_rad(t) - quarter);
                let g = response(self.ride, self.course(), &self.pass, record, axis, torque);
                let (gg, ge) = (dot(&g, &g), dot(&g, &self.white));
                if gg > 0.0 { ge * ge / gg } else { 0.0 }
            })
            .sum()
    }
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
