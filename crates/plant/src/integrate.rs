//! Fixed-step integration.

// Loops run over components of several vectors at once.
#![allow(clippy::needless_range_loop)]

use crate::scalar::Scalar;

/// One step of the classical fourth-order Runge-Kutta method.
///
/// `rhs(x, dx)` writes the derivative of `x` into `dx`; `step_s` is the step in seconds. Local
/// error is of order `step_s`⁵ for a smooth right-hand side.
///
/// Source: Hairer, Nørsett and Wanner (1993), Solving Ordinary Differential Equations I, table 1.2.
#[inline]
pub fn rk4<T: Scalar, const N: usize>(
    x: &mut [T; N],
    step_s: f64,
    mut rhs: impl FnMut(&[T; N], &mut [T; N]),
) {
    let zero = T::from_f64(0.0);
    let (half, full) = (T::from_f64(0.5 * step_s), T::from_f64(step_s));
    let (sixth, two) = (T::from_f64(step_s / 6.0), T::from_f64(2.0));
    let mut k1 = [zero; N];
    let mut k2 = [zero; N];
    let mut k3 = [zero; N];
    let mut k4 = [zero; N];
    rhs(x, &mut k1);
    let y: [T; N] = core::array::from_fn(|i| x[i] + half * k1[i]);
    rhs(&y, &mut k2);
    let y: [T; N] = core::array::from_fn(|i| x[i] + half * k2[i]);
    rhs(&y, &mut k3);
    let y: [T; N] = core::array::from_fn(|i| x[i] + full * k3[i]);
    rhs(&y, &mut k4);
    for i in 0..N {
        x[i] += sixth * (k1[i] + two * (k2[i] + k3[i]) + k4[i]);
    }
}

/// How a component that decays towards its own rest, x' = -rate x + ..., goes through a step.
#[derive(Clone, Copy, Debug)]
pub struct Decay<T> {
    rate: T,
    /// Half a step, shortened: h/2 φ1(-rate h/2).
    half: T,
    /// Weights of the first, the two middle and the last slope.
    first: T,
    middle: T,
    last: T,
}

impl<T: Scalar> Decay<T> {
    /// Of a component with this rate, at least zero, 1/s, over a step of `step_s`.
    #[inline(always)]
    pub fn new(rate: T, step_s: f64) -> Self {
        let one = T::one();
        let [e, p1, p2, p3] = phi(-rate.scale(0.5 * step_s));
        // From half the step to all of it: 2^k φk(2z) = e^z φk(z) + Σ φj(z) / (k-j)!, j = 1 to k.
        let q1 = ((e + one) * p1).scale(0.5);
        let q2 = ((e + one) * p2 + p1).scale(0.25);
        let q3 = ((e + one) * p3 + p2 + p1.scale(0.5)).scale(0.125);
        Self {
            rate,
            half: p1.scale(0.5 * step_s),
            first: (q1 - q2.scale(3.0) + q3.scale(4.0)).scale(step_s),
            middle: (q2 - q3.scale(2.0)).scale(2.0 * step_s),
            last: (q3.scale(4.0) - q2).scale(step_s),
        }
    }
}

/// e^z and φ1, φ2, φ3 for z ≤ 0: φ0 = e^z, φk = z φ(k+1) + 1/k!. Downwards from the series of φ3
/// near zero, upwards beyond, where nothing cancels.
#[inline(always)]
fn phi<T: Scalar>(z: T) -> [T; 4] {
    let one = T::one();
    let far = -one - z;
    let near = z.max(-one);
    let mut n3 = T::zero();
    for k in (3..=15).rev() {
        n3 = (n3 * near + one).scale(1.0 / k as f64);
    }
    let n3 = n3.scale(0.5);
    let n2 = near * n3 + T::from_f64(0.5);
    let n1 = near * n2 + one;
    let away = z.min(-one);
    let e = away.exp();
    let inverse = one / away;
    let f1 = (e - one) * inverse;
    let f2 = (f1 - one) * inverse;
    let f3 = (f2 - T::from_f64(0.5)) * inverse;
    [
        far.select(e, near * n1 + one),
        far.select(f1, n1),
        far.select(f2, n2),
        far.select(f3, n3),
    ]
}

/// One step of the exponential Runge-Kutta method of fourth order of Cox and Matthews, in which the
/// components from `at` on decay at given rates: that part of their slope is integrated exactly, so
/// that it may be as fast as it likes. All others go as in [`rk4`], as do these where the rate is
/// zero. `slope` is the derivative of `x`.
///
/// With f the derivative and λ the rate, a stage at y has the slope f(y) + λ (y - x). A true rate
/// between zero and twice λ is stable at any step.
///
/// Source: Cox and Matthews (2002), Exponential time differencing for stiff systems, Journal of
/// Computational Physics 176, equations 26 to 29.
#[inline(always)]
pub fn rk4_decaying<T: Scalar, const N: usize, const M: usize>(
    x: &mut [T; N],
    step_s: f64,
    at: usize,
    decays: &[Decay<T>; M],
    slope: &[T; N],
    mut rhs: impl FnMut(&[T; N], &mut [T; N]),
) {
    let (half, full) = (T::from_f64(0.5 * step_s), T::from_f64(step_s));
    let (sixth, two) = (T::from_f64(step_s / 6.0), T::from_f64(2.0));
    let k1 = slope;
    let (mut k2, mut k3, mut k4) = ([T::zero(); N], [T::zero(); N], [T::zero(); N]);
    let (mut a, mut y) = ([T::zero(); N], [T::zero(); N]);
    for i in 0..N {
        a[i] = x[i] + half * k1[i];
    }
    for (i, d) in (at..).zip(decays) {
        a[i] = x[i] + d.half * k1[i];
    }
    rhs(&a, &mut k2);
    for (i, d) in (at..).zip(decays) {
        k2[i] += d.rate * (a[i] - x[i]);
    }
    for i in 0..N {
        y[i] = x[i] + half * k2[i];
    }
    for (i, d) in (at..).zip(decays) {
        y[i] = x[i] + d.half * k2[i];
    }
    rhs(&y, &mut k3);
    for (i, d) in (at..).zip(decays) {
        k3[i] += d.rate * (y[i] - x[i]);
    }
    for i in 0..N {
        y[i] = x[i] + full * k3[i];
    }
    for (i, d) in (at..).zip(decays) {
        y[i] = a[i] + d.half * (two * k3[i] - k1[i] - d.rate * (a[i] - x[i]));
    }
    rhs(&y, &mut k4);
    for (i, d) in (at..).zip(decays) {
        k4[i] += d.rate * (y[i] - x[i]);
    }
    let mut start = [T::zero(); M];
    start.copy_from_slice(&x[at..at + M]);
    for i in 0..N {
        x[i] += sixth * (k1[i] + two * (k2[i] + k3[i]) + k4[i]);
    }
    for ((i, d), x0) in (at..).zip(decays).zip(start) {
        x[i] = x0 + d.first * k1[i] + d.middle * (k2[i] + k3[i]) + d.last * k4[i];
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn halving_the_step_divides_the_error_by_sixteen() {
        let error = |steps: usize| {
            let mut x = [1.0, 0.0];
            for _ in 0..steps {
                rk4(&mut x, 1.0 / steps as f64, |x, dx| *dx = [x[1], -x[0]]);
            }
            (x[0] - libm::cos(1.0)).hypot(x[1] + libm::sin(1.0))
        };
        let order = libm::log2(error(50) / error(100));
        assert!((order - 4.0).abs() < 0.1, "order {order}");
    }

    /// x0 decays fast towards a curve that x1, an oscillator, drives; x2 is the oscillator's rate.
    fn stiff(rate: f64) -> impl Fn(&[f64; 3], &mut [f64; 3]) {
        move |x, dx| {
            *dx = [
                -rate * (x[0] - x[1]) - 0.1 * x[0] * x[0],
                x[2],
                -x[1] + 0.01 * x[0],
            ]
        }
    }

    fn ridden(rate: f64, known: f64, steps: usize) -> [f64; 3] {
        let (mut x, h) = ([0.9, 1.0, 0.0], 1.0 / steps as f64);
        let f = stiff(rate);
        for _ in 0..steps {
            let mut slope = [0.0; 3];
            f(&x, &mut slope);
            rk4_decaying(&mut x, h, 0, &[Decay::new(known, h)], &slope, &f);
        }
        x
    }

    #[test]
    fn a_decaying_component_keeps_the_fourth_order() {
        // The rate that the method is told is not quite the true one.
        let exact = ridden(30.0, 27.0, 20_000);
        let error = |n: usize| (ridden(30.0, 27.0, n)[0] - exact[0]).abs();
        let order = libm::log2(error(80) / error(160));
        assert!((order - 4.0).abs() < 0.25, "order {order}");
    }

    #[test]
    fn a_fast_decay_is_stable_at_any_step() {
        for known in [3.0e4, 5.0e4, 1.0e5] {
            // A rate of 5e4 at steps of 0.01: five hundred times past the limit of rk4.
            let x = ridden(5.0e4, known, 100);
            assert!((x[0] - x[1]).abs() < 0.02, "{known}: {x:?}");
        }
    }

    #[test]
    fn without_decay_it_is_the_classical_method() {
        let (mut x, mut y) = ([0.9, 1.0, 0.0], [0.9, 1.0, 0.0]);
        for _ in 0..50 {
            let mut slope = [0.0; 3];
            stiff(3.0)(&x, &mut slope);
            rk4_decaying(
                &mut x,
                0.02,
                0,
                &[Decay::new(0.0, 0.02)],
                &slope,
                stiff(3.0),
            );
            rk4(&mut y, 0.02, stiff(3.0));
        }
        for (a, b) in x.iter().zip(y) {
            assert!((a - b).abs() < 1.0e-14, "{a} {b}");
        }
    }
}
