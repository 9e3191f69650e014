//! What: where a climb starts if no neighbour has a matrix.
//!
//! Equation: A'P + PA = -(c'c + ε I) for the mean of the loops, then the climb of `cone` for loops that
//! spread from the mean to where they are.
//!
//! Source: continuation: Allgower and Georg (2003), "Introduction to Numerical Continuation Methods".
//!
//! Assumes and ignores: the mean of the loops is stable.
//!
//! Valid for: as `cone`.
//!
//! Checked by: as `cone`.

use crate::DesignError;
use crate::cone::{Climbed, cholesky, climb};
use crate::loops::Loop;
use crate::program::Cones;
use nalgebra::{DMatrix, DVector};

/// Climbs from nothing: first one matrix for the mean of the loops, then for loops that spread from
/// the mean to where they are.
///
/// # Errors
/// If the mean loop is not stable, or the solver refuses a program.
pub fn from_scratch(cones: Cones, loops: &[Loop], goal_per_s: f64) -> Result<Climbed, DesignError> {
    let share = 1.0 / loops.len() as f64;
    let nothing = Loop {
        a: &loops[0].a * 0.0,
        b: &loops[0].b * 0.0,
        c: &loops[0].c * 0.0,
    };
    let mean = loops.iter().fold(nothing, |sum, closed| Loop {
        a: sum.a + &closed.a * share,
        b: sum.b + &closed.b * share,
        c: sum.c + &closed.c * share,
    });
    let between = |from: &Loop, to: &Loop, share: f64| Loop {
        a: &from.a + (&to.a - &from.a) * share,
        b: &from.b + (&to.b - &from.b) * share,
        c: &from.c + (&to.c - &from.c) * share,
    };
    let mut p = climb(
        cones,
        core::slice::from_ref(&mean),
        &lyapunov(&mean)?,
        goal_per_s,
    )?
    .p;
    let mut spread = 0.0;
    let mut stride: f64 = 0.1;
    loop {
        let next = (spread + stride).min(1.0);
        let there: Vec<Loop> = loops.iter().map(|l| between(&mean, l, next)).collect();
        let goal_per_s = if next < 1.0 {
            0.2 * goal_per_s
        } else {
            goal_per_s
        };
        let found = climb(cones, &there, &p, goal_per_s)?;
        if found.margin_per_s <= 0.0 {
            stride *= 0.5;
            if stride < 0.02 {
                return Ok(Climbed {
                    margin_per_s: -1.0,
                    ..found
                });
            }
        } else if next < 1.0 {
            p = found.p;
            spread = next;
            stride *= 1.6;
        } else {
            return Ok(found);
        }
    }
}

/// A Lyapunov matrix of one loop without the delay's error: where a climb may start.
///
/// # Errors
/// If the loop is not stable.
pub fn lyapunov(closed: &Loop) -> Result<DMatrix<f64>, DesignError> {
    let n = closed.a.nrows();
    let q = closed.c.transpose() * &closed.c + DMatrix::identity(n, n) * 1e-3;
    // vec(A'P + PA) = (I x A' + A' x I) vec(P).
    let at = closed.a.transpose();
    let one = DMatrix::identity(n, n);
    let operator = one.kronecker(&at) + at.kronecker(&one);
    let right = DVector::from_iterator(n * n, q.iter().map(|x| -x));
    let solution = operator
        .lu()
        .solve(&right)
        .ok_or_else(|| DesignError::Solver("a loop has eigenvalues that mirror".to_owned()))?;
    let p = DMatrix::from_column_slice(n, n, solution.as_slice());
    let p = (&p + p.transpose()) * 0.5;
    cholesky(&p).map_err(|_| DesignError::Solver("a loop is not stable".to_owned()))?;
    Ok(p)
}
