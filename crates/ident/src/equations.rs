//! What: the benchmark bicycle with its sensors' filters and biases as one linear model
//! x' = A(v, pair) x + B u, y = C(v) x + D u.
//!
//! Equation: x = (roll, steer, roll rate, steer rate, [heading], [filters], [biases]);
//! psi' = (v steer + c steer') cos(lam)/w; lateral specific force at (x, z):
//! v psi' + x psi'' - z roll'' - g roll; a first-order filter f' = (y - f)/tau; a running mean of
//! length T as 1/(1 + s T/2 + s² T²/12), the Padé approximant [0/2] of (1 - exp(-s T))/(s T); a
//! bias b: reading = truth + b.
//!
//! Source: Meijaard et al. (2007), equations (4.5), (4.6); Padé approximant own, by matching the
//! series to third order.
//!
//! Assumes and ignores: small angles, no slip; the derivative of the speed in psi''.
//!
//! Valid for: running mean: gain within 0.2 % and phase within 0.1 degrees up to omega T = 1, 1.2 %
//! and 1.1 degrees at 2.
//!
//! Checked by: `tests`, signs by physics and the frequency response of the filters.

use crate::ride::{Output, Ride};
use twinhub_linear::{Bicycle, BicycleError, Canonical, MotorPair};

/// The equations of one bicycle, ready for any ride.
#[derive(Clone, Debug)]
pub struct Equations {
    canonical: Canonical,
    gravity_m_s2: f64,
}

/// States of the bicycle itself.
const BASE: usize = 4;
const HEADING: usize = 4;

/// A row of C and of D.
#[derive(Clone, Debug, PartialEq)]
pub struct OutputRow {
    pub state: Vec<f64>,
    pub input: Vec<f64>,
}

/// Which state is what, for one ride.
#[derive(Clone, Debug)]
pub struct Layout {
    heading: bool,
    /// First filter state of each sensor, if it has any.
    filters: Vec<Option<usize>>,
    /// Number of states before the biases.
    pub dynamic: usize,
    sensor_bias: Vec<Option<usize>>,
    drive_bias: Vec<Option<usize>>,
    /// Number of all states.
    pub states: usize,
}

impl Layout {
    pub fn new(ride: &Ride) -> Self {
        let heading = ride.sensors.iter().any(|s| s.output == Output::Yaw);
        let mut next = BASE + usize::from(heading);
        let filters = ride.sensors.iter().map(|s| {
            let count = usize::from(s.lag_s > 0.0) + 2 * usize::from(s.moving_average_s > 0.0);
            let first = (count > 0).then_some(next);
            next += count;
            first
        });
        let filters = filters.collect();
        let dynamic = next;
        let mut take = |sd: f64| {
            (sd > 0.0).then(|| {
                next += 1;
                next - 1
            })
        };
        let sensor_bias = ride.sensors.iter().map(|s| take(s.bias_sd)).collect();
        let drive_bias = ride.drives.iter().map(|d| take(d.bias_sd)).collect();
        Self {
            heading,
            filters,
            dynamic,
            sensor_bias,
            drive_bias,
            states: next,
        }
    }

    /// Variance of each state before the first reading: angles and rates far beyond any ride's,
    /// biases as declared.
    pub fn prior_variance(&self, ride: &Ride) -> Vec<f64> {
        let mut variance = vec![25.0; self.states];
        variance[..BASE].copy_from_slice(&[0.25, 0.25, 9.0, 9.0]);
        if self.heading {
            variance[HEADING] = 100.0;
        }
        for (sensor, first) in ride.sensors.iter().zip(&self.filters) {
            if let Some(first) = first
                && sensor.moving_average_s > 0.0
            {
                variance[first + usize::from(sensor.lag_s > 0.0) + 1] = 1e4;
            }
        }
        let biases = self
            .sensor_bias
            .iter()
            .zip(ride.sensors.iter().map(|s| s.bias_sd));
        for (state, sd) in biases.chain(
            self.drive_bias
                .iter()
                .zip(ride.drives.iter().map(|d| d.bias_sd)),
        ) {
            if let Some(state) = state {
                variance[*state] = sd * sd;
            }
        }
        variance
    }
}

/// A and B at one moment.
#[derive(Clone, Debug)]
pub struct Matrices {
    /// States by states, row-major.
    pub a: Vec<f64>,
    /// One column a drive.
    pub b: Vec<Vec<f64>>,
    /// Response of the states' derivative to roll and to steer torque.
    pub torque: [Vec<f64>; 2],
}

impl Equations {
    pub fn new(bicycle: &Bicycle) -> Result<Self, BicycleError> {
        Ok(Self {
            canonical: Canonical::new(bicycle)?,
            gravity_m_s2: bicycle.parameters.g,
        })
    }

    /// The bicycle's matrices.
    pub fn canonical(&self) -> &Canonical {
        &self.canonical
    }

    /// Roll and steer torque per newton of a side force on the rear frame at (x, z): the front
    /// contact takes x/w of it and its trail turns that into steer torque.
    pub fn side_force_arm_m(&self, x_m: f64, z_m: f64) -> [f64; 2] {
        // The yaw rate per steer rate is c cos(lam)/w.
        [-z_m, self.canonical.yaw_rate_rad_s(0.0, 0.0, 1.0) * x_m]
    }

    /// A of the bicycle alone with the laws that act without delay, for growth rates.
    pub fn closed_loop(&self, ride: &Ride, speed_m_s: f64, pair: MotorPair) -> [[f64; 4]; 4] {
        let bare = Ride {
            sensors: vec![],
            drives: vec![],
            ..ride.clone()
        };
        let layout = Layout::new(&bare);
        let a = self.matrices(&bare, &layout, speed_m_s, pair, true).a;
        std::array::from_fn(|i| std::array::from_fn(|j| a[i * BASE + j]))
    }

    /// A and B; `closed` puts the laws that act at once into A.
    pub fn matrices(
        &self,
        ride: &Ride,
        layout: &Layout,
        speed_m_s: f64,
        pair: MotorPair,
        closed: bool,
    ) -> Matrices {
        let n = layout.states;
        let mut a = vec![0.0; n * n];
        let bare = self.canonical.state_matrix(speed_m_s, pair);
        for i in 0..BASE {
            for j in 0..BASE {
                a[i * n + j] = bare[(i, j)];
            }
        }
        let inverse_mass = self.canonical.input_matrix();
        let torque: [Vec<f64>; 2] = std::array::from_fn(|axis| {
            let mut column = vec![0.0; n];
            for (i, x) in column.iter_mut().enumerate().take(BASE) {
                *x = inverse_mass[(i, axis)];
            }
            column
        });
        let along = |arm: [f64; 2]| -> Vec<f64> {
            torque[0]
                .iter()
                .zip(&torque[1])
                .map(|(r, s)| arm[0] * r + arm[1] * s)
                .collect()
        };
        let mut b: Vec<Vec<f64>> = ride.drives.iter().map(|d| along(d.arm)).collect();
        for (column, bias) in b.iter().zip(&layout.drive_bias) {
            if let Some(bias) = bias {
                for i in 0..BASE {
                    a[i * n + bias] = -column[i];
                }
            }
        }
        if closed {
            for law in ride.laws.iter().filter(|law| law.delay_s == 0.0) {
                let row = self.law_row(layout, law.of, speed_m_s);
                let gain = law.gain.at(speed_m_s);
                for (i, x) in along(law.arm).iter().enumerate() {
                    for (j, y) in row.iter().enumerate() {
                        a[i * n + j] += x * gain * y;
                    }
                }
            }
        }
        if layout.heading {
            let yaw = self.yaw_row(speed_m_s, n);
            a[HEADING * n..(HEADING + 1) * n].copy_from_slice(&yaw);
        }
        for (sensor, first) in ride.sensors.iter().zip(&layout.filters) {
            let Some(first) = *first else { continue };
            let mut source = self.truth(&a, &b, n, sensor.output, speed_m_s);
            let mut next = first;
            if sensor.lag_s > 0.0 {
                self.feed(&mut a, &mut b, n, next, &source, 1.0 / sensor.lag_s);
                a[next * n + next] -= 1.0 / sensor.lag_s;
                source = OutputRow {
                    state: unit(n, next),
                    input: vec![0.0; b.len()],
                };
                next += 1;
            }
            if sensor.moving_average_s > 0.0 {
                let t = sensor.moving_average_s;
                let stiffness = 12.0 / (t * t);
                a[next * n + next + 1] = 1.0;
                self.feed(&mut a, &mut b, n, next + 1, &source, stiffness);
                a[(next + 1) * n + next] -= stiffness;
                a[(next + 1) * n + next + 1] -= 6.0 / t;
            }
        }
        Matrices { a, b, torque }
    }

    fn feed(
        &self,
        a: &mut [f64],
        b: &mut [Vec<f64>],
        n: usize,
        row: usize,
        source: &OutputRow,
        factor: f64,
    ) {
        for (x, y) in a[row * n..(row + 1) * n].iter_mut().zip(&source.state) {
            *x += factor * y;
        }
        for (column, y) in b.iter_mut().zip(&source.input) {
            column[row] += factor * y;
        }
    }

    fn yaw_row(&self, speed_m_s: f64, n: usize) -> Vec<f64> {
        let mut row = vec![0.0; n];
        row[1] = self.canonical.yaw_rate_rad_s(speed_m_s, 1.0, 0.0);
        row[3] = self.canonical.yaw_rate_rad_s(speed_m_s, 0.0, 1.0);
        row
    }

    /// The row of an output that depends on the state alone.
    pub(crate) fn law_row(&self, layout: &Layout, output: Output, speed_m_s: f64) -> Vec<f64> {
        let n = layout.states;
        match output {
            Output::Roll => unit(n, 0),
            Output::Steer => unit(n, 1),
            Output::RollRate => unit(n, 2),
            Output::SteerRate => unit(n, 3),
            Output::Yaw if layout.heading => unit(n, HEADING),
            Output::YawRate => self.yaw_row(speed_m_s, n),
            Output::Yaw | Output::LateralAccel { .. } => vec![0.0; n],
        }
    }

    /// The true value of an output, before filter and bias.
    fn truth(
        &self,
        a: &[f64],
        b: &[Vec<f64>],
        n: usize,
        output: Output,
        speed_m_s: f64,
    ) -> OutputRow {
        let mut row = OutputRow {
            state: vec![0.0; n],
            input: vec![0.0; b.len()],
        };
        match output {
            Output::Roll => row.state[0] = 1.0,
            Output::Steer => row.state[1] = 1.0,
            Output::RollRate => row.state[2] = 1.0,
            Output::SteerRate => row.state[3] = 1.0,
            Output::Yaw => row.state[HEADING] = 1.0,
            Output::YawRate => row.state = self.yaw_row(speed_m_s, n),
            Output::LateralAccel { x_m, z_m } => {
                let yaw = self.yaw_row(speed_m_s, n);
                // v psi' + x (yaw steer' + c steer'') - z roll'' - g roll
                for (s, y) in row.state.iter_mut().zip(&yaw) {
                    *s += speed_m_s * y;
                }
                row.state[3] += x_m * yaw[1];
                row.state[0] -= self.gravity_m_s2;
                for j in 0..n {
                    row.state[j] += x_m * yaw[3] * a[3 * n + j] - z_m * a[2 * n + j];
                }
                for (input, column) in row.input.iter_mut().zip(b) {
                    *input = x_m * yaw[3] * column[3] - z_m * column[2];
                }
            }
        }
        row
    }

    /// What a sensor reads.
    pub fn reading(
        &self,
        ride: &Ride,
        layout: &Layout,
        matrices: &Matrices,
        sensor: usize,
        speed_m_s: f64,
    ) -> OutputRow {
        let n = layout.states;
        let channel = &ride.sensors[sensor];
        let mut row = match layout.filters[sensor] {
            Some(first) => {
                let last = if channel.moving_average_s > 0.0 {
                    first + usize::from(channel.lag_s > 0.0)
                } else {
                    first
                };
                OutputRow {
                    state: unit(n, last),
                    input: vec![0.0; ride.drives.len()],
                }
            }
            None => self.truth(&matrices.a, &matrices.b, n, channel.output, speed_m_s),
        };
        if let Some(bias) = layout.sensor_bias[sensor] {
            row.state[bias] = 1.0;
        }
        row
    }
}

fn unit(n: usize, index: usize) -> Vec<f64> {
    let mut row = vec![0.0; n];
    row[index] = 1.0;
    row
}
