//! What: the largest schedule that respects a cap at every speed and a largest slope.
//!
//! Equation: maximise Σ T_i with 0 <= T_i <= cap_i, |T_i+1 - T_i| <= s |v_i+1 - v_i|, T = 0 at both
//! ends: a linear program.
//!
//! Source: own; solved by Clarabel.
//!
//! Assumes and ignores: what the caps know. More pair is better up to them.
//!
//! Valid for: speeds that rise.
//!
//! Checked by: tests below.

use crate::DesignError;
use clarabel::algebra::CscMatrix;
use clarabel::solver::{
    DefaultSettingsBuilder, DefaultSolver, IPSolver, NonnegativeConeT, SolverStatus, SupportedConeT,
};

/// The pair at each speed, Nm.
///
/// # Errors
/// If the solver has no answer.
pub fn largest(
    speeds_m_s: &[f64],
    caps_nm: &[f64],
    slope_nm_per_m_s: f64,
) -> Result<Vec<f64>, DesignError> {
    let n = speeds_m_s.len();
    let (mut i, mut j, mut v, mut b) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    let mut row = |entries: &[(usize, f64)], limit: f64| {
        for &(column, value) in entries {
            i.push(b.len());
            j.push(column);
            v.push(value);
        }
        b.push(limit);
    };
    for k in 0..n {
        let end = k == 0 || k + 1 == n;
        row(&[(k, 1.0)], if end { 0.0 } else { caps_nm[k].max(0.0) });
        row(&[(k, -1.0)], 0.0);
        if k + 1 < n {
            let most = slope_nm_per_m_s * (speeds_m_s[k + 1] - speeds_m_s[k]);
            row(&[(k + 1, 1.0), (k, -1.0)], most);
            row(&[(k + 1, -1.0), (k, 1.0)], most);
        }
    }
    let rows = b.len();
    let a = CscMatrix::new_from_triplets(rows, n, i, j, v);
    let cones: [SupportedConeT<f64>; 1] = [NonnegativeConeT(rows)];
    let settings = DefaultSettingsBuilder::default()
        .verbose(false)
        .build()
        .map_err(|e| DesignError::Solver(e.to_string()))?;
    let mut solver = DefaultSolver::new(
        &CscMatrix::zeros((n, n)),
        &vec![-1.0; n],
        &a,
        &b,
        &cones,
        settings,
    )
    .map_err(|e| DesignError::Solver(e.to_string()))?;
    solver.solve();
    if !matches!(
        solver.solution.status,
        SolverStatus::Solved | SolverStatus::AlmostSolved
    ) {
        return Err(DesignError::Solver(format!(
            "the schedule's program ended with {:?}",
            solver.solution.status
        )));
    }
    // Readable numbers; the certificate is for what is written.
    Ok(solver
        .solution
        .x
        .iter()
        .map(|t| (libm::floor(t * 10.0 + 1e-3) / 10.0).max(0.0))
        .collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn caps_slopes_and_ends_hold_and_nothing_is_given_away() {
        let speeds: Vec<f64> = (0..9).map(|k| 3.0 + 0.5 * f64::from(k)).collect();
        let caps = [40.0, 40.0, 40.0, 10.0, 40.0, 40.0, 40.0, 40.0, 40.0];
        let t = largest(&speeds, &caps, 40.0).expect("solves");
        assert_eq!(t, [0.0, 20.0, 30.0, 10.0, 30.0, 40.0, 40.0, 20.0, 0.0]);
    }
}
