//! What: does a rider keep a bicycle up? Growth rates of the closed loop with its delays.
//!
//! Equation: x' = A x + Σ b_c T_c with the bicycle's lateral part (A, b) at one speed and motor
//! torque, T_c the channels of `linear`. Eigenvalues are the roots of
//! det(s I - A + Σ b_c k_c' G_c(s) e^(-τ_c s)) = 0. First all roots of a finite model, the delays as
//! Legendre delay lines (Padé approximants of order 9 by 10), then Newton's method on the exact
//! equation: s - 1 / tr(M⁻¹ M'), the lags' poles taken out.
//!
//! Source: characteristic equation with delay as in Bulsink (2017), section 6.2.1; delay line of
//! Voelker and Eliasmith (2018), Neural Computation 30(3), 569-609; Newton on a determinant by
//! Jacobi's formula.
//!
//! Assumes and ignores: small motions about straight running at constant speed; no remnant, no
//! limits. Heading counts only where a channel feeds it back.
//!
//! Valid for: roots with |Im s| τ below about 8, which holds for everything slow enough to matter.
//!
//! Checked by: `rider/tests`: count of unstable roots by the argument principle, growth in the
//! nonlinear simulation, and the delay-free case against the eigenvalues of the matrix.

use super::{LateralBicycle, Limb, LinearChannel, RiderFile};
use crate::multibody::{Multibody, MultibodyError};
use nalgebra::{Complex, DMatrix, DVector, RowDVector, Schur};

/// Order of the delay lines.
const ORDER: usize = 10;
/// Roots that are refined: those faster than this are far from mattering, 1/s.
const DEEPEST_PER_S: f64 = -6.0;

fn place(limb: Limb) -> usize {
    match limb {
        Limb::Bar => 0,
        Limb::Trunk => 1,
        Limb::Knees => 2,
    }
}

/// One delayed feedback path.
#[derive(Clone, Debug)]
struct Path {
    channel: LinearChannel,
    b: DVector<f64>,
    k: RowDVector<f64>,
}

/// Bicycle and rider.
#[derive(Clone, Debug)]
pub struct ClosedLoop {
    a: DMatrix<f64>,
    paths: Vec<Path>,
}

impl ClosedLoop {
    /// A bicycle with these channels.
    pub fn new(bicycle: &LateralBicycle, channels: &[LinearChannel]) -> Self {
        let n = bicycle.a.nrows();
        let heading = channels.iter().any(|c| c.delayed.heading != 0.0);
        let size = n + usize::from(heading);
        let mut a = DMatrix::zeros(size, size);
        a.view_mut((0, 0), (n, n)).copy_from(&bicycle.a);
        if heading {
            a.view_mut((n, 0), (1, n)).copy_from(&bicycle.yaw_rate);
        }
        let mut paths = Vec::with_capacity(channels.len());
        for channel in channels {
            let at = place(channel.limb);
            let [angle, rate] = &bicycle.angle[at];
            let held = angle * channel.stiffness_nm_rad + rate * channel.damping_nm_s_rad;
            let own = &bicycle.torque[at] * held;
            a.view_mut((0, 0), (n, n)).zip_apply(&own, |x, y| *x -= y);
            let g = channel.delayed;
            let [steer, steer_rate] = &bicycle.angle[0];
            let mut k = RowDVector::zeros(size);
            let sum = &bicycle.roll * g.roll
                + &bicycle.roll_rate * g.roll_rate
                + steer * g.steer
                + steer_rate * g.steer_rate;
            k.columns_mut(0, n).copy_from(&sum);
            if heading {
                k[n] = g.heading;
            }
            let mut b = DVector::zeros(size);
            b.rows_mut(0, n).copy_from(&bicycle.torque[at]);
            paths.push(Path {
                channel: *channel,
                b,
                k,
            });
        }
        Self { a, paths }
    }

    /// The finite model: delays as Legendre delay lines.
    fn finite(&self) -> DMatrix<f64> {
        let n = self.a.nrows();
        let extra = |p: &Path| {
            let delay = if p.channel.delay_s > 0.0 { ORDER } else { 0 };
            delay + if p.channel.lag.is_some() { 2 } else { 0 }
        };
        let size = n + self.paths.iter().map(extra).sum::<usize>();
        let mut m = DMatrix::zeros(size, size);
        m.view_mut((0, 0), (n, n)).copy_from(&self.a);
        let mut at = n;
        for path in &self.paths {
            // The row that gives the path's signal so far.
            let mut signal = RowDVector::zeros(size);
            signal.columns_mut(0, n).copy_from(&(-&path.k));
            let delay = path.channel.delay_s;
            if delay > 0.0 {
                for i in 0..ORDER {
                    let weight = (2 * i + 1) as f64 / delay;
                    let sign = if i % 2 == 0 { 1.0 } else { -1.0 };
                    let input = &signal * (weight * sign);
                    m.row_mut(at + i).zip_apply(&input, |x, y| *x += y);
                    for j in 0..ORDER {
                        let entry = if i < j || (i - j) % 2 == 0 { -1.0 } else { 1.0 };
                        m[(at + i, at + j)] += weight * entry;
                    }
                }
                signal.fill(0.0);
                signal.columns_mut(at, ORDER).fill(1.0);
                at += ORDER;
            }
            if let Some((w, z)) = path.channel.lag {
                m[(at, at + 1)] = 1.0;
                let input = &signal * (w * w);
                m.row_mut(at + 1).zip_apply(&input, |x, y| *x += y);
                m[(at + 1, at)] -= w * w;
                m[(at + 1, at + 1)] -= 2.0 * z * w;
                signal.fill(0.0);
                signal[at] = 1.0;
                at += 2;
            }
            for i in 0..n {
                let input = &signal * path.b[i];
                m.row_mut(i).zip_apply(&input, |x, y| *x += y);
            }
        }
        m
    }

    /// Largest growth rate of the finite model, 1/s: a search's fast look.
    pub fn growth_of_finite_per_s(&self) -> f64 {
        let m = self.finite();
        let rounds = 200 * m.nrows();
        Schur::try_new(m, f64::EPSILON, rounds).map_or(f64::INFINITY, |schur| {
            schur
                .complex_eigenvalues()
                .iter()
                .map(|z| z.re)
                .fold(f64::NEG_INFINITY, f64::max)
        })
    }

    /// s I - A + Σ b k' H(s), and its derivative.
    fn matrix(&self, s: Complex<f64>) -> (DMatrix<Complex<f64>>, DMatrix<Complex<f64>>) {
        let n = self.a.nrows();
        let one = Complex::new(1.0, 0.0);
        let mut m = self.a.map(|x| Complex::new(-x, 0.0));
        let mut d = DMatrix::identity(n, n);
        for i in 0..n {
            m[(i, i)] += s * one;
        }
        for path in &self.paths {
            let (h, dh) = path.channel.transfer(s);
            for i in 0..n {
                for j in 0..n {
                    let bk = path.b[i] * path.k[j];
                    m[(i, j)] += h * bk;
                    d[(i, j)] += dh * bk;
                }
            }
        }
        (m, d)
    }

    /// The determinant whose roots are the eigenvalues.
    pub fn characteristic(&self, s: Complex<f64>) -> Complex<f64> {
        self.matrix(s).0.determinant()
    }

    /// Newton's method on the exact equation from `start`; `None` if it does not stay near.
    fn refined(&self, start: Complex<f64>) -> Option<Complex<f64>> {
        let mut s = start;
        for _ in 0..40 {
            let (m, d) = self.matrix(s);
            let trace = m.lu().solve(&d)?.trace();
            let poles: Complex<f64> = self.paths.iter().map(|p| p.channel.poles(s)).sum();
            let step = Complex::new(1.0, 0.0) / (trace + poles);
            if !(step.re.is_finite() && step.im.is_finite()) {
                // The matrix is singular to the last bit: a root.
                break;
            }
            s -= step;
            if step.norm_sqr() < 1e-24 * (1.0 + s.norm_sqr()) {
                break;
            }
        }
        let moved = libm::hypot(s.re - start.re, s.im - start.im);
        let near = moved < 0.2 * (1.0 + libm::hypot(start.re, start.im));
        near.then_some(s)
    }

    /// Eigenvalues, 1/s, those of upper half plane and real axis, fastest growth first. Those that
    /// decay faster than 6 1/s are left out.
    ///
    /// # Errors
    /// If the eigenvalues of the finite model are not found.
    pub fn eigenvalues(&self) -> Result<Vec<Complex<f64>>, MultibodyError> {
        let m = self.finite();
        let (order, iterations) = (m.nrows(), 1000 * m.nrows());
        let schur = Schur::try_new(m, f64::EPSILON, iterations).ok_or_else(|| {
            MultibodyError::Eigenvalues {
                message: format!(
                    "the eigenvalues of a rider's loop of order {order} were not found in {iterations} iterations"
                ),
            }
        })?;
        let mut roots: Vec<Complex<f64>> = schur
            .complex_eigenvalues()
            .iter()
            .filter(|z| z.im >= 0.0 && z.re > DEEPEST_PER_S)
            .map(|&z| self.refined(z).unwrap_or(z))
            .collect();
        roots.sort_by(|a, b| b.re.total_cmp(&a.re).then(a.im.total_cmp(&b.im)));
        Ok(roots)
    }
}

/// How a rider does on a bicycle at one speed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StabilityAt {
    /// Speed, m/s.
    pub speed_m_s: f64,
    /// Pair of motor torques, Nm.
    pub pair_nm: f64,
    /// Growth rate of the fastest growing mode, 1/s; negative: the bicycle stays up.
    pub growth_per_s: f64,
    /// Its frequency, rad/s; zero: it grows or dies out without swinging.
    pub frequency_rad_s: f64,
}

impl StabilityAt {
    /// The bicycle stays up.
    pub fn is_stable(&self) -> bool {
        self.growth_per_s < 0.0
    }
}

/// Does `rider` keep the bicycle of `model` up at these speeds, under a pair of `pair_nm`? Gains
/// are those of the rider at each speed; remnant and limits do not count.
///
/// # Errors
/// If there is no steady state at a speed.
///
/// ```
/// use twinhub_plant::multibody::{BulsinkBicycle, Case, Multibody, Parameters, Reading};
/// use twinhub_plant::rider::{closed_loop::stability, published};
///
/// let bicycle = Parameters::bulsink2017(BulsinkBicycle::One, Case::TyresRigid, &Reading::default());
/// let model = Multibody::new(&bicycle)?;
/// // The torque riders of table 6.2 do not keep this bicycle up at any speed.
/// for row in published::rows(published::Table::SteerTorque) {
///     let at = stability(&model, &row.rider(), 0.0, &[row.speed_m_s])?;
///     assert!(!at[0].is_stable());
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn stability(
    model: &Multibody,
    rider: &RiderFile,
    pair_nm: f64,
    speeds_m_s: &[f64],
) -> Result<Vec<StabilityAt>, MultibodyError> {
    speeds_m_s
        .iter()
        .map(|&speed_m_s| {
            let bicycle = LateralBicycle::new(model, speed_m_s, pair_nm)?;
            let roots = ClosedLoop::new(&bicycle, &rider.rider.linear(speed_m_s)).eigenvalues()?;
            let first = roots
                .first()
                .copied()
                .unwrap_or(Complex::new(DEEPEST_PER_S, 0.0));
            Ok(StabilityAt {
                speed_m_s,
                pair_nm,
                growth_per_s: first.re,
                frequency_rad_s: first.im,
            })
        })
        .collect()
}
