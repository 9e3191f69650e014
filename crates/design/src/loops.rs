//! What: a rider in the loop, with a bound on what the delay may do.
//!
//! Equation: u = -k (roll, roll rate, steer, steer rate); T_steer = G(s) e^(-τ s) u with the muscles'
//! lag G of second order. The delay is e^(-τ s) = N(τ s) + Δ(s) W(τ s), N the Padé approximant of
//! order 2 by 2, |Δ(jω)| <= 1, and W(x) = 2.3 x² / (x² + √2 5.8 x + 5.8²) at least as large as the
//! error of N at every frequency. So x' = A x + B w, z = C x, ‖w‖ <= ‖z‖: an inequality that holds for
//! every such w holds for the exact delay.
//!
//! Source: Padé approximant: Golub and Van Loan (2013), section 9.3.1; small gain with a weight:
//! Zhou, Doyle and Glover (1996), section 9.3. The weight is ours.
//!
//! Assumes and ignores: no remnant, no limits; gains are those of the speed of the moment.
//!
//! Valid for: any delay above zero.
//!
//! Checked by: `the_weight_is_no_smaller_than_the_error` below, over all frequencies.

use crate::family::Vehicle;
use nalgebra::{DMatrix, DVector, RowDVector};
use serde::{Deserialize, Serialize};

/// Gain of the weight.
pub const WEIGHT_GAIN: f64 = 2.3;
/// Corner of the weight in ω τ.
pub const WEIGHT_CORNER: f64 = 5.8;

/// A rider of the set: everything but the gains.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Rider {
    /// Name.
    pub name: String,
    /// Delay, s.
    pub delay_s: f64,
    /// Frequency of the muscles' lag, rad/s.
    pub lag_rad_s: f64,
    /// Damping ratio of the muscles' lag.
    pub lag_damping_ratio: f64,
}

/// Gains on roll (Nm/rad), roll rate (Nm s/rad), steer (Nm/rad) and steer rate (Nm s/rad).
pub type Gains = [f64; 4];

/// Bicycle and rider: x' = a x + b w, z = c x.
#[derive(Clone, Debug)]
pub struct Loop {
    /// State matrix, n by n.
    pub a: DMatrix<f64>,
    /// Input of the delay's error, n.
    pub b: DVector<f64>,
    /// Its bound, n.
    pub c: RowDVector<f64>,
}

/// States beside those of the bicycle: muscles, Padé, weight.
pub const EXTRA: usize = 6;

impl Rider {
    /// The loop that this rider closes with `gains`.
    pub fn close(&self, vehicle: &Vehicle, gains: &Gains) -> Loop {
        let n = vehicle.a.nrows();
        let (muscle, pade, weight) = (n, n + 2, n + 4);
        let size = n + EXTRA;
        let mut k = RowDVector::zeros(size);
        for (row, gain) in vehicle.perceived.iter().zip(gains) {
            for i in 0..n {
                k[i] -= row[i] * gain;
            }
        }
        let mut a = DMatrix::zeros(size, size);
        a.view_mut((0, 0), (n, n)).copy_from(&vehicle.a);
        // Muscles: T = w y, y' = w y2, y2' = -w y - 2 z w y2 + delayed u.
        let (w, z) = (self.lag_rad_s, self.lag_damping_ratio);
        for i in 0..n {
            a[(i, muscle)] = vehicle.b[i] * w;
        }
        a[(muscle, muscle + 1)] = w;
        a[(muscle + 1, muscle)] = -w;
        a[(muscle + 1, muscle + 1)] = -2.0 * z * w;
        // Padé of order 2 by 2: (1 - s/2 + s²/12) / (1 + s/2 + s²/12) = 1 - 12 s / (s² + 6 s + 12).
        let tau = self.delay_s;
        a[(pade, pade + 1)] = 1.0 / tau;
        a[(pade + 1, pade)] = -12.0 / tau;
        a[(pade + 1, pade + 1)] = -6.0 / tau;
        a[(muscle + 1, pade + 1)] = -12.0;
        // Weight: gain (1 - (√2 x_c s + x_c²) / (s² + √2 x_c s + x_c²)), in x = s τ.
        let corner = WEIGHT_CORNER / tau;
        let root = core::f64::consts::SQRT_2;
        a[(weight, weight + 1)] = corner;
        a[(weight + 1, weight)] = -corner;
        a[(weight + 1, weight + 1)] = -root * corner;
        let mut c = &k * WEIGHT_GAIN;
        c[weight] = -WEIGHT_GAIN;
        c[weight + 1] = -WEIGHT_GAIN * root;
        for i in 0..size {
            a[(muscle + 1, i)] += k[i];
            a[(pade + 1, i)] += k[i] / tau;
            a[(weight + 1, i)] += k[i] * corner;
        }
        let mut b = DVector::zeros(size);
        b[muscle + 1] = 1.0;
        Loop { a, b, c }
    }
}

impl Rider {
    /// The loops that this rider closes with `gains` on each of these.
    pub fn close_all(&self, vehicles: &[Vehicle], gains: &Gains) -> Vec<Loop> {
        vehicles.iter().map(|v| self.close(v, gains)).collect()
    }
}

/// Largest growth rate of these loops, as [`growth_per_s`].
pub fn worst_growth_per_s(loops: &[Loop]) -> f64 {
    loops
        .iter()
        .map(growth_per_s)
        .fold(f64::NEG_INFINITY, f64::max)
}

/// Largest growth rate of the loop with the Padé approximant alone, 1/s; infinite if the eigenvalues
/// are not found.
pub fn growth_per_s(closed: &Loop) -> f64 {
    // The weight's poles are fast and stable: they do not matter.
    let rounds = 200 * closed.a.nrows();
    nalgebra::Schur::try_new(closed.a.clone(), f64::EPSILON, rounds).map_or(
        f64::INFINITY,
        |schur| {
            schur
                .complex_eigenvalues()
                .iter()
                .map(|z| z.re)
                .fold(f64::NEG_INFINITY, f64::max)
        },
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Complex;

    fn pade(s: Complex<f64>) -> Complex<f64> {
        let one = Complex::new(1.0, 0.0);
        (one - s / 2.0 + s * s / 12.0) / (one + s / 2.0 + s * s / 12.0)
    }

    fn weight(s: Complex<f64>) -> Complex<f64> {
        let x = WEIGHT_CORNER;
        s * s * WEIGHT_GAIN
            / (s * s + s * (core::f64::consts::SQRT_2 * x) + Complex::new(x * x, 0.0))
    }

    #[test]
    fn the_weight_is_no_smaller_than_the_error() {
        // Below x = 0.1 the error is below x⁵ / 720, above 60 it is at most 2 and the weight above 2.2.
        let mut x = 0.05;
        while x < 100.0 {
            let s = Complex::new(0.0, x);
            let error = (Complex::new(libm::cos(x), -libm::sin(x)) - pade(s)).norm_sqr();
            let bound = weight(s).norm_sqr();
            assert!(error <= bound, "at {x}: {error} > {bound}");
            x *= 1.0005;
        }
        let low = 0.05_f64;
        assert!(low.powi(5) / 720.0 < WEIGHT_GAIN * low * low / (2.0 * WEIGHT_CORNER.powi(2)));
        assert!(weight(Complex::new(0.0, 100.0)).norm_sqr() > 4.0);
    }

    #[test]
    fn the_loop_is_that_of_the_transfer_functions() {
        // A bicycle of one state, x' = T, perceived as roll.
        let vehicle = Vehicle {
            a: DMatrix::from_element(1, 1, -1.5),
            b: DVector::from_element(1, 0.7),
            perceived: [
                RowDVector::from_element(1, 1.0),
                RowDVector::zeros(1),
                RowDVector::zeros(1),
                RowDVector::zeros(1),
            ],
        };
        let rider = Rider {
            name: "test".to_owned(),
            delay_s: 0.2,
            lag_rad_s: 30.0,
            lag_damping_ratio: 0.7,
        };
        let closed = rider.close(&vehicle, &[3.0, 0.0, 0.0, 0.0]);
        let n = closed.a.nrows();
        let s = Complex::new(0.3, 4.0);
        let lag = Complex::new(900.0, 0.0) / (s * s + s * 42.0 + Complex::new(900.0, 0.0));
        let plant = Complex::new(0.7, 0.0) / (s + Complex::new(1.5, 0.0));
        // z/w = W(-3 P G) / (1 + 3 P G N): the loop from the delay's error to its bound.
        let expected = -weight(s * 0.2) * plant * lag * 3.0
            / (Complex::new(1.0, 0.0) + plant * lag * pade(s * 0.2) * 3.0);
        let m = DMatrix::from_fn(n, n, |i, j| {
            let own = if i == j { s } else { Complex::new(0.0, 0.0) };
            own - Complex::new(closed.a[(i, j)], 0.0)
        });
        let x = m
            .lu()
            .solve(&closed.b.map(|b| Complex::new(b, 0.0)))
            .expect("regular");
        let z: Complex<f64> = (0..n).map(|i| x[i] * closed.c[i]).sum();
        assert!(
            (z - expected).norm_sqr() < 1e-18 * expected.norm_sqr(),
            "{z} {expected}"
        );
    }
}
