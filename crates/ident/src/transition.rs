//! What: one exact step of x' = A x + b0 + b1 s + noise over 0 <= s <= h, with A constant in it.
//!
//! Equation: Phi = exp(A h); d = integral of exp(A (h - s)) (b0 + b1 s) ds;
//! Q_i = integral of exp(A s) g_i g_i' exp(A' s) ds for each noise source g_i of unit intensity.
//!
//! Source: C. F. Van Loan, "Computing integrals involving the matrix exponential", IEEE Trans.
//! Automatic Control 23 (1978); the exponential by its Taylor series after halving the step until
//! the norm of A h is below one half, which is cheap for the few states here.
//!
//! Assumes and ignores: A constant within the step. With a speed that varies, the caller takes A
//! at the middle of the step (the exponential midpoint rule, error of third order in h).
//!
//! Valid for: any A h of finite norm.
//!
//! Checked by: the unit tests below, against closed forms (relative error below 1e-12) and, for
//! the whole step, against a fine RK4 in `tests`.

use crate::dense::{mul, mul_vec};

/// Terms of the Taylor series: with a norm of at most 1/2 the rest is below 1e-17.
const TERMS: usize = 14;
const MAX_HALVINGS: u32 = 40;

/// Nodes and weights of Gauss and Legendre on [0, 1], four points: exact to the seventh degree.
const GAUSS: [(f64, f64); 4] = [
    (0.069_431_844_202_973_71, 0.173_927_422_568_726_93),
    (0.330_009_478_207_571_87, 0.326_072_577_431_273_07),
    (0.669_990_521_792_428_1, 0.326_072_577_431_273_07),
    (0.930_568_155_797_026_3, 0.173_927_422_568_726_93),
];

fn norm(a: &[f64], n: usize) -> f64 {
    a.chunks_exact(n)
        .map(|row| row.iter().map(|x| x.abs()).sum::<f64>())
        .fold(0.0, f64::max)
}

/// Halvings that bring the norm of `a h` below one half.
fn halvings(a: &[f64], n: usize, h: f64) -> u32 {
    let mut size = norm(a, n) * h;
    let mut count = 0;
    while size > 0.5 && count < MAX_HALVINGS {
        size *= 0.5;
        count += 1;
    }
    count
}

/// exp(a h), row-major.
pub fn exponential(a: &[f64], n: usize, h: f64) -> Vec<f64> {
    let count = halvings(a, n, h);
    let h = h / (1u64 << count) as f64;
    let mut sum = vec![0.0; n * n];
    let mut term = vec![0.0; n * n];
    let mut next = vec![0.0; n * n];
    for i in 0..n {
        sum[i * n + i] = 1.0;
        term[i * n + i] = 1.0;
    }
    for k in 1..=TERMS {
        mul(&mut next, a, &term, n, n, n);
        let factor = h / k as f64;
        for ((t, x), s) in term.iter_mut().zip(&next).zip(sum.iter_mut()) {
            *t = x * factor;
            *s += *t;
        }
    }
    for _ in 0..count {
        mul(&mut next, &sum, &sum, n, n, n);
        std::mem::swap(&mut sum, &mut next);
    }
    sum
}

/// The response from rest to the input `b0 + b1 s` over a step `h`.
pub fn response(a: &[f64], n: usize, b0: &[f64], b1: &[f64], h: f64) -> Vec<f64> {
    let count = halvings(a, n, h);
    let parts = 1u64 << count;
    let part = h / parts as f64;
    let mut x = vec![0.0; n];
    let mut term = vec![0.0; n];
    let mut next = vec![0.0; n];
    for index in 0..parts {
        let start = index as f64 * part;
        // Taylor coefficients of the solution: c1 = A x + b, c2 = (A c1 + b1) / 2, ...
        mul_vec(&mut term, a, &x);
        for ((t, u), slope) in term.iter_mut().zip(b0).zip(b1) {
            *t = (*t + u + slope * start) * part;
        }
        for (s, t) in x.iter_mut().zip(&term) {
            *s += t;
        }
        for k in 2..=TERMS + 1 {
            mul_vec(&mut next, a, &term);
            let factor = part / k as f64;
            for ((t, y), slope) in term.iter_mut().zip(&next).zip(b1) {
                *t = y * factor
                    + if k == 2 {
                        slope * part * part * 0.5
                    } else {
                        0.0
                    };
            }
            for (s, t) in x.iter_mut().zip(&term) {
                *s += t;
            }
        }
    }
    x
}

/// The covariance that white noise of unit intensity through `g` leaves after `h`, row-major.
pub fn noise(a: &[f64], n: usize, g: &[f64], h: f64) -> Vec<f64> {
    let count = halvings(a, n, h).min(12);
    let parts = 1u32 << count;
    let part = h / f64::from(parts);
    let mut q = vec![0.0; n * n];
    for index in 0..parts {
        for (node, weight) in GAUSS {
            let s = (f64::from(index) + node) * part;
            // exp(A s) g by its Taylor series in pieces of norm below one half.
            let v = flow(a, n, g, s);
            for i in 0..n {
                let factor = weight * part * v[i];
                if factor != 0.0 {
                    for j in 0..n {
                        q[i * n + j] += factor * v[j];
                    }
                }
            }
        }
    }
    q
}

/// exp(a s) g.
fn flow(a: &[f64], n: usize, g: &[f64], s: f64) -> Vec<f64> {
    let count = halvings(a, n, s);
    let parts = 1u64 << count;
    let part = s / parts as f64;
    let mut x = g.to_vec();
    let mut term = vec![0.0; n];
    let mut next = vec![0.0; n];
    for _ in 0..parts {
        term.copy_from_slice(&x);
        for k in 1..=TERMS {
            mul_vec(&mut next, a, &term);
            let factor = part / k as f64;
            for ((t, y), s) in term.iter_mut().zip(&next).zip(x.iter_mut()) {
                *t = y * factor;
                *s += *t;
            }
        }
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A double integrator and a first-order lag have closed forms.
    #[test]
    fn double_integrator() {
        let a = [0.0, 1.0, 0.0, 0.0];
        let h = 0.7;
        assert_eq!(exponential(&a, 2, h), [1.0, h, 0.0, 1.0]);
        let d = response(&a, 2, &[0.0, 2.0], &[0.0, 3.0], h);
        assert!((d[0] - (h * h + 0.5 * h * h * h)).abs() < 1e-14);
        assert!((d[1] - (2.0 * h + 1.5 * h * h)).abs() < 1e-14);
        let q = noise(&a, 2, &[0.0, 1.0], h);
        for (found, exact) in q.iter().zip([h * h * h / 3.0, h * h / 2.0, h * h / 2.0, h]) {
            assert!((found - exact).abs() < 1e-14, "{found} {exact}");
        }
    }

    #[test]
    fn stiff_lag() {
        // Norm of A h is 40: the halvings must work.
        let (rate, h) = (80.0, 0.5);
        let a = [-rate];
        assert!((exponential(&a, 1, h)[0] - libm::exp(-rate * h)).abs() < 1e-16);
        let d = response(&a, 1, &[rate], &[0.0], h)[0];
        assert!((d - (1.0 - libm::exp(-rate * h))).abs() < 1e-13, "{d}");
        let q = noise(&a, 1, &[1.0], h)[0];
        assert!((q - 0.5 / rate).abs() < 1e-9 * 0.5 / rate, "{q}");
    }
}
