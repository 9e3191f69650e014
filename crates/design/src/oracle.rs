//! What: the largest pair that tyres, motors and battery carry, as the second-order cone program that the
//! closed form of `twinhub_control::allocation` solves.
//!
//! Equation: first the net drive D nearest to the one asked for, |(D, s N_r)| <= mu N_r, |D| <= M,
//! D / e <= P_out / v, -e D <= P_in / v. Then the pair's force F nearest to F_d with
//! 0 <= F <= F_max, friction circles at both wheels, |(F, s N_f)| <= mu N_f and
//! |(F + t, s N_r)| <= mu N_r, motors F <= M, F + D <= M, and the bus (F + D) / e - e F <= P_out / v. s is
//! the side force per load, t the net drive asked for beside the pair (0 if it brakes),
//! N_f = N_f0 - (h / w) t the front load, N_r = N_r0 (what the rear gains is not counted on), e the
//! efficiency each way.
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

/// What motors and battery have, forces of powers over speed; infinite where nothing limits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Power {
    /// Efficiency of motor and drive, each way.
    pub efficiency: f64,
    /// Largest force of a motor, N.
    pub motor_n: f64,
    /// What the battery gives, N.
    pub out_n: f64,
    /// What it takes back, N.
    pub in_n: f64,
}

/// What is wanted, N.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wish {
    /// Force of the pair.
    pub pair_n: f64,
    /// The largest pair, whatever the road.
    pub most_n: f64,
    /// Net drive beside it; negative brakes.
    pub drive_n: f64,
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
    /// The net drive, N, nearest to the one wished for.
    ///
    /// # Errors
    /// If the solver does not answer.
    pub fn drive_n(&self, road: &Road, power: &Power, wish: &Wish) -> Result<f64, OracleError> {
        let mut program = Program::new(road.rear_load_n, wish.drive_n);
        let e = power.efficiency;
        program.at_most(1.0, power.motor_n);
        program.at_most(-1.0, power.motor_n);
        program.at_most(1.0 / e, power.out_n);
        program.at_most(-e, power.in_n);
        program.within_circle(0.0, road, road.rear_load_n);
        program.solve()
    }

    /// The pair's force, N, nearest to the one wished for, beside a net drive of `drive_n`.
    ///
    /// # Errors
    /// If the solver does not answer.
    pub fn pair_n(
        &self,
        road: &Road,
        power: &Power,
        wish: &Wish,
        drive_n: f64,
    ) -> Result<f64, OracleError> {
        let t = wish.drive_n.max(0.0);
        let e = power.efficiency;
        let mut program = Program::new(road.front_load_n, wish.pair_n);
        program.at_most(-1.0, 0.0);
        program.at_most(1.0, wish.most_n);
        program.at_most(1.0, power.motor_n);
        program.at_most(1.0, power.motor_n - drive_n);
        program.at_most(1.0 / e - e, power.out_n - drive_n / e);
        program.within_circle(0.0, road, road.front_load_n - road.transfer_ratio * t);
        program.within_circle(t, road, road.rear_load_n);
        program.solve()
    }
}

/// Rows that leave less than this share of the scale leave a point.
const POINT: f64 = 1e-6;

/// The force nearest to a wish within rows and circles. Forces are shares of `scale_n`: numbers near one.
struct Program {
    scale_n: f64,
    wish_n: f64,
    /// Coefficients of the force, and right sides: b - a x in the cones.
    rows: Vec<(f64, f64)>,
    circles: Vec<[(f64, f64); 3]>,
}

impl Program {
    fn new(scale_n: f64, wish_n: f64) -> Self {
        Self {
            scale_n,
            wish_n,
            rows: vec![],
            circles: vec![],
        }
    }

    /// `factor` times the force is at most `most_n`.
    fn at_most(&mut self, factor: f64, most_n: f64) {
        if most_n.is_finite() {
            self.rows.push((factor, most_n / self.scale_n));
        }
    }

    /// The force and `beside_n` stay in the friction circle of a wheel of this load.
    fn within_circle(&mut self, beside_n: f64, road: &Road, load_n: f64) {
        let of = |force_n: f64| force_n / self.scale_n;
        self.circles.push([
            (0.0, of(road.friction_ratio * load_n)),
            (-1.0, of(beside_n)),
            (0.0, of(road.side_ratio * load_n)),
        ]);
    }

    /// Zero where nothing is feasible.
    fn solve(&self) -> Result<f64, OracleError> {
        let ends = |sign: f64| {
            let rows = self.rows.iter().filter(move |(a, _)| a * sign > 0.0);
            rows.map(|(a, b)| b / a)
        };
        let low = ends(-1.0).fold(f64::NEG_INFINITY, f64::max);
        let high = ends(1.0).fold(f64::INFINITY, f64::min);
        // A program whose rows leave a point has no inside for the solver.
        if high - low < POINT {
            return Ok(low * self.scale_n);
        }
        // Force and its distance d from the wish, the least: linear, so that the answer is as close as
        // the solver's gap.
        let wish = self.wish_n / self.scale_n;
        let distance = [([1.0, -1.0], wish), ([-1.0, -1.0], -wish)];
        let plain = |(a, b): &(f64, f64)| ([*a, 0.0], *b);
        let all: Vec<([f64; 2], f64)> = (self.rows.iter().map(plain))
            .chain(distance)
            .chain(self.circles.iter().flatten().map(plain))
            .collect();
        let a = CscMatrix::from(&all.iter().map(|(a, _)| *a).collect::<Vec<_>>());
        let b: Vec<f64> = all.iter().map(|(_, b)| *b).collect();
        let p = CscMatrix::zeros((2, 2));
        let q = [0.0, 1.0];
        let mut cones: Vec<SupportedConeT<f64>> = vec![NonnegativeConeT(self.rows.len() + 2)];
        cones.extend(self.circles.iter().map(|_| SecondOrderConeT(3)));
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
            SolverStatus::Solved | SolverStatus::AlmostSolved => {
                Ok(solver.solution.x[0] * self.scale_n)
            }
            SolverStatus::PrimalInfeasible | SolverStatus::AlmostPrimalInfeasible => Ok(0.0),
            other => Err(OracleError::Status(format!("{other:?}"))),
        }
    }
}
