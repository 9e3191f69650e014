//! What: does V = x'P(v) x fall everywhere in a cell of speed, at every corner and edge?
//!
//! Equation: between two nodes P, b and c are linear in speed and A is the parabola through both ends
//! and the middle. -(d/dt)(x'P x) - |c x|² + |w|² is then a cubic in speed; in Bernstein's basis it is
//! positive if its four coefficients are:
//! M_j = [-(P A)_j - (P A)_j' -/+ r (P₁ - P₀) / h, -(P b)_j, -c_j'; ., 1, 0; ., ., 1] > 0 for both signs of
//! the rate r of speed. The pair may change as fast as it likes between the edges: P does not know
//! it. The bicycle does not change during a ride: P may be another one in every box.
//!
//! Source: Farouki (2012), Computer Aided Geometric Design 29(6), 379-419, for the basis; parameter
//! dependent quadratic Lyapunov functions: Gahinet, Apkarian and Chilali (1996), IEEE Trans. Automatic
//! Control 41(3), 436-442. Positive definite in spite of rounding: Rump (2006), BIT 46, 433-452.
//!
//! Assumes and ignores: between its corners a box is the mean of its corners; `check` measures how
//! far the bicycle is from that, and from the parabola.
//!
//! Valid for: finite matrices.
//!
//! Checked by: tests below; `tests/certificate.rs`.

use crate::loops::Loop;
use nalgebra::{Cholesky, DMatrix, DVector, RowDVector};

/// One corner and edge along a cell.
#[derive(Clone, Copy, Debug)]
pub struct Along<'a> {
    /// The loop at the first node.
    pub first: &'a Loop,
    /// Halfway.
    pub middle: &'a Loop,
    /// At the second node.
    pub second: &'a Loop,
}

/// Is the inequality proved along the cell, rounding included?
pub fn proved(along: &Along<'_>, p: [&DMatrix<f64>; 2], rate_m_s2: f64, cell_m_s: f64) -> bool {
    let scale = scaling(p[0], p[1]);
    let half = (&along.first.a + &along.second.a) * 0.5;
    // The middle coefficient of the parabola.
    let control = &half + (&along.middle.a - &half) * 2.0;
    let a = [&along.first.a, &control, &along.second.a];
    let pa = cubic(p, a);
    let pb = {
        let [b0, b1] = [&along.first.b, &along.second.b];
        let ends = [p[0] * b0, p[1] * b1];
        let mixed = (p[0] * b1 + p[1] * b0) * 0.5;
        let [e0, e1] = ends;
        [
            e0.clone(),
            (&e0 + &mixed * 2.0) / 3.0,
            (&mixed * 2.0 + &e1) / 3.0,
            e1,
        ]
    };
    let drift = (p[1] - p[0]) * (rate_m_s2 / cell_m_s);
    let ends = [along.first, along.second];
    let input = |l: &Loop| {
        let entries = l.b.iter().zip(&scale).map(|(b, s)| (b / s) * (b / s));
        libm::sqrt(entries.sum::<f64>())
    };
    let bound = |l: &Loop| {
        let entries = l.c.iter().zip(&scale).map(|(c, s)| (c * s) * (c * s));
        libm::sqrt(entries.sum::<f64>())
    };
    let largest = |values: &mut dyn Iterator<Item = f64>| values.fold(0.0, f64::max);
    let rates = largest(&mut a.iter().map(|a| mixed_norm(a, &scale)))
        + largest(&mut ends.iter().map(|l| input(l)))
        + 2.0 * rate_m_s2 / cell_m_s;
    let size = norm(p[0], &scale).max(norm(p[1], &scale)) * rates
        + largest(&mut ends.iter().map(|l| bound(l)));
    (0..4).all(|j| {
        let share = j as f64 / 3.0;
        let c = &along.first.c * (1.0 - share) + &along.second.c * share;
        [1.0, -1.0].iter().all(|sign| {
            let m = assemble(&pa[j], &pb[j], &c, &(&drift * *sign), &scale);
            positive(&m, size)
        })
    }) && positive(&scaled(p[0], &scale), 1.0)
        && positive(&scaled(p[1], &scale), 1.0)
}

/// Bernstein coefficients of P A, P linear and A a parabola.
fn cubic(p: [&DMatrix<f64>; 2], a: [&DMatrix<f64>; 3]) -> [DMatrix<f64>; 4] {
    [
        p[0] * a[0],
        (p[1] * a[0] + p[0] * a[1] * 2.0) / 3.0,
        (p[1] * a[1] * 2.0 + p[0] * a[2]) / 3.0,
        p[1] * a[2],
    ]
}

/// Powers of two that bring the diagonal of P near one: exact in floating point.
fn scaling(p0: &DMatrix<f64>, p1: &DMatrix<f64>) -> Vec<f64> {
    (0..p0.nrows())
        .map(|i| {
            let size = (p0[(i, i)].abs() + p1[(i, i)].abs()).max(f64::MIN_POSITIVE);
            libm::exp2(libm::round(-0.5 * libm::log2(size)))
        })
        .collect()
}

fn scaled(p: &DMatrix<f64>, scale: &[f64]) -> DMatrix<f64> {
    DMatrix::from_fn(p.nrows(), p.ncols(), |i, j| p[(i, j)] * scale[i] * scale[j])
}

fn norm(p: &DMatrix<f64>, scale: &[f64]) -> f64 {
    scaled(p, scale).norm()
}

/// Size of A in scaled coordinates: |S⁻¹ A S|.
fn mixed_norm(a: &DMatrix<f64>, scale: &[f64]) -> f64 {
    DMatrix::from_fn(a.nrows(), a.ncols(), |i, j| a[(i, j)] / scale[i] * scale[j]).norm()
}

fn assemble(
    pa: &DMatrix<f64>,
    pb: &DVector<f64>,
    c: &RowDVector<f64>,
    drift: &DMatrix<f64>,
    scale: &[f64],
) -> DMatrix<f64> {
    let n = pa.nrows();
    let mut m = DMatrix::identity(n + 2, n + 2);
    for i in 0..n {
        for j in 0..n {
            m[(i, j)] = -(pa[(i, j)] + pa[(j, i)] + drift[(i, j)]) * scale[i] * scale[j];
        }
        m[(i, n)] = -pb[i] * scale[i];
        m[(n, i)] = m[(i, n)];
        m[(i, n + 1)] = -c[i] * scale[i];
        m[(n + 1, i)] = m[(i, n + 1)];
    }
    m
}

/// Is `m`, whose entries are sums of products of total size `size`, positive definite whatever the
/// rounding? Cholesky's factor of m - δ I exists with δ above all that rounding can have done.
pub fn positive(m: &DMatrix<f64>, size: f64) -> bool {
    let n = m.nrows() as f64;
    let unit = f64::EPSILON;
    let formed = 8.0 * (n + 16.0) * unit * size;
    let factored =
        2.0 * (n + 1.0) * (n + 2.0) * unit * m.diagonal().iter().map(|d| d.abs()).sum::<f64>();
    let mut shifted = m.clone();
    for i in 0..m.nrows() {
        shifted[(i, i)] -= formed + factored;
    }
    shifted.iter().all(|x| x.is_finite()) && Cholesky::new(shifted).is_some()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scalar(a: f64, b: f64, c: f64) -> Loop {
        Loop {
            a: DMatrix::from_element(1, 1, a),
            b: DVector::from_element(1, b),
            c: RowDVector::from_element(1, c),
        }
    }

    fn along(a: [f64; 3], b: f64, c: f64, p: [&DMatrix<f64>; 2], rate_m_s2: f64) -> bool {
        let [first, middle, second] = &a.map(|a| scalar(a, b, c));
        let along = Along {
            first,
            middle,
            second,
        };
        proved(&along, p, rate_m_s2, 1.0)
    }

    #[test]
    fn a_scalar_loop_is_proved_up_to_its_own_limit() {
        // x' = -a x + w, |w| <= |c x|: falls with P = c iff a > c.
        let p = DMatrix::from_element(1, 1, 1.0);
        let steady = |a: f64| along([-a; 3], 1.0, 1.0, [&p, &p], 0.0);
        assert!(steady(1.0 + 1e-9));
        assert!(!steady(1.0 - 1e-9));
        assert!(!steady(1.0), "on the limit nothing is proved");
    }

    #[test]
    fn a_bump_between_the_nodes_is_seen() {
        let p = DMatrix::from_element(1, 1, 1.0);
        assert!(along([-2.0; 3], 0.1, 0.1, [&p, &p], 0.0));
        assert!(!along([-2.0, 0.5, -2.0], 0.1, 0.1, [&p, &p], 0.0));
    }

    #[test]
    fn the_rate_of_speed_counts_in_both_directions() {
        let (p, q) = (
            DMatrix::from_element(1, 1, 1.0),
            DMatrix::from_element(1, 1, 2.0),
        );
        let ok = |rate: f64, p: [&DMatrix<f64>; 2]| along([-1.0; 3], 0.1, 0.1, p, rate);
        // V' = (-2 p ± r dp/dv) x²: p from 1 to 2 over 1 m/s.
        assert!(ok(1.9, [&p, &q]) && !ok(2.1, [&p, &q]));
        assert!(ok(1.9, [&q, &p]) && !ok(2.1, [&q, &p]));
    }

    #[test]
    fn rounding_cannot_prove_what_is_not_so() {
        let m = DMatrix::from_row_slice(2, 2, &[1.0, 1.0, 1.0, 1.0 + 1e-15]);
        assert!(!positive(&m, 1.0));
        let m = DMatrix::from_row_slice(2, 2, &[1.0, 1.0, 1.0, 1.0 + 1e-9]);
        assert!(positive(&m, 1.0));
    }
}
