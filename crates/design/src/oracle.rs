//! What: the largest pair that the tyres carry, as the second-order cone program that the closed form
//! of `twinhub_control::allocation` solves.
//!
//! Equation: over the pair's force F, minimise (F - F_d)² with 0 <= F <= F_max and friction circles
//! at both wheels: |(F, s N_f)| <= mu N_f and |(F + t, s N_r)| <= mu N_r. s is the side force per
//! load, t the net drive asked for beside the pair (0 if it brakes), N_f = N_f0 - (h / w) t the front
//! load, N_r = N_r0 (what the rear gains is not counted on).
//!
//! Source: friction circle; Boyd and Vandenberghe (2004), section 4.4.2, for the cones.
//!
//! Assumes and ignores: as the closed form.
//!
//! Valid for: any numbers; infeasible where not even F = 0 is carried, then no pair is.
//!
//! Checked by: `tests/oracle.rs`: the closed form agrees on random cases within the rounding of f32.

use clarabel::algebra::CscMatrix;
use clarabel::solver::{
    DefaultSettingsBuilder, DefaultSolver, IPSolver, NonnegativeConeT, SecondOrderConeT,
    SolverStatus, SupportedConeT,
};

/// Where the tyres stand.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Road {
    /// Friction.
    pub friction_ratio: f64,
    /// Side force per load.
    pub side_ratio: f64,
    /// Load of the front wheel at rest, N.
    pub front_load_n: f64,
    /// Load of the rear wheel at rest, N.
    pub rear_load_n: f64,
    /// Height of the centre of mass over the wheelbase.
    pub transfer_ratio: f64,
}

/// Why there is no answer.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum OracleError {
    /// The solver refused the program.
    #[error("the program cannot be set up: {0}")]
    Setup(String),
    /// The solver ended without an answer.
    #[error("the solver ended with {0}")]
    Status(String),
}

/// The program.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Oracle;

impl Oracle {
    /// The pair's force, N, nearest to `demand_n`, at most `most_n`, beside a net drive of `drive_n`.
    ///
    /// # Errors
    /// If the solver does not answer.
    pub fn pair_n(
        &self,
        road: &Road,
        demand_n: f64,
        most_n: f64,
        drive_n: f64,
    ) -> Result<f64, OracleError> {
        let t = drive_n.max(0.0);
        let (front, rear) = (
            road.front_load_n - road.transfer_ratio * t,
            road.rear_load_n,
        );
        // Forces as shares of the front load at rest: numbers near one.
        let scale = road.front_load_n;
        let (mu, s) = (road.friction_ratio, road.side_ratio);
        // b - A x in the cone: F >= 0; F <= F_max; the two circles.
        let a = CscMatrix::from(&[[-1.0], [1.0], [0.0], [-1.0], [0.0], [0.0], [-1.0], [0.0]]);
        let b = [
            0.0,
            most_n / scale,
            mu * front / scale,
            0.0,
            s * front / scale,
            mu * rear / scale,
            t / scale,
            s * rear / scale,
        ];
        let p = CscMatrix::from(&[[2.0]]);
        let q = [-2.0 * demand_n / scale];
        let cones: [SupportedConeT<f64>; 3] = [
            NonnegativeConeT(2),
            SecondOrderConeT(3),
            SecondOrderConeT(3),
        ];
        let settings = DefaultSettingsBuilder::default()
            .verbose(false)
            .tol_gap_abs(1e-10)
            .tol_gap_rel(1e-10)
            .tol_feas(1e-10)
            .build()
            .map_err(|e| OracleError::Setup(e.to_string()))?;
        let mut solver = DefaultSolver::new(&p, &q, &a, &b, &cones, settings)
            .map_err(|e| OracleError::Setup(e.to_string()))?;
        solver.solve();
        match solver.solution.status {
            SolverStatus::Solved | SolverStatus::AlmostSolved => Ok(solver.solution.x[0] * scale),
            SolverStatus::PrimalInfeasible | SolverStatus::AlmostPrimalInfeasible => Ok(0.0),
            other => Err(OracleError::Status(format!("{other:?}"))),
        }
    }
}
