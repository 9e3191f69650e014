//! What: forces proportional to slip, camber and load; the tyre of linear stability analysis.
//!
//! Equation: Fx = c_κ Fz κ, Fy = Fz (-c_α α + c_γ γ), Mz = Fz (t c_α α + m_t γ),
//! Mx = -Fz r_c γ, and the rolling resistance q r Fz.
//!
//! Source: the slopes at the origin of the Magic Formula (Bulsink 2017, equations 3.2 and
//! A2.1-A2.19); the form is that of Sharp (2008), Appl. Mech. Rev. 61, 060803.
//!
//! Assumes and ignores: no friction limit (friction of the road is not read), no combined slip,
//! stiffness proportional to load.
//!
//! Valid for: slip angles and camber below about 3°, |slip| below 0.03, loads near the one that the
//! slopes were taken at.
//!
//! Checked by: the conformance suite; equal slopes to `magic_formula` at 400 N (1e-9 relative).

use super::contact::{self, TyreError, Vertical};
use super::{TyreInput, TyreModel, TyreOutput};
use crate::Scalar;
use crate::explain::Explain;
use serde::{Deserialize, Serialize};

/// Forces proportional to slip, camber and load.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LinearTyre {
    /// Load at which the slopes were taken, N. Forces do not read it.
    pub nominal_load_n: f64,
    /// Longitudinal force per load and slip c_κ, zero or above.
    pub longitudinal_stiffness_ratio: f64,
    /// Side force per load and slip angle c_α, 1/rad, zero or above.
    pub cornering_stiffness_per_rad: f64,
    /// Side force per load and camber c_γ, 1/rad.
    pub camber_stiffness_per_rad: f64,
    /// Pneumatic trail t, m: the side-slip force acts this far behind the contact point.
    pub pneumatic_trail_m: f64,
    /// Twisting torque per load and camber m_t, m/rad; positive steers into the lean.
    pub twisting_m_per_rad: f64,
    /// Radius of the tyre's cross section r_c, m.
    pub crown_radius_m: f64,
    /// Rolling resistance moment per load and wheel radius.
    pub rolling_resistance_ratio: f64,
    /// Vertical spring and damper.
    pub vertical: Vertical,
    /// Distance over which side slip builds up, m; absent: none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub relaxation_length_m: Option<f64>,
}

impl TyreModel for LinearTyre {
    #[inline(always)]
    fn output<T: Scalar>(&self, input: &TyreInput<T>) -> TyreOutput<T> {
        let fz = contact::load(input.load_n);
        let (alpha, gamma) = (input.slip_angle_rad, input.camber_rad);
        let side_slip = -(fz * alpha).scale(self.cornering_stiffness_per_rad);
        let lean = fz * gamma;
        TyreOutput {
            longitudinal_n: (fz * input.slip_ratio).scale(self.longitudinal_stiffness_ratio),
            lateral_n: side_slip + lean.scale(self.camber_stiffness_per_rad),
            overturning_nm: -lean.scale(self.crown_radius_m),
            rolling_resistance_nm: contact::rolling(
                fz,
                input.speed_m_s,
                input.radius_m,
                self.rolling_resistance_ratio,
            ),
            aligning_nm: lean.scale(self.twisting_m_per_rad)
                - side_slip.scale(self.pneumatic_trail_m),
            longitudinal_stiffness_n: fz.scale(self.longitudinal_stiffness_ratio),
        }
    }
    fn vertical(&self) -> Vertical {
        self.vertical
    }
    fn relaxation_length_m(&self) -> Option<f64> {
        self.relaxation_length_m
    }
    fn nominal_load_n(&self) -> f64 {
        self.nominal_load_n
    }
    fn is_constraint(&self) -> bool {
        false
    }
    fn validate(&self) -> Result<(), TyreError> {
        contact::positive("nominal_load_n", self.nominal_load_n)?;
        contact::not_negative(
            "longitudinal_stiffness_ratio",
            self.longitudinal_stiffness_ratio,
        )?;
        contact::not_negative(
            "cornering_stiffness_per_rad",
            self.cornering_stiffness_per_rad,
        )?;
        contact::finite("camber_stiffness_per_rad", self.camber_stiffness_per_rad)?;
        contact::finite("pneumatic_trail_m", self.pneumatic_trail_m)?;
        contact::finite("twisting_m_per_rad", self.twisting_m_per_rad)?;
        contact::not_negative("crown_radius_m", self.crown_radius_m)?;
        contact::not_negative("rolling_resistance_ratio", self.rolling_resistance_ratio)?;
        if let Some(length) = self.relaxation_length_m {
            contact::positive("relaxation_length_m", length)?;
        }
        self.vertical.validate()
    }
    fn explain(&self) -> Explain {
        Explain {
            name: "linear",
            what: "forces proportional to slip, camber and load, for linear stability analysis",
            equation: "Fx = c_kappa Fz kappa, Fy = Fz (-c_alpha alpha + c_gamma gamma), Mz = Fz (t c_alpha alpha + m_t gamma), Mx = -Fz r_c gamma, rolling resistance q r Fz",
            source: "slopes of Bulsink (2017), table A3, at 400 N; form of Sharp (2008), Appl. Mech. Rev. 61, 060803",
            assumes: "no friction limit, no combined slip, stiffness proportional to load; holds for slip and camber below about 3 degrees and loads near the nominal one",
        }
    }
}
