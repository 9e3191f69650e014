//! What: the speeds at which the benchmark bicycle gains or loses stability, exactly.
//!
//! Equation: with the characteristic polynomial a4 s^4 + .. + a0, a real eigenvalue crosses zero
//! where a0 = det K = 0; an oscillation does where the Routh-Hurwitz determinant
//! a3 a2 a1 - a4 a1² - a0 a3² = 0 with a1/a3 > 0. The damping goes with v and the stiffness with v²,
//! so a0, and the determinant divided by v², are quadratic in v²: their roots are found in closed
//! form, in double-double.
//!
//! Checked by: weave and capsize speed of Meijaard et al. (2007), table 2, to 1e-13.

use crate::canonical::Canonical;
use crate::double_double::Double;
use crate::motor_pair::MotorPair;
use crate::quartic;

/// How an eigenvalue crosses the imaginary axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Crossing {
    /// A real one through zero.
    Divergence,
    /// A conjugate pair.
    Oscillation,
}

/// Polynomials in v² (constant first): products by convolution.
fn times(a: &[Double], b: &[Double]) -> Vec<Double> {
    let mut p = vec![Double::new(0.0); a.len() + b.len() - 1];
    for (i, x) in a.iter().enumerate() {
        for (j, y) in b.iter().enumerate() {
            p[i + j] = p[i + j] + *x * *y;
        }
    }
    p
}

fn minus(a: &[Double], b: &[Double]) -> Vec<Double> {
    let at = |p: &[Double], i: usize| p.get(i).copied().unwrap_or(Double::new(0.0));
    (0..a.len().max(b.len()))
        .map(|i| at(a, i) - at(b, i))
        .collect()
}

/// Positive roots of a polynomial in v², as speeds.
fn speeds(mut p: Vec<Double>) -> Vec<f64> {
    let top = p.iter().map(|c| c.value().abs()).fold(0.0, f64::max);
    while p.len() > 1 && p.last().is_some_and(|c| c.value().abs() <= 1e-15 * top) {
        p.pop();
    }
    if p.len() < 2 {
        return Vec::new();
    }
    quartic::roots(&p)
        .iter()
        .filter(|s| s.im == 0.0 && s.re > 0.0)
        .map(|s| libm::sqrt(s.re))
        .collect()
}

impl Canonical {
    /// All speeds above zero at which an eigenvalue crosses the imaginary axis, ascending.
    pub fn critical_speeds_m_s(&self, pair: MotorPair) -> Vec<(f64, Crossing)> {
        if self.damping(0.0) != nalgebra::Matrix2::zeros() {
            return self.scanned_critical_speeds_m_s(pair);
        }
        let (m, c1, k2) = (self.mass(), self.c1(), self.k2());
        let k = self.stiffness(0.0, pair);
        // det(M s² + v C1 s + K + v² K2): coefficients as polynomials in v², a1 and a3 less one v.
        let term = |x: f64, y: f64| Double::new(x) * Double::new(y);
        let det = |a: &nalgebra::Matrix2<f64>, b: &nalgebra::Matrix2<f64>| {
            term(a[(0, 0)], b[(1, 1)]) - term(a[(0, 1)], b[(1, 0)])
        };
        let mixed = |a: &nalgebra::Matrix2<f64>, b: &nalgebra::Matrix2<f64>| det(a, b) + det(b, a);
        let a4 = [det(&m, &m)];
        let a3 = [mixed(&m, &c1)];
        let a2 = [mixed(&m, &k), mixed(&m, &k2) + det(&c1, &c1)];
        let a1 = [mixed(&c1, &k), mixed(&c1, &k2)];
        let a0 = [det(&k, &k), mixed(&k, &k2), det(&k2, &k2)];
        let hurwitz = minus(
            &minus(&times(&times(&a3, &a2), &a1), &times(&a4, &times(&a1, &a1))),
            &times(&a0, &times(&a3, &a3)),
        );
        let mut all: Vec<_> = speeds(a0.to_vec())
            .into_iter()
            .map(|v| (v, Crossing::Divergence))
            .collect();
        let frequency_squared = |v: f64| (a1[0].value() + a1[1].value() * v * v) / a3[0].value();
        all.extend(
            speeds(hurwitz)
                .into_iter()
                .filter(|v| frequency_squared(*v) > 0.0)
                .map(|v| (v, Crossing::Oscillation)),
        );
        all.sort_by(|a, b| a.0.total_cmp(&b.0));
        all
    }

    /// The same with damping at standstill, where the coefficients are no polynomials in v²: sign
    /// changes of the last coefficient and of Hurwitz's determinant on a grid, then bisection.
    fn scanned_critical_speeds_m_s(&self, pair: MotorPair) -> Vec<(f64, Crossing)> {
        const FASTEST_M_S: f64 = 60.0;
        const STEPS: u32 = 6000;
        let coefficients = |v: f64| {
            let (m, c, k) = (self.mass(), self.damping(v), self.stiffness(v, pair));
            let det = |a: &nalgebra::Matrix2<f64>, b: &nalgebra::Matrix2<f64>| {
                a[(0, 0)] * b[(1, 1)] - a[(0, 1)] * b[(1, 0)]
            };
            let mixed =
                |a: &nalgebra::Matrix2<f64>, b: &nalgebra::Matrix2<f64>| det(a, b) + det(b, a);
            [
                det(&m, &m),
                mixed(&m, &c),
                mixed(&m, &k) + det(&c, &c),
                mixed(&c, &k),
                det(&k, &k),
            ]
        };
        let divergence = |v: f64| coefficients(v)[4];
        let oscillation = |v: f64| {
            let [a4, a3, a2, a1, a0] = coefficients(v);
            a1 * (a2 * a3 - a1 * a4) - a0 * a3 * a3
        };
        let mut all = vec![];
        let mut scan = |f: &dyn Fn(f64) -> f64, kind: Crossing| {
            let at = |k: u32| FASTEST_M_S * f64::from(k) / f64::from(STEPS);
            for k in 0..STEPS {
                let (mut low, mut high) = (at(k), at(k + 1));
                if f(low).signum() == f(high).signum() {
                    continue;
                }
                for _ in 0..60 {
                    let middle = 0.5 * (low + high);
                    if f(middle).signum() == f(low).signum() {
                        low = middle;
                    } else {
                        high = middle;
                    }
                }
                let v = 0.5 * (low + high);
                let [_, a3, _, a1, _] = coefficients(v);
                if v > 0.0 && (kind == Crossing::Divergence || a1 / a3 > 0.0) {
                    all.push((v, kind));
                }
            }
        };
        scan(&divergence, Crossing::Divergence);
        scan(&oscillation, Crossing::Oscillation);
        all.sort_by(|a, b| a.0.total_cmp(&b.0));
        all
    }
}
