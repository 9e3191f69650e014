//! What: the Magic Formula of 1989 (polynomials in load, curvature factor, offsets), as fitted to
//! bicycle tyres on the VeTyT rig.
//!
//! Equation (camber g and slip a in degrees, Fz in kN, coefficients x counted from 1):
//! ```text
//! y = D sin(C atan(B X - E (B X - atan(B X)))) + Sv,  X = a + Sh,  B = BCD / (C D)
//! Fy: C = x1, D = x2 Fz² + x3 Fz, BCD = x4 sin(2 atan(Fz / x5)) (1 - x6 |g|),
//!     E = x7 Fz + x8, Sh = x9 g + x10 Fz + x11, Sv = x12 Fz g + x13 Fz + x14
//! Mz: C = x1, D = x2 Fz² + x3 Fz, BCD = (x4 Fz² + x5 Fz) (1 - x7 |g|) exp(-x6 Fz),
//!     E = (x8 Fz² + x9 Fz + x10) (1 - x11 |g|),
//!     Sh = x12 g + x13 Fz + x14, Sv = (x15 Fz² + x16 Fz) g + x17 Fz + x18
//! ```
//! Fy points right for slip that is negative in the contact frame (a = -α), Mz is about z down.
//!
//! Source: Bakker, Pacejka and Lidner (1989), SAE 890087; coefficients of the Schwalbe Energizer
//! Plus 28x1.75 measured on the VeTyT rig (Politecnico di Milano), as published with the
//! mechmotum bicycle-kickplate-model (J. K. Moore).
//!
//! Assumes and ignores: longitudinal force, overturning moment and rolling resistance were not
//! measured and are those of Bulsink (2017). The offsets Sh and Sv (ply steer, conicity, rig) pull
//! a straight upright bicycle to one side unless `remove_offsets` is set.
//!
//! Valid for: slip angles within `slip_angle_limit_rad` and loads within `load_range_n`. Beyond,
//! slip angle and coefficients are held and forces are proportional to load: the polynomials
//! change sign (the side force at 400 kPa beyond 1.5 kN), and the curves turn over.
//!
//! Checked by: values of an independent evaluation of the formula (1e-9 relative), the conformance
//! suite with offsets removed.

use super::contact::{self, Combined, Friction, TyreError, Vertical};
use super::{TyreInput, TyreModel, TyreOutput};
use crate::Scalar;
use serde::{Deserialize, Serialize};

const DEGREES: f64 = 180.0 / core::f64::consts::PI;

/// Magic Formula of 1989.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MagicFormula1989 {
    /// Load around which the tyre was measured, N. Forces do not read it.
    pub nominal_load_n: f64,
    /// Coefficients x1 to x14 of side force (N, degrees, kN).
    pub side_force: [f64; 14],
    /// Coefficients x1 to x18 of the moment about z (Nm, degrees, kN).
    pub aligning: [f64; 18],
    /// Leaves out the offsets x10, x11, x13, x14 of side force and x13, x14, x17, x18 of the moment.
    pub remove_offsets: bool,
    /// Slip angle beyond which forces are held, rad.
    pub slip_angle_limit_rad: f64,
    /// Coefficients follow load within these bounds, N, and are held outside.
    pub load_range_n: [f64; 2],
    /// Longitudinal force per load and slip.
    pub longitudinal_stiffness_ratio: f64,
    /// Longitudinal friction of the tyre.
    pub longitudinal_friction_ratio: f64,
    /// Rolling resistance moment over load and radius.
    pub rolling_resistance_ratio: f64,
    /// Crown radius over wheel radius, giving the overturning moment.
    pub overturning_ratio: f64,

    /// Scales longitudinal stiffness; 1 as measured.
    #[serde(default = "contact::one")]
    pub longitudinal_gain: f64,
    /// Scales cornering stiffness; 1 as measured.
    #[serde(default = "contact::one")]
    pub cornering_gain: f64,
    /// Scales the side force due to camber; 1 as measured.
    #[serde(default = "contact::one")]
    pub camber_gain: f64,
    /// Scales the moment due to side slip; 1 as measured.
    #[serde(default = "contact::one")]
    pub trail_gain: f64,
    /// Scales the moment due to camber; 1 as measured.
    #[serde(default = "contact::one")]
    pub twisting_gain: f64,
    /// Scales overturning moment; 1 as measured.
    #[serde(default = "contact::one")]
    pub overturning_gain: f64,

    /// How the friction of the road acts.
    pub friction: Friction,
    /// How longitudinal slip takes away side force.
    pub combined: Combined,
    /// Vertical spring and damper.
    pub vertical: Vertical,
    /// Distance over which side slip builds up, m; absent: none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub relaxation_length_m: Option<f64>,
}

/// sin(C atan(B X - E (B X - atan(B X)))).
#[inline]
fn curve<T: Scalar>(c: f64, bx: T, e: T) -> T {
    let bent = bx - e * (bx - bx.atan());
    bent.atan().scale(c).sin()
}

impl MagicFormula1989 {
    /// Side force at load `f` (kN), slip `a` and camber `g` (degrees), road friction `mu`.
    #[inline]
    fn side<T: Scalar>(&self, f: T, a: T, g: T, mu: T) -> T {
        let x = &self.side_force;
        let keep = if self.remove_offsets { 0.0 } else { 1.0 };
        let own = f * (f.scale(x[1]) + T::from_f64(x[2]));
        let d = mu * match self.friction {
            Friction::AsFile => own,
            Friction::Absolute => f.scale(1000.0),
        };
        // sin(2 atan q) = 2 q / (1 + q²)
        let q = f.scale(1.0 / x[4]);
        let bcd = q.scale(2.0 * x[3] * self.cornering_gain) / (T::one() + q * q)
            * (T::one() - g.abs().scale(x[5]));
        let e = f.scale(x[6]) + T::from_f64(x[7]);
        let sh = g.scale(x[8] * self.camber_gain) + (f.scale(x[9]) + T::from_f64(x[10])).scale(keep);
        let sv = (f * g).scale(x[11] * self.camber_gain)
            + (f.scale(x[12]) + T::from_f64(x[13])).scale(keep);
        d * curve(x[0], bcd * (a + sh) / d.scale(x[0]), e) + sv
    }

    /// Moment about z at load `f` (kN), slip `a` and camber `g` (degrees).
    #[inline]
    fn moment<T: Scalar>(&self, f: T, a: T, g: T) -> T {
        let x = &self.aligning;
        let keep = if self.remove_offsets { 0.0 } else { 1.0 };
        let d = f * (f.scale(x[1]) + T::from_f64(x[2]));
        let bcd = f * (f.scale(x[3]) + T::from_f64(x[4]))
            * (T::one() - g.abs().scale(x[6]))
            * (-f.scale(x[5])).exp();
        let e = (f * (f.scale(x[7]) + T::from_f64(x[8])) + T::from_f64(x[9]))
            * (T::one() - g.abs().scale(x[10]));
        let sh = g.scale(x[11] * self.twisting_gain)
            + (f.scale(x[12]) + T::from_f64(x[13])).scale(keep);
        let sv = (f * g * (f.scale(x[14]) + T::from_f64(x[15]))).scale(self.twisting_gain)
            + (f.scale(x[16]) + T::from_f64(x[17])).scale(keep);
        (d * curve(x[0], bcd * (a + sh) / d.scale(x[0]), e)).scale(self.trail_gain) + sv
    }
}

impl TyreModel for MagicFormula1989 {
    #[inline]
    fn output<T: Scalar>(&self, input: &TyreInput<T>) -> TyreOutput<T> {
        let fz = contact::load(input.load_n);
        let [low, high] = self.load_range_n;
        let fe = fz.clamp(T::from_f64(low), T::from_f64(high));
        let per_load = fz / fe;
        let limit = T::from_f64(self.slip_angle_limit_rad);
        let a = (-input.slip_angle_rad).clamp(-limit, limit).scale(DEGREES);
        let g = input.camber_rad.scale(DEGREES);
        let f = fe.scale(1.0e-3);

        let road = contact::road(input.friction_ratio);
        let mu_x = match self.friction {
            Friction::AsFile => road.scale(self.longitudinal_friction_ratio),
            Friction::Absolute => road,
        };
        let stiffness = self.longitudinal_stiffness_ratio * self.longitudinal_gain;
        let (sine, cosine) = contact::shape(1.0, input.slip_ratio.scale(stiffness) / mu_x);
        let left = self.combined.side_force_ratio(cosine) * per_load;

        let lean = (fz * input.camber_rad).scale(input.radius_m);
        TyreOutput {
            longitudinal_n: mu_x * fz * sine,
            lateral_n: left * self.side(f, a, g, road),
            overturning_nm: -lean.scale(self.overturning_ratio * self.overturning_gain),
            rolling_resistance_nm: contact::rolling(
                fz,
                input.speed_m_s,
                input.radius_m,
                self.rolling_resistance_ratio,
            ),
            aligning_nm: left * self.moment(f, a, g),
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
        self.vertical.validate()
    }
}
