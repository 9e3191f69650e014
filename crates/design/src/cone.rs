//! What: one Lyapunov matrix for several loops, by second-order cones.
//!
//! Equation: find P > 0 with M(P) = [-(A'P + PA) - t P₀, -P b, -c'; ., 1, 0; ., ., 1] >= 0 for every loop,
//! t as large as possible: then V = x'P x falls along every one of them, whatever |w| <= |c x| the
//! delay's error does. Instead of a semidefinite cone each M is held in U'M U = sum of 2 by 2 blocks,
//! each >= 0 (scaled diagonal dominance), which is enough for M >= 0. U is the inverse root of M at
//! the last P, in coordinates where that P is the identity: there the restriction costs nothing at
//! the last P, so that rounds climb towards the optimum of the semidefinite program.
//!
//! Source: Ahmadi and Majumdar (2019), SIAM J. Appl. Algebra Geometry 3(2), 193-230, for the cone;
//! Ahmadi and Hall (2017), "Sum of squares basis pursuit with linear and second order cone
//! programming", for the change of basis.
//!
//! Assumes and ignores: a local climb: what is found is checked, what is not found may yet exist.
//!
//! Valid for: loops of one size with some 20 states.
//!
//! Checked by: tests below (loops of which the answer is known), and every result by `check`.

use crate::DesignError;
use crate::loops::Loop;
use crate::symmetric::{full, places};
use clarabel::algebra::CscMatrix;
use clarabel::solver::{
    DefaultSettingsBuilder, DefaultSolver, IPSolver, NonnegativeConeT, SecondOrderConeT,
    SolverStatus, SupportedConeT,
};
use nalgebra::{DMatrix, DVector, RowDVector, SymmetricEigen};

/// Loops in one program: the hardest ones; the others are looked at between rounds.
const LOOPS_MOST: usize = 8;
/// Rounds that better the margin by less than a twentieth after which the climb ends.
const PATIENCE: usize = 2;
/// Rounds at most.
const ROUNDS: usize = 16;

/// A reach without bound.
const FAR: f64 = f64::INFINITY;

/// What a climb found.
#[derive(Clone, Debug)]
pub struct Climbed {
    /// The Lyapunov matrix.
    pub p: DMatrix<f64>,
    /// Its margin t at the worst loop, 1/s: V' <= -t V; negative: none was found.
    pub margin_per_s: f64,
    /// Programs that were solved.
    pub rounds: usize,
}

/// A loop in coordinates where the Lyapunov matrix is the identity.
struct Local {
    a: DMatrix<f64>,
    b: DVector<f64>,
    c: RowDVector<f64>,
}

impl Local {
    fn new(closed: &Loop, root: &DMatrix<f64>, inverse: &DMatrix<f64>) -> Self {
        Self {
            a: root.transpose() * &closed.a * inverse.transpose(),
            b: root.transpose() * &closed.b,
            c: &closed.c * inverse.transpose(),
        }
    }

    /// Smallest eigenvalue of -(A'P + PA) - c'c - P b b'P.
    fn margin(&self, p: &DMatrix<f64>) -> f64 {
        let pa = p * &self.a;
        let pb = p * &self.b;
        let left = -(&pa + pa.transpose()) - self.c.transpose() * &self.c - &pb * pb.transpose();
        left.symmetric_eigenvalues().min()
    }

    /// M at P = I and t = 0.
    fn matrix(&self) -> DMatrix<f64> {
        let n = self.a.nrows();
        let mut m = DMatrix::identity(n + 2, n + 2);
        m.view_mut((0, 0), (n, n))
            .copy_from(&-(&self.a + self.a.transpose()));
        for i in 0..n {
            m[(i, n)] = -self.b[i];
            m[(n, i)] = -self.b[i];
            m[(i, n + 1)] = -self.c[i];
            m[(n + 1, i)] = -self.c[i];
        }
        m
    }
}

/// Climbs from `start` until the margin is `goal_per_s` at every loop.
///
/// # Errors
/// If `start` is not positive definite, or the solver refuses a program.
pub fn climb(
    loops: &[Loop],
    start: &DMatrix<f64>,
    goal_per_s: f64,
) -> Result<Climbed, DesignError> {
    climb_until(loops, start, goal_per_s, FAR, &mut |_, margin| {
        margin >= goal_per_s
    })
}

/// Climbs from `start`, no entry of the matrix by more than `reach` in a round (in coordinates where
/// the matrix is the identity), until `enough` likes matrix and margin; else to the best margin up
/// to `goal_per_s`.
///
/// # Errors
/// As [`climb`].
pub fn climb_until(
    loops: &[Loop],
    start: &DMatrix<f64>,
    goal_per_s: f64,
    reach: f64,
    enough: &mut dyn FnMut(&DMatrix<f64>, f64) -> bool,
) -> Result<Climbed, DesignError> {
    let n = start.nrows();
    let one = DMatrix::identity(n, n);
    let mut root = cholesky(start)?;
    let mut best: Option<Climbed> = None;
    let mut since = 0;
    for round in 0..=ROUNDS {
        let inverse = inverse_of(&root)?;
        let local: Vec<Local> = loops
            .iter()
            .map(|l| Local::new(l, &root, &inverse))
            .collect();
        let margins: Vec<f64> = local.iter().map(|l| l.margin(&one)).collect();
        let margin = margins.iter().copied().fold(f64::INFINITY, f64::min);
        let before = best.as_ref().map(|b| b.margin_per_s);
        let better = before.is_none_or(|b| margin > b + 0.05 * b.abs());
        since = if better { 0 } else { since + 1 };
        let p = &root * root.transpose();
        let done = enough(&p, margin);
        if done || before.is_none_or(|b| margin > b) {
            best = Some(Climbed {
                p,
                margin_per_s: margin,
                rounds: round,
            });
        }
        if done || since > PATIENCE || round == ROUNDS {
            break;
        }
        let mut order: Vec<usize> = (0..loops.len()).collect();
        order.sort_by(|&i, &j| margins[i].total_cmp(&margins[j]));
        let hard: Vec<&Local> = order.iter().take(LOOPS_MOST).map(|&i| &local[i]).collect();
        let reference = 1.2 * margin.min(0.0) - 1e-3;
        let Some(p) = program(&hard, reference, goal_per_s, reach)? else {
            break;
        };
        let Some(step) = step(&local, &one, &p) else {
            break;
        };
        root *= step;
    }
    best.ok_or_else(|| DesignError::Solver("no round was run".to_owned()))
}

/// The root of the best matrix between the identity and `p`: all loops were not in the program.
fn step(local: &[Local], one: &DMatrix<f64>, p: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let mut best: Option<(f64, DMatrix<f64>)> = None;
    for share in [1.0, 0.75, 0.5, 0.3, 0.15, 0.07] {
        let between = one + (p - one) * share;
        let Ok(root) = cholesky(&between) else {
            continue;
        };
        let margin = local
            .iter()
            .map(|l| l.margin(&between))
            .fold(f64::INFINITY, f64::min);
        if best.as_ref().is_none_or(|(most, _)| margin > *most) {
            best = Some((margin, root));
        }
    }
    best.map(|(_, root)| root)
}

pub(crate) fn cholesky(p: &DMatrix<f64>) -> Result<DMatrix<f64>, DesignError> {
    nalgebra::Cholesky::new(p.clone())
        .map(|c| c.l())
        .ok_or_else(|| DesignError::Solver("a Lyapunov matrix is not positive definite".to_owned()))
}

fn inverse_of(root: &DMatrix<f64>) -> Result<DMatrix<f64>, DesignError> {
    let n = root.nrows();
    root.solve_lower_triangular(&DMatrix::identity(n, n))
        .ok_or_else(|| DesignError::Solver("a Lyapunov matrix is singular".to_owned()))
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
fn program(
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
    let mut cones: Vec<SupportedConeT<f64>> = Vec::new();
    rows.push(core::iter::once((t, 1.0)), 1.2 * goal);
    if reach < FAR {
        for (k, (a, b)) in places(n).enumerate() {
            let here = if a == b { 1.0 } else { 0.0 };
            rows.push(core::iter::once((k, 1.0)), here + reach);
            rows.push(core::iter::once((k, -1.0)), reach - here);
        }
    }
    cones.push(NonnegativeConeT(rows.b.len()));
    for local in loops {
        let mut shifted = local.matrix();
        for i in 0..n {
            shifted[(i, i)] -= reference;
        }
        let basis = inverse_root(shifted);
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
        let first = next;
        let pairs: Vec<(usize, usize)> = (0..m)
            .flat_map(|i| (i + 1..m).map(move |j| (i, j)))
            .collect();
        next += 2 * pairs.len();
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
        cones.push(NonnegativeConeT(m));
        // Blocks: [p, x; x, q] >= 0 as |(p - q, 2 x)| <= p + q.
        for (k, &(i, j)) in pairs.iter().enumerate() {
            let (p, q) = (first + 2 * k, first + 2 * k + 1);
            rows.push([(p, -1.0), (q, -1.0)].into_iter(), 0.0);
            rows.push([(p, -1.0), (q, 1.0)].into_iter(), 0.0);
            let (terms, constant) = entry(i, j);
            rows.push(terms.into_iter().map(|(c, v)| (c, 2.0 * v)), 2.0 * constant);
            cones.push(SecondOrderConeT(3));
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
        &cones,
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

#[cfg(test)]
mod tests {
    use super::*;

    fn turning(damping: f64, frequency: f64, error: f64) -> Loop {
        Loop {
            a: DMatrix::from_row_slice(2, 2, &[0.0, 1.0, -frequency * frequency, -2.0 * damping]),
            b: DVector::from_row_slice(&[0.0, 1.0]),
            c: RowDVector::from_row_slice(&[error, 0.0]),
        }
    }

    #[test]
    fn an_oscillator_bears_what_the_small_gain_theorem_says() {
        // The gain from w to x peaks at 1 / (2 d sqrt(w² - d²)) with d = 1, w = 3: 0.177.
        let bears = |error: f64| {
            let closed = [turning(1.0, 3.0, error)];
            let found = climb(&closed, &DMatrix::from_diagonal_element(2, 2, 1.0), 1e-4);
            found.expect("a program").margin_per_s > 0.0
        };
        assert!(bears(0.9 / 0.177) && !bears(1.1 / 0.177));
    }

    #[test]
    fn one_matrix_for_two_loops_is_found_where_neither_of_theirs_does() {
        let closed = [turning(0.5, 1.0, 0.01), turning(0.5, 1.6, 0.01)];
        let found = climb(&closed, &DMatrix::from_diagonal_element(2, 2, 1.0), 0.05).expect("runs");
        assert!(found.margin_per_s > 0.0, "{}", found.margin_per_s);
        // No quadratic function falls along both of these.
        let far = [turning(0.1, 1.0, 0.01), turning(0.1, 5.0, 0.01)];
        let found = climb(&far, &DMatrix::from_diagonal_element(2, 2, 1.0), 0.05).expect("runs");
        assert!(found.margin_per_s <= 0.0, "{}", found.margin_per_s);
    }
}
