//! What: the roots of det(M s² + C s + K) = 0 of two coordinates, to full accuracy.
//!
//! Equation: the determinant is expanded exactly (double-double) to a quartic; all roots at once by
//! the iteration of Ehrlich (1967) and Aberth (1973), the last steps with residuals in
//! double-double.
//!
//! Valid for: finite matrices with det M away from zero. A root is accurate to rounding unless
//! another is nearer than about 1e-8 of its size.
//!
//! Checked by: table 2 of Meijaard et al. (2007), 1e-12 relative + 2e-14; random polynomials with
//! known roots.

use crate::double_double::{Double, horner, product};
use nalgebra::{Complex, Matrix2};

/// Coefficients of the characteristic polynomial, constant first.
pub(crate) fn characteristic(m: &Matrix2<f64>, c: &Matrix2<f64>, k: &Matrix2<f64>) -> [Double; 5] {
    let entry = |i, j| [k[(i, j)], c[(i, j)], m[(i, j)]];
    let mut p = [Double::new(0.0); 5];
    let mut add = |a: [f64; 3], b: [f64; 3], sign: f64| {
        for (i, x) in a.iter().enumerate() {
            for (j, y) in b.iter().enumerate() {
                p[i + j] = p[i + j] + product(*x, sign * y);
            }
        }
    };
    add(entry(0, 0), entry(1, 1), 1.0);
    add(entry(0, 1), entry(1, 0), -1.0);
    p
}

fn size(z: Complex<f64>) -> f64 {
    libm::hypot(z.re, z.im)
}

/// p and p' in plain arithmetic.
fn plain(p: &[Double], z: Complex<f64>) -> (Complex<f64>, Complex<f64>) {
    let zero = Complex::new(0.0, 0.0);
    p.iter()
        .rev()
        .fold((zero, zero), |(f, d), c| (f * z + c.hi, d * z + f))
}

/// One sweep of the simultaneous iteration; gives the largest relative step.
fn sweep(p: &[Double], roots: &mut [Complex<f64>], exact: bool) -> f64 {
    let mut largest: f64 = 0.0;
    for i in 0..roots.len() {
        let z = roots[i];
        let (f, d) = plain(p, z);
        let f = if exact { horner(p, z) } else { f };
        if f == Complex::new(0.0, 0.0) {
            continue;
        }
        let repel: Complex<f64> = (0..roots.len())
            .filter(|j| *j != i && roots[*j] != z)
            .map(|j| Complex::new(1.0, 0.0) / (z - roots[j]))
            .sum();
        // f / (d - f repel): Newton's step f/d, repelled by the other roots.
        let step = f / (d - f * repel);
        if !(step.re.is_finite() && step.im.is_finite()) {
            continue;
        }
        roots[i] = z - step;
        largest = largest.max(size(step) / size(z).max(f64::MIN_POSITIVE));
    }
    largest
}

/// Roots of a real polynomial (constant first, at most degree 4): conjugates exactly paired, reals
/// with imaginary part exactly zero, sorted by real part, then imaginary part.
pub(crate) fn roots(p: &[Double]) -> Vec<Complex<f64>> {
    let zeros = p.iter().take_while(|c| c.value() == 0.0).count();
    let mut done = vec![Complex::new(0.0, 0.0); zeros.min(p.len() - 1)];
    let p = &p[done.len()..];
    let degree = p.len() - 1;
    // Start on a circle of the geometric mean radius, off the axes of symmetry.
    let radius = if degree == 0 {
        0.0
    } else {
        libm::pow(
            (p[0].value() / p[degree].value()).abs(),
            1.0 / degree as f64,
        )
    };
    let mut z: Vec<_> = (0..degree)
        .map(|k| {
            let (sin, cos) = libm::sincos(0.7 + core::f64::consts::TAU * k as f64 / degree as f64);
            Complex::new(radius * cos, radius * sin)
        })
        .collect();
    for _ in 0..200 {
        if sweep(p, &mut z, false) < 1e-12 {
            break;
        }
    }
    for _ in 0..4 {
        sweep(p, &mut z, true);
    }
    // Pair conjugates; what has no partner is real.
    while let Some(a) = z.pop() {
        let partner = z
            .iter()
            .enumerate()
            .map(|(i, b)| (i, size(*b - a.conj())))
            .min_by(|x, y| x.1.total_cmp(&y.1))
            .filter(|(_, distance)| a.im.abs() > 1e-13 * size(a) && *distance < a.im.abs());
        if let Some((i, _)) = partner {
            let b = z.swap_remove(i);
            let mean = Complex::new(0.5 * (a.re + b.re), 0.5 * (a.im - b.im).abs());
            done.extend([mean, mean.conj()]);
        } else {
            let mut real = [Complex::new(a.re, 0.0)];
            for _ in 0..2 {
                let x = real[0];
                let (_, d) = plain(p, x);
                let step = horner(p, x).re / d.re;
                // Only refine: a long step would leave this root for another.
                if step.is_finite() && step.abs() < 1e-7 * size(x) {
                    real[0].re -= step;
                }
            }
            done.push(real[0]);
        }
    }
    done.sort_by(|a, b| a.re.total_cmp(&b.re).then(a.im.total_cmp(&b.im)));
    done
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn expand(roots: &[Complex<f64>]) -> Vec<Double> {
        let mut p = vec![Complex::new(1.0, 0.0)];
        for r in roots {
            let mut q = vec![Complex::new(0.0, 0.0); p.len() + 1];
            for (i, c) in p.iter().enumerate() {
                q[i + 1] += c;
                q[i] -= c * r;
            }
            p = q;
        }
        p.iter().map(|c| Double::new(c.re)).collect()
    }

    fn check(mut want: Vec<Complex<f64>>, tolerance: f64) {
        want.sort_by(|a, b| a.re.total_cmp(&b.re).then(a.im.total_cmp(&b.im)));
        let got = roots(&expand(&want));
        assert_eq!(got.len(), want.len());
        for (g, w) in got.iter().zip(&want) {
            assert!(
                size(g - w) <= tolerance * (1.0 + size(*w)),
                "{got:?} {want:?}"
            );
        }
    }

    #[test]
    fn zero_and_double_roots() {
        let r = |re: f64| Complex::new(re, 0.0);
        check(vec![r(0.0), r(0.0), r(-1.0), r(-2.0)], 1e-14);
        check(vec![r(3.0), r(3.0), r(-1.0), r(-7.0)], 1e-6);
        check(vec![r(1e-9), r(1.0), r(-1.0), r(-20.0)], 1e-13);
    }

    proptest! {
        #[test]
        fn known_roots_come_back(a in -30.0..5.0_f64, b in 0.3..12.0_f64, c in -30.0..-5.1_f64, d in 5.5..9.0_f64) {
            check(vec![Complex::new(a, b), Complex::new(a, -b), Complex::new(c, 0.0), Complex::new(d, 0.0)], 1e-11);
        }
    }
}
