//! What: a state-space model with four poles, one input and any number of outputs, fitted to a
//! record; for a bicycle the outputs are roll and steer and one pair of poles is weave.
//!
//! Equation: each output is a sum over the states of two second-order systems that share the input,
//! x'' + a1 x' + a0 x = u and z'' + b1 z' + b0 z = u: a state-space model of order four whose
//! poles are the roots of the two quadratics. Coefficients of the outputs are linear and
//! projected out; the four of the quadratics are found by Levenberg and Marquardt's method on the
//! difference between record and simulation (output error). Start: a realisation of order four from
//! the response after the input has ended.
//!
//! Source: Bulsink (2017), sections 3.2.3 and 7.2.2.1 (four poles, roll and steer); Juang and Pappa
//! (1985), Journal of Guidance 8, 620-627 (realisation); Golub and Pereyra (1973), SIAM Journal on
//! Numerical Analysis 10, 413-432 (projection).
//!
//! Assumes and ignores: the record starts at rest; the input is constant from one sample to the
//! next; what the four poles cannot say (tyres and body, well damped) is left in the residual, and
//! moves the poles a little.
//!
//! Valid for: records without noise to speak of, in which the wanted mode outlives the others.
//!
//! Checked by: tests here (poles of known systems to 1e-7) and, on the multibody bicycle against
//! its linearisation, the tests of `twinhub-reproduce`.

mod basis;
mod realisation;

use basis::Basis;
use nalgebra::{Complex, DMatrix, DVector, SMatrix, SVector};

/// A record: samples `step_s` apart, the first at rest.
#[derive(Clone, Copy, Debug)]
pub struct Response<'a> {
    /// Time from one sample to the next, s.
    pub step_s: f64,
    /// Input, constant from its sample to the next one.
    pub input: &'a [f64],
    /// Outputs, each as long as the input.
    pub outputs: &'a [&'a [f64]],
}

/// A fitted model.
#[derive(Clone, Debug, PartialEq)]
pub struct FourPoles {
    /// The poles, 1/s, sorted by real, then imaginary part.
    pub poles: [Complex<f64>; 4],
    /// Root mean square of what is left over that of the record; largest over the outputs.
    pub relative_error: f64,
}

/// Why no model comes out.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FourPoleError {
    /// Too short, or of unequal lengths.
    #[error(
        "four poles: {samples} samples of input and {shortest} of the shortest output; accepted: equal numbers, at least {least} after the input has ended"
    )]
    Samples {
        /// Samples of the input.
        samples: usize,
        /// Samples of the shortest output.
        shortest: usize,
        /// What is needed at least.
        least: usize,
    },
    /// Something is not a number, or nothing moves.
    #[error("four poles: {what}; accepted: finite samples, an input, and outputs that move")]
    Empty {
        /// What was found.
        what: &'static str,
    },
    /// The realisation does not have four poles.
    #[error(
        "four poles: the response after the input has {found} poles that stand out; accepted: 4"
    )]
    Order {
        /// How many there are.
        found: usize,
    },
}

/// Iterations at most.
const ITERATIONS: usize = 200;
/// Relative change of the sum of squares at which the search ends.
const CONVERGED: f64 = 1.0e-13;

impl FourPoles {
    /// Fits a model to a record.
    ///
    /// # Errors
    /// Where the record is too short, is not finite, does not move, or has fewer than four poles.
    pub fn fit(record: &Response<'_>) -> Result<Self, FourPoleError> {
        let outputs = checked(record)?;
        let start = realisation::poles(record, &outputs)?;
        let mut theta = quadratics(start);
        let mut residual = project(record, &outputs, &theta);
        let mut cost = residual.norm_squared();
        let mut damping = 1.0e-3;
        for _ in 0..ITERATIONS {
            let jacobian = differences(record, &outputs, &theta, residual.len());
            let normal =
                SMatrix::<f64, 4, 4>::from_fn(|i, j| jacobian.column(i).dot(&jacobian.column(j)));
            let slope = SVector::<f64, 4>::from_fn(|i, _| jacobian.column(i).dot(&residual));
            let before = cost;
            let mut improved = false;
            for _ in 0..12 {
                let damped = normal + SMatrix::from_diagonal(&normal.diagonal().scale(damping));
                let step = damped.lu().solve(&slope);
                let trial = step.map(|step| theta - step);
                let tried = trial.map(|t| (t, project(record, &outputs, &t)));
                match tried {
                    Some((t, r)) if r.norm_squared() < cost => {
                        (theta, cost, residual) = (t, r.norm_squared(), r);
                        damping = (damping * 0.2).max(1.0e-12);
                        improved = true;
                        break;
                    }
                    _ => damping = (damping * 5.0).max(1.0e-9),
                }
            }
            if !improved || before - cost <= CONVERGED * before {
                break;
            }
        }
        Ok(Self {
            poles: sorted(roots(&theta)),
            relative_error: relative(&residual, outputs.len()),
        })
    }

    /// The slow oscillation: of pole pairs below `limit_rad_s` the one that grows most or decays
    /// least; `None` if none oscillates.
    pub fn weave(&self, limit_rad_s: f64) -> Option<Complex<f64>> {
        self.poles
            .into_iter()
            .filter(|p| p.im > 0.0 && p.im < limit_rad_s)
            .max_by(|a, b| a.re.total_cmp(&b.re))
    }

    /// The largest real pole: of a bicycle, capsize.
    pub fn slowest_real(&self) -> Option<f64> {
        let real = self.poles.iter().filter(|p| p.im == 0.0).map(|p| p.re);
        real.max_by(f64::total_cmp)
    }
}

/// The outputs, each divided by its root mean square.
fn checked(record: &Response<'_>) -> Result<Vec<DVector<f64>>, FourPoleError> {
    let samples = record.input.len();
    let shortest = record.outputs.iter().map(|o| o.len()).min().unwrap_or(0);
    let equal = record.outputs.iter().all(|o| o.len() == samples);
    if !equal || shortest < realisation::LEAST {
        return Err(FourPoleError::Samples {
            samples,
            shortest,
            least: realisation::LEAST,
        });
    }
    let finite = |v: &[f64]| v.iter().all(|x| x.is_finite());
    let step = record.step_s > 0.0 && record.step_s.is_finite();
    if !step || !finite(record.input) || !record.outputs.iter().all(|o| finite(o)) {
        return Err(FourPoleError::Empty {
            what: "a number is not finite, or the step is not above zero",
        });
    }
    if record.input.iter().all(|u| *u == 0.0) {
        return Err(FourPoleError::Empty {
            what: "the input is zero throughout",
        });
    }
    record
        .outputs
        .iter()
        .map(|output| {
            let y = DVector::from_column_slice(output);
            let size = y.norm() / libm::sqrt(samples as f64);
            if size > 0.0 {
                Ok(y / size)
            } else {
                Err(FourPoleError::Empty {
                    what: "an output is zero throughout",
                })
            }
        })
        .collect()
}

/// Coefficients (a1, a0, b1, b0) of two quadratics with these roots. Conjugates stay together; of
/// real roots the two slowest.
fn quadratics(poles: [Complex<f64>; 4]) -> SVector<f64, 4> {
    let complex: Vec<_> = poles.iter().filter(|p| p.im > 0.0).collect();
    let mut real: Vec<f64> = poles.iter().filter(|p| p.im == 0.0).map(|p| p.re).collect();
    real.sort_by(|a, b| b.total_cmp(a));
    let mut pairs: Vec<[f64; 2]> = complex
        .iter()
        .map(|p| [-2.0 * p.re, p.norm_sqr()])
        .collect();
    pairs.extend(real.chunks_exact(2).map(|r| [-(r[0] + r[1]), r[0] * r[1]]));
    SVector::from([pairs[0][0], pairs[0][1], pairs[1][0], pairs[1][1]])
}

/// Roots of both quadratics.
fn roots(theta: &SVector<f64, 4>) -> [Complex<f64>; 4] {
    let pair = |half: f64, c: f64| {
        let d = half * half - c;
        let root = libm::sqrt(d.abs());
        if d < 0.0 {
            [Complex::new(-half, root), Complex::new(-half, -root)]
        } else {
            // The larger one first, the other from the product: no cancellation.
            let large = -half - root.copysign(half);
            let small = if large == 0.0 { 0.0 } else { c / large };
            [Complex::new(large, 0.0), Complex::new(small, 0.0)]
        }
    };
    let [a, b] = pair(0.5 * theta[0], theta[1]);
    let [c, d] = pair(0.5 * theta[2], theta[3]);
    [a, b, c, d]
}

fn sorted(mut poles: [Complex<f64>; 4]) -> [Complex<f64>; 4] {
    poles.sort_by(|a, b| a.re.total_cmp(&b.re).then(a.im.total_cmp(&b.im)));
    poles
}

/// What the best model with these quadratics leaves, all outputs after each other.
fn project(
    record: &Response<'_>,
    outputs: &[DVector<f64>],
    theta: &SVector<f64, 4>,
) -> DVector<f64> {
    let n = record.input.len();
    let unusable = || DVector::from_element(n * outputs.len(), f64::INFINITY);
    let Some(basis) = Basis::new(record, theta) else {
        return unusable();
    };
    let q = DMatrix::from_columns(&basis.columns).qr().q();
    let mut left = DVector::zeros(n * outputs.len());
    for (k, y) in outputs.iter().enumerate() {
        let rest = y - &q * (q.transpose() * y);
        left.rows_mut(k * n, n).copy_from(&rest);
    }
    if left.iter().all(|v| v.is_finite()) {
        left
    } else {
        unusable()
    }
}

/// Derivatives of the residual, by central differences.
fn differences(
    record: &Response<'_>,
    outputs: &[DVector<f64>],
    theta: &SVector<f64, 4>,
    rows: usize,
) -> DMatrix<f64> {
    let mut jacobian = DMatrix::zeros(rows, 4);
    for k in 0..4 {
        // Fine against the scale of the quadratic that the coefficient belongs to.
        let scale = libm::sqrt(theta[k | 1].abs())
            .max(theta[k & 2].abs())
            .max(1.0);
        let step = 1.0e-5 * if k % 2 == 0 { scale } else { scale * scale };
        let at = |sign: f64| {
            let mut moved = *theta;
            moved[k] += sign * step;
            project(record, outputs, &moved)
        };
        jacobian.set_column(k, &((at(1.0) - at(-1.0)) / (2.0 * step)));
    }
    jacobian
}

/// Largest root mean square over the outputs, which are scaled to one.
fn relative(residual: &DVector<f64>, outputs: usize) -> f64 {
    let n = residual.len() / outputs;
    (0..outputs)
        .map(|k| residual.rows(k * n, n).norm() / libm::sqrt(n as f64))
        .fold(0.0, f64::max)
}

#[cfg(test)]
mod tests;
