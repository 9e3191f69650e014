//! What: one Lyapunov matrix for several loops, by conic programs.
//!
//! Equation: find P > 0 with M(P) = [-(A'P + PA) - t P₀, -P b, -c'; ., 1, 0; ., ., 1] >= 0 for every loop,
//! t as large as possible: then V = x'P x falls along every one of them, whatever |w| <= |c x| the
//! delay's error does. Rounds, each a program (`program`) in coordinates where the last P is the
//! identity.
//!
//! Source: own.
//!
//! Assumes and ignores: a local climb: what is found is checked, what is not found may yet exist.
//!
//! Valid for: loops of one size with some 20 states.
//!
//! Checked by: tests below (loops of which the answer is known), and every result by `check`.

use crate::DesignError;
use crate::loops::Loop;
use crate::program::{Cones, FAR, program};
use nalgebra::{DMatrix, DVector, RowDVector};

/// Loops in one program: the hardest ones; the others are looked at between rounds.
const LOOPS_MOST: usize = 8;
/// Rounds that better the margin by less than a twentieth after which the climb ends.
const PATIENCE: usize = 2;
/// Rounds at most.
const ROUNDS: usize = 16;

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
pub(crate) struct Local {
    pub a: DMatrix<f64>,
    pub b: DVector<f64>,
    pub c: RowDVector<f64>,
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
    pub fn matrix(&self) -> DMatrix<f64> {
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
    cones: Cones,
    loops: &[Loop],
    start: &DMatrix<f64>,
    goal_per_s: f64,
) -> Result<Climbed, DesignError> {
    climb_until(cones, loops, start, goal_per_s, FAR, &mut |_, margin| {
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
    cones: Cones,
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
        let Some(p) = program(cones, &hard, reference, goal_per_s, reach)? else {
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
            let found = climb(
                Cones::Dominant,
                &closed,
                &DMatrix::from_diagonal_element(2, 2, 1.0),
                1e-4,
            );
            found.expect("a program").margin_per_s > 0.0
        };
        assert!(bears(0.9 / 0.177) && !bears(1.1 / 0.177));
    }

    #[test]
    fn one_matrix_for_two_loops_is_found_where_neither_of_theirs_does() {
        let closed = [turning(0.5, 1.0, 0.01), turning(0.5, 1.6, 0.01)];
        let found = climb(
            Cones::Dominant,
            &closed,
            &DMatrix::from_diagonal_element(2, 2, 1.0),
            0.05,
        )
        .expect("runs");
        assert!(found.margin_per_s > 0.0, "{}", found.margin_per_s);
        // No quadratic function falls along both of these.
        let far = [turning(0.1, 1.0, 0.01), turning(0.1, 5.0, 0.01)];
        let found = climb(
            Cones::Dominant,
            &far,
            &DMatrix::from_diagonal_element(2, 2, 1.0),
            0.05,
        )
        .expect("runs");
        assert!(found.margin_per_s <= 0.0, "{}", found.margin_per_s);
    }
}
