//! What: a wheel that rolls without slip.
//!
//! Equation: the velocity of the contact point is zero along x and y; the multibody model solves
//! for the forces that keep it so. This entry gives no force of its own.
//!
//! Source: Meijaard, Papadopoulos, Ruina and Schwab (2007), Proc. R. Soc. A 463, section 2.
//!
//! Assumes and ignores: a knife-edge wheel, unlimited friction, no moment in the contact.
//!
//! Valid for: comparison with the benchmark bicycle; slip angles far below 1°.
//!
//! Checked by: the conformance suite of this module; the benchmark's eigenvalues in `multibody`.

use super::contact::{TyreError, Vertical};
use super::{TyreInput, TyreModel, TyreOutput};
use crate::Scalar;
use crate::explain::Explain;
use serde::{Deserialize, Serialize};

/// A wheel that rolls without slip, by constraint.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NoSlip {}

impl TyreModel for NoSlip {
    #[inline(always)]
    fn output<T: Scalar>(&self, _: &TyreInput<T>) -> TyreOutput<T> {
        TyreOutput::zero()
    }
    fn vertical(&self) -> Vertical {
        Vertical {
            stiffness_n_m: f64::INFINITY,
            damping_n_s_m: 0.0,
        }
    }
    fn relaxation_length_m(&self) -> Option<f64> {
        None
    }
    fn nominal_load_n(&self) -> f64 {
        f64::INFINITY
    }
    fn is_constraint(&self) -> bool {
        true
    }
    fn validate(&self) -> Result<(), TyreError> {
        Ok(())
    }
    fn explain(&self) -> Explain {
        Explain {
            name: "no_slip",
            what: "a knife-edge wheel that rolls without slip, by constraint",
            equation: "the velocity of the contact point is zero along x and y; the multibody model solves for the forces",
            source: "Meijaard, Papadopoulos, Ruina and Schwab (2007), Proc. R. Soc. A 463, section 2",
            assumes: "unlimited friction, no moment in the contact; holds for slip angles far below 1 degree",
        }
    }
}
