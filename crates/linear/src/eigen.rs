//! Eigenvalues with their shapes: of the benchmark bicycle to full accuracy, and of any state
//! matrix.

use crate::canonical::Canonical;
use crate::motor_pair::MotorPair;
use crate::quartic;
use nalgebra::{Complex, DMatrix, DVector, Schur};

/// One eigenvalue and its eigenvector of unit length.
#[derive(Debug, Clone, PartialEq)]
pub struct Eigenpair {
    /// 1/s; the imaginary part is the frequency in rad/s.
    pub value: Complex<f64>,
    /// In the order of the state vector.
    pub shape: Vec<Complex<f64>>,
}

/// Eigenvalues that cannot be had.
#[non_exhaustive]
#[derive(Debug, thiserror::Error)]
pub enum EigenError {
    /// A number of the matrix is not finite.
    #[error("row {row}, column {column} of the state matrix is {value}; accepted: finite numbers")]
    NotFinite {
        /// Row, from 0.
        row: usize,
        /// Column, from 0.
        column: usize,
        /// What stands there.
        value: f64,
    },
    /// The iteration ended without result.
    #[error(
        "the eigenvalues of a {order} by {order} matrix were not found in {iterations} iterations"
    )]
    NotConverged {
        /// Order of the matrix.
        order: usize,
        /// Iterations made.
        iterations: usize,
    },
}

fn normalised(shape: impl IntoIterator<Item = Complex<f64>>) -> Vec<Complex<f64>> {
    let shape: Vec<_> = shape.into_iter().collect();
    let length = libm::sqrt(shape.iter().map(|z| z.norm_sqr()).sum());
    shape
        .into_iter()
        .map(|z| if length > 0.0 { z / length } else { z })
        .collect()
}

impl Canonical {
    /// The four eigenvalues, 1/s, sorted by real, then imaginary part; conjugates exactly paired.
    pub fn eigenvalues(&self, speed_m_s: f64, pair: MotorPair) -> [Complex<f64>; 4] {
        let p = quartic::characteristic(
            &self.mass(),
            &self.damping(speed_m_s),
            &self.stiffness(speed_m_s, pair),
        );
        let roots = quartic::roots(&p);
        core::array::from_fn(|i| roots[i])
    }

    /// The four modes, sorted as `eigenvalues`; shape in (roll, steer, roll rate, steer rate).
    pub fn eigenpairs(&self, speed_m_s: f64, pair: MotorPair) -> Vec<Eigenpair> {
        let (m, c, k) = (
            self.mass(),
            self.damping(speed_m_s),
            self.stiffness(speed_m_s, pair),
        );
        self.eigenvalues(speed_m_s, pair)
            .into_iter()
            .map(|s| {
                let row = |i| {
                    let entry = |j| s * s * m[(i, j)] + s * c[(i, j)] + k[(i, j)];
                    (entry(0), entry(1))
                };
                // Orthogonal to the longer row of M s² + C s + K, each in its own scale.
                let rows = [row(0), row(1)];
                let weight =
                    |i: usize| (rows[i].0.norm_sqr() + rows[i].1.norm_sqr()) / m[(i, i)].powi(2);
                let (a, b) = rows[usize::from(weight(1) > weight(0))];
                let (roll, steer) = (-b, a);
                Eigenpair {
                    value: s,
                    shape: normalised([roll, steer, s * roll, s * steer]),
                }
            })
            .collect()
    }
}

/// All eigenvalues of a real square matrix with their shapes, conjugates exactly paired, sorted by
/// real, then imaginary part.
pub fn eigenpairs(a: &DMatrix<f64>) -> Result<Vec<Eigenpair>, EigenError> {
    let n = a.nrows();
    for column in 0..n {
        for row in 0..n {
            let value = a[(row, column)];
            if !value.is_finite() {
                return Err(EigenError::NotFinite { row, column, value });
            }
        }
    }
    let iterations = 1000 * n.max(1);
    let schur =
        Schur::try_new(a.clone(), f64::EPSILON, iterations).ok_or(EigenError::NotConverged {
            order: n,
            iterations,
        })?;
    let mut values: Vec<_> = schur.complex_eigenvalues().iter().copied().collect();
    values.sort_by(|a, b| a.re.total_cmp(&b.re).then(a.im.total_cmp(&b.im)));
    let complex = a.map(|x| Complex::new(x, 0.0));
    let mut pairs: Vec<Eigenpair> = Vec::with_capacity(n);
    for value in values.iter().copied().filter(|z| z.im >= 0.0) {
        let pair = inverse_iteration(&complex, value);
        if pair.value.im != 0.0 {
            pairs.push(Eigenpair {
                value: pair.value.conj(),
                shape: pair.shape.iter().map(Complex::conj).collect(),
            });
        }
        pairs.push(pair);
    }
    pairs.sort_by(|a, b| {
        a.value
            .re
            .total_cmp(&b.value.re)
            .then(a.value.im.total_cmp(&b.value.im))
    });
    Ok(pairs)
}

/// Two steps of inverse iteration beside `value`; the value is not changed.
fn inverse_iteration(a: &DMatrix<Complex<f64>>, value: Complex<f64>) -> Eigenpair {
    let n = a.nrows();
    let scale = 1.0 + a.iter().map(|z| z.norm_sqr()).fold(0.0, f64::max).sqrt();
    let mut shifted = a.clone();
    for i in 0..n {
        // Beside the eigenvalue, so that the matrix can be inverted.
        shifted[(i, i)] -= value + scale * 1e-14;
    }
    let lu = shifted.lu();
    let mut x = DVector::from_fn(n, |i, _| {
        Complex::new(1.0 + 0.1 * (i as f64), 0.3 * (i as f64 % 3.0))
    });
    for _ in 0..3 {
        let Some(y) = lu.solve(&x) else { break };
        let length = libm::sqrt(y.iter().map(|z| z.norm_sqr()).sum());
        if !(length.is_finite() && length > 0.0) {
            break;
        }
        x = y / Complex::new(length, 0.0);
    }
    let mut shape = normalised(x.iter().copied());
    if value.im == 0.0 {
        // A real mode has a real shape: turn the phase of its largest part to zero.
        let top = shape
            .iter()
            .copied()
            .max_by(|a, b| a.norm_sqr().total_cmp(&b.norm_sqr()));
        let phase = top.map_or(Complex::new(1.0, 0.0), |z| {
            z.conj() / libm::sqrt(z.norm_sqr())
        });
        shape = normalised(shape.into_iter().map(|z| Complex::new((z * phase).re, 0.0)));
    }
    Eigenpair { value, shape }
}
