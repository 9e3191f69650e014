//! What: the lateral part of a bicycle at one speed, with what a rider perceives and moves.
//!
//! Equation: x' = A x + Σ b_c T_c of the linearised model; rows that give roll, heading rate and the
//! angles of bar, trunk and knees.
//!
//! Source: `multibody::linearise`; yaw rate without slip: Meijaard et al. (2007), equation B7.
//!
//! Assumes and ignores: straight running at constant speed.
//!
//! Valid for: small motions.
//!
//! Checked by: `rider/tests`.

use crate::multibody::{Course, Linear, Multibody, MultibodyError};
use core::f64::consts::FRAC_1_SQRT_2;
use nalgebra::{DMatrix, DVector, RowDVector};

/// The lateral part of a bicycle at one speed and pair of motor torques, with what a rider
/// perceives and moves.
#[derive(Clone, Debug)]
pub struct LateralBicycle {
    pub(super) a: DMatrix<f64>,
    /// What torques on bar, trunk and knees do.
    pub(super) torque: [DVector<f64>; 3],
    /// Rows that give the angles of bar, trunk and knees, and their rates.
    pub(super) angle: [[RowDVector<f64>; 2]; 3],
    /// Rows that give roll, roll rate and yaw rate.
    pub(super) roll: RowDVector<f64>,
    pub(super) roll_rate: RowDVector<f64>,
    pub(super) yaw_rate: RowDVector<f64>,
}

impl LateralBicycle {
    /// The bicycle riding straight at `speed_m_s` under a pair of `pair_nm` at steady speed.
    ///
    /// # Errors
    /// If there is no steady state.
    pub fn new(model: &Multibody, speed_m_s: f64, pair_nm: f64) -> Result<Self, MultibodyError> {
        let linear = model.linear(&Course::pair(speed_m_s, pair_nm))?.lateral();
        let n = linear.names.len();
        let row = |terms: &[(&str, f64)]| {
            let mut row = RowDVector::zeros(n);
            for (name, factor) in terms {
                if let Some(i) = linear.index(name) {
                    row[i] = *factor;
                }
            }
            row
        };
        let roll = row(&[("roll_rad", 1.0)]);
        let g = &model.parameters().geometry;
        let (cos_tilt, wheelbase) = (libm::cos(g.steer_tilt_rad), g.wheelbase_m);
        let yaw_rate = if linear.index("angular_velocity_z_rad_s").is_some() {
            row(&[("angular_velocity_z_rad_s", 1.0)])
        } else {
            // Without slip: equation B7 of Meijaard et al. (2007).
            row(&[
                ("steer_rad", speed_m_s * cos_tilt / wheelbase),
                ("steer_rate_rad_s", g.trail_m * cos_tilt / wheelbase),
            ])
        };
        Ok(Self {
            torque: [
                column(&linear, &[("steer_torque_nm", 1.0)]),
                column(&linear, &[("trunk_lean_torque_nm", 1.0)]),
                column(
                    &linear,
                    &[("left_leg_torque_nm", -1.0), ("right_leg_torque_nm", 1.0)],
                ),
            ],
            angle: [
                [
                    row(&[("steer_rad", 1.0)]),
                    row(&[("steer_rate_rad_s", 1.0)]),
                ],
                [
                    row(&[("trunk_lean_rad", 1.0)]),
                    row(&[("trunk_lean_rate_rad_s", 1.0)]),
                ],
                [
                    row(&[("legs_swing_rad", FRAC_1_SQRT_2)]),
                    row(&[("legs_swing_rate_rad_s", FRAC_1_SQRT_2)]),
                ],
            ],
            roll_rate: &roll * &linear.a,
            roll,
            yaw_rate,
            a: linear.a,
        })
    }
}

impl LateralBicycle {
    /// Number of its states.
    pub fn order(&self) -> usize {
        self.a.nrows()
    }

    /// State matrix.
    pub fn state_matrix(&self) -> &DMatrix<f64> {
        &self.a
    }

    /// What a torque on the bar does to the derivative of the state, per Nm.
    pub fn steer_torque(&self) -> &DVector<f64> {
        &self.torque[0]
    }

    /// Rows that give roll, roll rate, steer and steer rate.
    pub fn perceived(&self) -> [RowDVector<f64>; 4] {
        let [steer, steer_rate] = &self.angle[0];
        [
            self.roll.clone(),
            self.roll_rate.clone(),
            steer.clone(),
            steer_rate.clone(),
        ]
    }
}

fn column(linear: &Linear, terms: &[(&str, f64)]) -> DVector<f64> {
    let mut sum = DVector::zeros(linear.a.nrows());
    for (name, factor) in terms {
        if let Some(j) = crate::multibody::INPUTS.iter().position(|n| n == name) {
            sum += linear.b.column(j) * *factor;
        }
    }
    sum
}
