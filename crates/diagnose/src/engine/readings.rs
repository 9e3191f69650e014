//! Readings at the end of a step, one after the other.

use super::course::Course;
use super::lateral::Work;
use super::layout::HEADING;
use super::pass::{Pass, Recorded};
use super::small::{dot, sparse_mul};
use super::state::{self, Balance, Pace};
use crate::quantity::Quantity;
use nalgebra::Vector2;

impl Work<'_> {
    /// Takes the readings at the end of a step.
    pub(super) fn read(
        &mut self,
        course: &Course,
        index: usize,
        pace: &Pace,
        slip: f64,
        pass: &mut Pass,
    ) {
        let step = &course.steps[index];
        let mut drawn = false;
        let mut balance = None;
        for r in step.readings.clone() {
            let reading = &course.readings[r];
            let sensor = &self.ride.sensors[reading.sensor];
            if sensor.is_longitudinal() {
                continue;
            }
            let n = self.layout.states;
            if step.dt_s == 0.0 && !drawn {
                // A is needed by accelerometers only.
                let b = Balance::new(self.setup, course.met(index), pace);
                self.fill_a(&b, None, pace);
                drawn = true;
            }
            let mut row = std::mem::take(&mut self.row);
            let predicted = match self.layout.filters[reading.sensor] {
                Some(first) => {
                    let last = if sensor.moving_average_s > 0.0 {
                        first + usize::from(sensor.lag_s > 0.0)
                    } else {
                        first
                    };
                    row.fill(0.0);
                    row[last] = 1.0;
                    self.x[last]
                }
                None => {
                    self.truth_row(reading.sensor, pace, &mut row);
                    let b = *balance
                        .get_or_insert_with(|| Balance::new(self.setup, course.met(index), pace));
                    let accel = if sensor.quantity == Quantity::LateralAccel {
                        self.accel(&b, &self.x)
                    } else {
                        Vector2::zeros()
                    };
                    let at = state::moment(
                        self.setup,
                        self.ride,
                        course.met(index),
                        pace,
                        &self.x,
                        accel,
                        step.t_s,
                        step.dt_s,
                    );
                    let heading = if self.layout.heading {
                        self.x[HEADING]
                    } else {
                        0.0
                    };
                    let model = &self.setup.sensors[reading.sensor];
                    state::reading(self.setup, sensor, model, &at, heading, slip)
                }
            };
            let mut predicted = predicted;
            if let Some(bias) = self.layout.sensor_bias[reading.sensor] {
                row[bias] = 1.0;
                predicted += self.x[bias];
            }
            if self.blind {
                self.said.push((r, predicted));
                self.row = row;
                continue;
            }
            sparse_mul(&mut self.gain, &row, &self.p, n);
            let sd = self.model.noise_sd(sensor);
            let quantum = sensor
                .quantum
                .max(self.setup.sensors[reading.sensor].quantum);
            let mut noise = sd * sd + quantum * quantum / 12.0;
            if self.ride.clock_jitter_sd_s > 0.0 && step.dt_s > 0.0 {
                let moved: f64 = row
                    .iter()
                    .zip(self.x.iter().zip(&self.before))
                    .map(|(c, (now, then))| c * (now - then))
                    .sum();
                let error = moved / step.dt_s * self.ride.clock_jitter_sd_s;
                noise += error * error;
            }
            let variance = dot(&row, &self.gain) + noise;
            let error = reading.value - predicted;
            let scaled = error / variance;
            let inverse = 1.0 / variance;
            for (i, gain) in self.gain.iter().enumerate() {
                self.x[i] += gain * scaled;
                for (value, other) in self.p[i * n..(i + 1) * n].iter_mut().zip(&self.gain) {
                    // In this order both halves of the matrix round alike.
                    *value -= gain * other * inverse;
                }
            }
            pass.reading(r, error, variance);
            pass.record_reading(Recorded {
                reading: r,
                row: &row,
                gain: &self.gain,
                variance,
            });
            self.row = row;
        }
    }
}
