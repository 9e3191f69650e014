//! Tyres: what the road does to a wheel at its contact point.
//!
//! One file per model. All read a [`TyreInput`] and give a [`TyreOutput`] in the contact frame
//! (x forward along the wheel plane, y to the right, z down), after Meijaard et al. (2007) rather
//! than the ISO frame (y left, z up) of most tyre files; each model converts its own source.

mod contact;
mod linear;
mod magic_formula;
mod magic_formula_1989;
mod no_slip;
mod sets;

#[cfg(test)]
mod conformance;
#[cfg(test)]
mod dual;
#[cfg(test)]
mod figures;

pub use contact::{Combined, Friction, TyreError, Vertical};
pub use linear::LinearTyre;
pub use magic_formula::{LateralForm, MagicFormula};
pub use magic_formula_1989::MagicFormula1989;
pub use no_slip::NoSlip;
pub use sets::{SETS, TyreSet, set};

use crate::Scalar;
use crate::explain::Explain;
use serde::{Deserialize, Serialize};

/// State of a wheel at its contact point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TyreInput<T> {
    /// Load of the road on the wheel, N. At or below zero the wheel is off the ground and every
    /// force is zero.
    pub load_n: T,
    /// Longitudinal slip (ω r - v_x) / |v_x|: positive when driving, -1 with the wheel locked.
    pub slip_ratio: T,
    /// Slip angle atan(v_y / |v_x|) of the contact point: positive when it slides to the right.
    pub slip_angle_rad: T,
    /// Camber: positive when the wheel leans to the right, seen in the contact frame.
    pub camber_rad: T,
    /// Forward speed of the contact point along the contact frame's x, signed, m/s. Only rolling
    /// resistance reads it, to know which way the wheel rolls.
    pub speed_m_s: T,
    /// Friction coefficient of the road at this spot; [`Friction`] says how it acts.
    pub friction_ratio: T,
    /// Radius of the wheel, m.
    pub radius_m: f64,
}

/// Forces and moments of the road on the wheel at the contact point, contact frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TyreOutput<T> {
    /// Along x, N: positive drives the bicycle.
    pub longitudinal_n: T,
    /// Along y, N: positive pushes the bicycle to the right.
    pub lateral_n: T,
    /// About x (forward), Nm.
    pub overturning_nm: T,
    /// Against forward rolling, Nm: positive slows a wheel that rolls forward.
    pub rolling_resistance_nm: T,
    /// About z (down), Nm: self-aligning plus twisting torque; positive turns the wheel right.
    pub aligning_nm: T,
    /// Derivative of the force along x with respect to the slip ratio, N: how fast a wheel's creep
    /// dies out.
    pub longitudinal_stiffness_n: T,
}

impl<T: Scalar> TyreOutput<T> {
    /// No force, no moment.
    #[inline]
    pub fn zero() -> Self {
        let zero = T::zero();
        Self {
            longitudinal_n: zero,
            lateral_n: zero,
            overturning_nm: zero,
            rolling_resistance_nm: zero,
            aligning_nm: zero,
            longitudinal_stiffness_n: zero,
        }
    }
}

/// A tyre.
pub trait TyreModel {
    /// Forces and moments at a contact point. Total: finite input gives finite output.
    fn output<T: Scalar>(&self, input: &TyreInput<T>) -> TyreOutput<T>;
    /// Vertical spring and damper.
    fn vertical(&self) -> Vertical;
    /// Distance over which side slip builds up, m; `None` if force follows slip at once.
    fn relaxation_length_m(&self) -> Option<f64>;
    /// Load at which the tyre was measured, N.
    fn nominal_load_n(&self) -> f64;
    /// True if the wheel is held by constraints instead of forces.
    fn is_constraint(&self) -> bool;
    /// Refuses parameters that no tyre can have.
    fn validate(&self) -> Result<(), TyreError>;
    /// What `twinhub explain` says.
    fn explain(&self) -> Explain;
}

twinhub_types::registry! {
    /// Every tyre that a bicycle can ride on.
    #[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
    #[serde(rename_all = "snake_case")]
    pub enum Tyre: TyreModel {
        /// Magic Formula of Bulsink (2017), appendix A.2.
        MagicFormula(MagicFormula) = "magic_formula",
        /// Forces proportional to slip, camber and load.
        Linear(LinearTyre) = "linear",
        /// Magic Formula of 1989, with sets for an e-bike tyre.
        #[serde(rename = "magic_formula_1989")]
        MagicFormula1989(MagicFormula1989) = "magic_formula_1989",
        /// A wheel that rolls without slip, by constraint.
        NoSlip(NoSlip) = "no_slip",
    }
    fn output[T: Scalar](&self, input: &TyreInput<T>) -> TyreOutput<T>;
    fn vertical(&self) -> Vertical;
    fn relaxation_length_m(&self) -> Option<f64>;
    fn nominal_load_n(&self) -> f64;
    fn is_constraint(&self) -> bool;
    fn validate(&self) -> Result<(), TyreError>;
    fn explain(&self) -> Explain;
}

/// The explanation of the registry entry or set called `name`.
pub fn explain(name: &str) -> Option<Explain> {
    set(name).map(|set| set.tyre.explain())
}
