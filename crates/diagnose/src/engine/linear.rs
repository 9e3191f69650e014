//! The linear system of one step: what the predictor's covariance and gain follow from.

use super::lateral::{Slope, Work};
use super::layout::HEADING;
use super::state::{self, Balance, Pace, Which};
use crate::quantity::Quantity;
use nalgebra::{Matrix2, Vector2};
use twinhub_mechanism::Moment;

impl Work<'_> {
    /// Central differences over one standard deviation.
    pub(super) fn slope(&self, at: &Moment<'_>, balance: &Balance) -> Slope {
        let n = self.layout.states;
        let mut slope = [[0.0; 4]; 2];
        let mut x: [f64; 4] = std::array::from_fn(|i| self.x[i]);
        for i in 0..4 {
            let h = self.p[i * n + i].max(0.0).sqrt().clamp(1e-5, 0.5);
            let mut side = |sign: f64| {
                let kept = x[i];
                x[i] = kept + sign * h;
                let mut moved = *at;
                moved.angle_rad = [x[0], x[1]];
                moved.rate_rad_s = [x[2], x[3]];
                let accel = self.setup.plant.body.mass_inverse * balance.net(&x);
                moved.accel_rad_s2 = [accel.x, accel.y];
                x[i] = kept;
                state::wrench(self.setup, self.ride, &moved, &self.memory, Which::Feedback)
            };
            let (up, down) = (side(1.0), side(-1.0));
            slope[0][i] = (up.roll_nm - down.roll_nm) / (2.0 * h);
            slope[1][i] = (up.steer_nm - down.steer_nm) / (2.0 * h);
        }
        slope
    }

    /// A of the dynamic states.
    pub(super) fn fill_a(&mut self, balance: &Balance, slope: Option<&Slope>, pace: &Pace) {
        let nd = self.layout.dynamic;
        let (setup, a) = (self.setup, &mut self.a);
        a.fill(0.0);
        a[2] = 1.0;
        a[nd + 3] = 1.0;
        let (mut k, mut c) = (-balance.stiffness, -balance.damping);
        if let Some(j) = slope {
            k += Matrix2::new(j[0][0], j[0][1], j[1][0], j[1][1]);
            c += Matrix2::new(j[0][2], j[0][3], j[1][2], j[1][3]);
        }
        let inverse = setup.plant.body.mass_inverse;
        let (k, c) = (inverse * k, inverse * c);
        for i in 0..2 {
            for j in 0..2 {
                a[(2 + i) * nd + j] = k[(i, j)];
                a[(2 + i) * nd + 2 + j] = c[(i, j)];
            }
        }
        for (index, latent) in self.layout.latent.iter().flatten() {
            a[index * nd + index] = -1.0 / latent.time_s;
            let push = inverse * Vector2::from(latent.arm);
            for i in 0..2 {
                a[(2 + i) * nd + index] = push[i];
            }
        }
        if self.layout.heading {
            a[HEADING * nd + 1] = setup.plant.body.yaw[0] * pace.speed_m_s;
            a[HEADING * nd + 3] = setup.plant.body.yaw[1];
        }
        for (index, first) in self.layout.filters.iter().enumerate() {
            if let Some(first) = *first {
                self.fill_filter(index, first, pace);
            }
        }
    }

    /// A recorder's low-pass and running mean (Padé [0/2]) as states.
    fn fill_filter(&mut self, index: usize, first: usize, pace: &Pace) {
        let nd = self.layout.dynamic;
        let sensor = &self.ride.sensors[index];
        let mut source = vec![0.0; self.layout.states];
        self.truth_row(index, pace, &mut source);
        let mut next = first;
        if sensor.lag_s > 0.0 {
            let rate = 1.0 / sensor.lag_s;
            for j in 0..nd {
                self.a[next * nd + j] += rate * source[j];
            }
            self.a[next * nd + next] -= rate;
            source.fill(0.0);
            source[next] = 1.0;
            next += 1;
        }
        if sensor.moving_average_s > 0.0 {
            let t = sensor.moving_average_s;
            let stiffness = 12.0 / (t * t);
            self.a[next * nd + next + 1] = 1.0;
            for j in 0..nd {
                self.a[(next + 1) * nd + j] += stiffness * source[j];
            }
            self.a[(next + 1) * nd + next] -= stiffness;
            self.a[(next + 1) * nd + next + 1] -= 6.0 / t;
        }
    }

    /// Derivative of a sensor's reading by the states, before its filter and bias.
    pub(super) fn truth_row(&self, index: usize, pace: &Pace, row: &mut [f64]) {
        let (nd, body) = (self.layout.dynamic, &self.setup.plant.body);
        let sensor = &self.ride.sensors[index];
        let model = &self.setup.sensors[index];
        row.fill(0.0);
        let g = model.gain;
        let yaw = [body.yaw[0] * pace.speed_m_s, body.yaw[1]];
        match sensor.quantity {
            Quantity::Roll => row[0] = g,
            Quantity::Steer => row[1] = g,
            Quantity::RollRate => row[2] = g,
            Quantity::SteerRate => row[3] = g,
            Quantity::Yaw => row[HEADING] = g,
            Quantity::YawRate => {
                row[1] = g * yaw[0];
                row[3] = g * yaw[1];
            }
            _ => {
                let [x, z] = sensor.point_m;
                let v = pace.speed_m_s;
                row[0] = -g * body.gravity_m_s2;
                row[1] = g * v * yaw[0] + g * x * body.yaw[0] * pace.accel_m_s2;
                row[3] = g * (v * yaw[1] + x * yaw[0]);
                for j in 0..nd {
                    row[j] += g * (x * yaw[1] * self.a[3 * nd + j] - z * self.a[2 * nd + j]);
                }
            }
        }
        if model.yaw_share != 0.0 {
            row[1] += model.yaw_share * yaw[0];
            row[3] += model.yaw_share * yaw[1];
        }
    }
}
