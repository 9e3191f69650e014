//! What: the best Lyapunov matrix near the last one, as one conic program.
//!
//! Equation: M of `cone` >= 0 for every loop. Dominant: each M is held in U'M U = sum of 2 by 2 blocks,
//! each >= 0 (scaled diagonal dominance, second-order cones), which is enough for M >= 0; U is the inverse
//! root of M at the last P, in coordinates where that P is the identity: there the restriction costs
//! nothing at the last P, so that rounds climb towards the optimum of the semidefinite program.
//! Semidefinite: that program itself, which needs BLAS and LAPACK (feature `sdp`).
//!
//! Source: Ahmadi and Majumdar (2019), SIAM J. Appl. Algebra Geometry 3(2), 193-230, for the cone;
//! Ahmadi and Hall (2017), "Sum of squares basis pursuit with linear and second order cone
//! programming", for the change of basis.
//!
//! Assumes and ignores: loops beyond the ones given.
//!
//! Valid for: loops of one size with some 20 states.
//!
//! Checked by: the tests of `cone`; `tests/semidefinite.rs` holds one against the other.

use crate::DesignError;
use crate::cone::Local;
use crate::symmetric::{full, places};
use clarabel::algebra::CscMatrix;
use clarabel::solver::{
    DefaultSettingsBuilder, DefaultSolver, IPSolver, NonnegativeConeT, SecondOrderConeT,
    SolverStatus, SupportedConeT,
};
use nalgebra::{DMatrix, SymmetricEigen};
use serde::{Deserialize, Serialize};

/// A reach without bound.
pub const FAR: f64 = f64::INFINITY;

/// What matrices are held positive by.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Cones {
    /// Second-order cones: scaled diagonal dominance in a basis that follows the solution.
    #[default]
    Dominant,
    /// Semidefinite cones, in a build with the feature `sdp`.
    Semidefinite,
}

impl Cones {
    /// Whether this build can solve such programs.
    ///
    /// # Errors
    /// For semidefinite cones without the feature.
    pub fn check(self) -> Result<(), DesignError> {
        if self == Self::Semidefinite && !cfg!(feature = "sdp") {
            return Err(DesignError::Plan(
                "cones semidefinite; accepted: dominant, for this build has no semidefinite cones (cargo build --release -p twinhub --features sdp, with Debian's libopenblas-dev)"
                    .to_owned(),
            ));
        }
        Ok(())
    }
}

/// Rows of a conic program, b - A x in a cone.
#[derive(Default)]
struct Rows {
    i: Vec<usize>,
    j: Vec<usize>,
    v: Vec<f64>,
    b: Vec<f64>,
}

impl Rows {
    fn push(&mut self, entries: impl Iterator<Item = (usize, f64)>, b: f64) {
        let row = self.b.len();
        for (column, value) in entries {
            if value != 0.0 {
                self.i.push(row);
                self.j.push(column);
                self.v.push(value);
            }
        }
        self.b.push(b);
    }
}

/// The best P in these coordinates for these loops; `None` if the solver finds none.
pub(crate) fn program(
    cones: Cones,
    loops: &[&Local],
    reference: f64,
    goal: f64,
    reach: f64,
) -> Result<Option<DMatrix<f64>>, DesignError> {
    let n = loops.first().map_or(0, |l| l.a.nrows());
    let m = n + 2;
    let count = n * (n + 1) / 2;
    let t = count;
    let mut next = count + 1;
    let mut rows = Rows::default();
    let mut within: Vec<SupportedConeT<f64>> = Vec::new();
    rows.push(core::iter::once((t, 1.0)), 1.2 * goal);
    if reach < FAR {
        for (k, (a, b)) in places(n).enumerate() {
            let here = if a == b { 1.0 } else { 0.0 };
            rows.push(core::iter::once((k, 1.0)), here + reach);
            rows.push(core::iter::once((k, -1.0)), reach - here);
        }
    }
    within.push(NonnegativeConeT(rows.b.len()));
    for local in loops {
        let mut shifted = local.matrix();
        for i in 0..n {
            shifted[(i, i)] -= reference;
        }
        let basis = match cones {
            Cones::Dominant => inverse_root(shifted),
            Cones::Semidefinite => DMatrix::identity(m, m),
        };
        let (ux, uw, uc) = (basis.rows(0, n), basis.row(n), basis.row(n + 1));
        let y = &local.a * ux + &local.b * uw;
        let cu = &local.c * ux;
        let entry = |i: usize, j: usize| -> (Vec<(usize, f64)>, f64) {
            let mut terms = Vec::with_capacity(count + 3);
            for (k, (a, b)) in places(n).enumerate() {
                let mut x = ux[(a, i)] * y[(b, j)] + ux[(a, j)] * y[(b, i)];
                if a != b {
                    x += ux[(b, i)] * y[(a, j)] + ux[(b, j)] * y[(a, i)];
                }
                // M holds -x p: the row holds b - A x.
                terms.push((k, x));
            }
            let tt: f64 = (0..n).map(|a| ux[(a, i)] * ux[(a, j)]).sum();
            terms.push((t, tt));
            let constant = uw[i] * uw[j] + uc[i] * uc[j] - uc[i] * cu[j] - uc[j] * cu[i];
            (terms, constant)
        };
        match cones {
            Cones::Dominant => next = dominant(&mut rows, &mut within, next, m, entry),
            Cones::Semidefinite => semidefinite(&mut rows, &mut within, m, entry),
        }
    }
    let a = CscMatrix::new_from_triplets(rows.b.len(), next, rows.i, rows.j, rows.v);
    let mut q = vec![0.0; next];
    q[t] = -1.0;
    let settings = DefaultSettingsBuilder::default()
        .verbose(false)
        .tol_gap_abs(1e-3)
        .tol_gap_rel(1e-3)
        .tol_feas(1e-6)
        .max_iter(40)
        .build()
        .map_err(|e| DesignError::Solver(e.to_string()))?;
    let mut solver = DefaultSolver::new(
        &CscMatrix::zeros((next, next)),
        &q,
        &a,
        &rows.b,
        &within,
        settings,
    )
    .map_err(|e| DesignError::Solver(e.to_string()))?;
    solver.solve();
    if !matches!(
        solver.solution.status,
        SolverStatus::Solved | SolverStatus::AlmostSolved | SolverStatus::InsufficientProgress
    ) {
        return Ok(None);
    }
    let p = full(n, &solver.solution.x);
    Ok(p.iter().all(|v| v.is_finite()).then_some(p))
}

/// What stands at a place of M: coefficients of the variables, and the constant.
type Entry = (Vec<(usize, f64)>, f64);

/// Holds M in a sum of 2 by 2 blocks, with variables from `first` on; returns the next one.
fn dominant(
    rows: &mut Rows,
    within: &mut Vec<SupportedConeT<f64>>,
    first: usize,
    m: usize,
    entry: impl Fn(usize, usize) -> Entry,
) -> usize {
    let pairs: Vec<(usize, usize)> = (0..m)
        .flat_map(|i| (i + 1..m).map(move |j| (i, j)))
        .collect();
    // Diagonal: what the blocks take is there.
    for i in 0..m {
        let (mut terms, constant) = entry(i, i);
        for (k, pair) in pairs.iter().enumerate() {
            if pair.0 == i {
                terms.push((first + 2 * k, 1.0));
            } else if pair.1 == i {
                terms.push((first + 2 * k + 1, 1.0));
            }
        }
        rows.push(terms.into_iter(), constant);
    }
    within.push(NonnegativeConeT(m));
    // Blocks: [p, x; x, q] >= 0 as |(p - q, 2 x)| <= p + q.
    for (k, &(i, j)) in pairs.iter().enumerate() {
        let (p, q) = (first + 2 * k, first + 2 * k + 1);
        rows.push([(p, -1.0), (q, -1.0)].into_iter(), 0.0);
        rows.push([(p, -1.0), (q, 1.0)].into_iter(), 0.0);
        let (terms, constant) = entry(i, j);
        rows.push(terms.into_iter().map(|(c, v)| (c, 2.0 * v)), 2.0 * constant);
        within.push(SecondOrderConeT(3));
    }
    first + 2 * pairs.len()
}

/// Holds M in a semidefinite cone: the upper triangle by columns, what is beside the diagonal times √2.
#[cfg(feature = "sdp")]
fn semidefinite(
    rows: &mut Rows,
    within: &mut Vec<SupportedConeT<f64>>,
    m: usize,
    entry: impl Fn(usize, usize) -> Entry,
) {
    for j in 0..m {
        for i in 0..=j {
            let weight = if i == j {
                1.0
            } else {
                core::f64::consts::SQRT_2
            };
            let (terms, constant) = entry(i, j);
            rows.push(
                terms.into_iter().map(|(c, v)| (c, weight * v)),
                weight * constant,
            );
        }
    }
    within.push(clarabel::solver::PSDTriangleConeT(m));
}

/// Without the feature there is no such program: `Cones::check` refuses it before.
#[cfg(not(feature = "sdp"))]
fn semidefinite(
    rows: &mut Rows,
    _within: &mut Vec<SupportedConeT<f64>>,
    _m: usize,
    _entry: impl Fn(usize, usize) -> Entry,
) {
    // An equation that nothing satisfies.
    rows.push(core::iter::empty(), -1.0);
}

/// U with U'M U of ones, where M is large enough.
fn inverse_root(m: DMatrix<f64>) -> DMatrix<f64> {
    let eigen = SymmetricEigen::new(m);
    let largest = eigen.eigenvalues.amax();
    let mut basis = eigen.eigenvectors;
    for (mut column, value) in basis.column_iter_mut().zip(eigen.eigenvalues.iter()) {
        column /= libm::sqrt(value.abs().max(1e-3 * largest));
    }
    basis
}
