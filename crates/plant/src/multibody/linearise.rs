//! What: the model linearised about a steady state, to full accuracy.
//!
//! Equation: x' = A x + B u, A and B the Jacobians of the reduced derivative by dual numbers
//! (through the constraint solve without slip).
//!
//! Source: Griewank and Walther (2008), chapter 3; reduced coordinates in `reduced`.
//!
//! Assumes and ignores: as in `steady`.
//!
//! Valid for: small disturbances.
//!
//! Checked by: the tests of `multibody/tests`: state matrix of the benchmark without slip (1e-9),
//! growth of a small disturbance in the nonlinear model (1e-5), differences.

use super::error::MultibodyError;
use super::model::{Input, Multibody};
use super::reduced::{NAMES, Reduced, place};
use super::steady::{Course, Steady};
use crate::Scalar;
use crate::dual::Dual;
use core::ops::Range;
use nalgebra::DMatrix;
use twinhub_linear::{EigenError, Eigenpair, Layout, eigenpairs};

/// Names of the inputs of a linearised model.
pub const INPUTS: [&str; 9] = [
    "steer_torque_nm",
    "front_brake_nm",
    "rear_traction_nm",
    "roll_torque_nm",
    "trunk_lean_torque_nm",
    "trunk_pitch_torque_nm",
    "trunk_twist_torque_nm",
    "left_leg_torque_nm",
    "right_leg_torque_nm",
];

/// A linearised model.
#[derive(Clone, Debug)]
pub struct Linear {
    /// State matrix.
    pub a: DMatrix<f64>,
    /// Input matrix, columns in the order of [`INPUTS`].
    pub b: DMatrix<f64>,
    /// Names of the states.
    pub names: Vec<&'static str>,
}

impl Linear {
    /// Index of a state by name.
    pub fn index(&self, name: &str) -> Option<usize> {
        self.names.iter().position(|n| *n == name)
    }

    /// Which states name a mode.
    pub fn layout(&self) -> Layout {
        let at = |name: &str| self.index(name).unwrap_or(usize::MAX);
        let configuration = &NAMES[..place::STEER_RATE];
        let others = (0..self.names.len())
            .filter(|&i| configuration[2..].contains(&self.names[i]))
            .collect();
        Layout {
            roll: at("roll_rad"),
            steer: at("steer_rad"),
            others,
        }
    }

    /// Eigenvalues with shapes.
    pub fn eigenpairs(&self) -> Result<Vec<Eigenpair>, EigenError> {
        eigenpairs(&self.a)
    }

    /// The part of the state matrix that belongs to these states.
    pub fn block(&self, names: &[&str]) -> Option<DMatrix<f64>> {
        let at: Option<Vec<usize>> = names.iter().map(|n| self.index(n)).collect();
        let at = at?;
        Some(DMatrix::from_fn(at.len(), at.len(), |i, j| {
            self.a[(at[i], at[j])]
        }))
    }
}

/// Directions of one pass. The model is compiled once for them, however many states it has: with
/// all directions at once it takes minutes to compile.
pub(super) const DIRECTIONS: usize = 8;

/// A number with its derivatives in the directions of one pass.
pub(super) type Directional = Dual<DIRECTIONS>;

/// Derivatives in `count` directions, a column each, in passes: `rows` gives the values of a pass
/// with derivatives in its directions.
pub(super) fn columns(
    height: usize,
    count: usize,
    mut rows: impl FnMut(Range<usize>) -> Vec<Directional>,
) -> DMatrix<f64> {
    let mut all = DMatrix::zeros(height, count);
    for start in (0..count).step_by(DIRECTIONS) {
        let pass = start..(start + DIRECTIONS).min(count);
        for (i, value) in rows(pass.clone()).iter().enumerate() {
            for (slot, column) in pass.clone().enumerate() {
                all[(i, column)] = value.eps[slot];
            }
        }
    }
    all
}

impl Multibody {
    /// The model linearised about a steady state.
    pub fn linearise(&self, steady: &Steady) -> Linear {
        let active = self.active();
        let n = active.len();
        Linear {
            a: self.jacobian(steady, &active, &DMatrix::identity(n, n)),
            b: self.input_matrix(steady, &active),
            names: self.state_names(&active),
        }
    }

    /// The state matrix alone, which is what maps and searches need.
    pub fn state_matrix(&self, steady: &Steady) -> DMatrix<f64> {
        let active = self.active();
        let n = active.len();
        self.jacobian(steady, &active, &DMatrix::identity(n, n))
    }

    /// The model linearised about the steady state of a course.
    pub fn linear(&self, course: &Course) -> Result<Linear, MultibodyError> {
        Ok(self.linearise(&self.steady(course, None)?))
    }

    pub(super) fn state_names(&self, active: &[usize]) -> Vec<&'static str> {
        active
            .iter()
            .map(|&k| match k {
                place::ANGULAR if self.no_slip => "roll_rate_rad_s",
                place::VELOCITY if self.no_slip => "speed_m_s",
                _ => NAMES[k],
            })
            .collect()
    }

    /// The Jacobian times each column of `basis`.
    pub(super) fn jacobian(
        &self,
        steady: &Steady,
        active: &[usize],
        basis: &DMatrix<f64>,
    ) -> DMatrix<f64> {
        columns(active.len(), basis.ncols(), |pass| {
            let mut r: Reduced<Directional> = steady.reduced.map(Dual::constant);
            for (i, &k) in active.iter().enumerate() {
                for (slot, column) in pass.clone().enumerate() {
                    r[k].eps[slot] = basis[(i, column)];
                }
            }
            let d = self.reduced_rhs(&r, &steady.input.lifted());
            active.iter().map(|&k| d[k]).collect()
        })
    }

    fn input_matrix(&self, steady: &Steady, active: &[usize]) -> DMatrix<f64> {
        columns(active.len(), INPUTS.len(), |pass| {
            let mut input: Input<Directional> = steady.input.lifted();
            for (slot, column) in pass.enumerate() {
                input.place(column).eps[slot] = 1.0;
            }
            let r: Reduced<Directional> = steady.reduced.map(Dual::constant);
            let d = self.reduced_rhs(&r, &input);
            active.iter().map(|&k| d[k]).collect()
        })
    }
}

impl<T> Input<T> {
    /// The input at this place of [`INPUTS`].
    fn place(&mut self, at: usize) -> &mut T {
        let inputs: [&mut T; INPUTS.len()] = {
            let Input {
                steer_torque_nm,
                front_brake_nm,
                rear_traction_nm,
                moment_nm,
                trunk_torque_nm,
                leg_torque_nm,
                ..
            } = self;
            let [roll, _, _] = moment_nm;
            let [lean, pitch, twist] = trunk_torque_nm;
            let [left, right] = leg_torque_nm;
            [
                steer_torque_nm,
                front_brake_nm,
                rear_traction_nm,
                roll,
                lean,
                pitch,
                twist,
                left,
                right,
            ]
        };
        inputs
            .into_iter()
            .nth(at)
            .expect("a place of the list of inputs")
    }
}

impl Input<f64> {
    /// The same input as constants of another number type.
    pub fn lifted<T: Scalar>(&self) -> Input<T> {
        self.mapped(T::from_f64)
    }
}

impl<S: Scalar> Input<S> {
    /// The same input, each number by `f`.
    pub(super) fn mapped<T: Scalar>(&self, f: impl Fn(S) -> T + Copy) -> Input<T> {
        Input {
            front_brake_nm: f(self.front_brake_nm),
            rear_traction_nm: f(self.rear_traction_nm),
            steer_torque_nm: f(self.steer_torque_nm),
            trunk_torque_nm: self.trunk_torque_nm.map(f),
            leg_torque_nm: self.leg_torque_nm.map(f),
            force_n: self.force_n.map(f),
            force_at_m: self.force_at_m.map(f),
            moment_nm: self.moment_nm.map(f),
            wind_m_s: self.wind_m_s.map(f),
            rear_road_y_m_s: f(self.rear_road_y_m_s),
        }
    }
}
