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
//! Against Bulsink (2017), these sets have next to no twisting torque: between 300 and 600 N and
//! 5° of camber the whole camber moment stays below a quarter of that of table A3.
//!
//! Valid for: slip angles and camber within `slip_angle_limit_rad` and `camber_limit_rad`, loads
//! within `load_range_n`. Beyond, angles and coefficients are held and forces are proportional to
//! load: the polynomials change sign (the side force at 400 kPa beyond 1.5 kN), and the curves
//! turn over. The source gives 1000 N as the upper limit; the other limits are ours.
//!
//! Checked by: values of an independent evaluation of the formula (1e-9 relative), the conformance
//! suite with offsets removed.

use super::contact::{self, Combined, Friction, TyreError, Vertical};
use super::{TyreInput, TyreModel, TyreOutput};
use crate::Scalar;
use crate::explain::Explain;
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
    /// Slip angle (with its shift, over the road's friction) beyond which forces are held, rad.
    pub slip_angle_limit_rad: f64,
    /// Camber beyond which forces are held, rad.
    pub camber_limit_rad: f64,
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
#[inline(always)]
fn curve<T: Scalar>(c: f64, bx: T, e: T) -> T {
    let bent = bx - e * (bx - bx.atan());
    bent.atan().scale(c).sin()
}

impl MagicFormula1989 {
    /// Friction at hand over the tyre's own at load `f` (kN).
    #[inline(always)]
    fn friction_left<T: Scalar>(&self, f: T, road: T) -> T {
        match self.friction {
            Friction::AsFile => road,
            Friction::Absolute => {
                let x = &self.side_force;
                road.scale(1000.0) / (f.scale(x[1]) + T::from_f64(x[2]))
            }
        }
    }

    /// `angle` + shift (degrees) over friction, held at the limit. Peaks scale with friction and
    /// slopes stay: s F(X / s), the similarity method of Pacejka (2012), section 4.1.
    #[inline(always)]
    fn similar<T: Scalar>(&self, x: T, s: T) -> T {
        let limit = T::from_f64(self.slip_angle_limit_rad * DEGREES);
        (x / s).clamp(-limit, limit)
    }

    /// Side force at load `f` (kN), slip `a` and camber `g` (degrees), with `s` of the friction.
    #[inline(always)]
    fn side<T: Scalar>(&self, f: T, a: T, g: T, s: T) -> T {
        let x = &self.side_force;
        let keep = if self.remove_offsets { 0.0 } else { 1.0 };
        let d = f * (f.scale(x[1]) + T::from_f64(x[2]));
        // sin(2 atan q) = 2 q / (1 + q²)
        let q = f.scale(1.0 / x[4]);
        let bcd = q.scale(2.0 * x[3] * self.cornering_gain) / (T::one() + q * q)
            * (T::one() - g.abs().scale(x[5]));
        let e = f.scale(x[6]) + T::from_f64(x[7]);
        let sh =
            g.scale(x[8] * self.camber_gain) + (f.scale(x[9]) + T::from_f64(x[10])).scale(keep);
        let sv = (f * g).scale(x[11] * self.camber_gain)
            + (f.scale(x[12]) + T::from_f64(x[13])).scale(keep);
        let bx = bcd * self.similar(a + sh, s) / d.scale(x[0]);
        let limit = s * (d + sv.abs());
        (s * d * curve(x[0], bx, e) + sv).clamp(-limit, limit)
    }

    /// Moment about z at load `f` (kN), slip `a` and camber `g` (degrees), with `s` of the friction.
    #[inline(always)]
    fn moment<T: Scalar>(&self, f: T, a: T, g: T, s: T) -> T {
        let x = &self.aligning;
        let keep = if self.remove_offsets { 0.0 } else { 1.0 };
        let d = f * (f.scale(x[1]) + T::from_f64(x[2]));
        let bcd = f
            * (f.scale(x[3]) + T::from_f64(x[4]))
            * (T::one() - g.abs().scale(x[6]))
            * (-f.scale(x[5])).exp();
        let e = (f * (f.scale(x[7]) + T::from_f64(x[8])) + T::from_f64(x[9]))
            * (T::one() - g.abs().scale(x[10]));
        let sh =
            g.scale(x[11] * self.twisting_gain) + (f.scale(x[12]) + T::from_f64(x[13])).scale(keep);
        let sv = (f * g * (f.scale(x[14]) + T::from_f64(x[15]))).scale(self.twisting_gain)
            + (f.scale(x[16]) + T::from_f64(x[17])).scale(keep);
        let bx = bcd * self.similar(a + sh, s) / d.scale(x[0]);
        (s * d * curve(x[0], bx, e)).scale(self.trail_gain) + sv
    }
}

impl TyreModel for MagicFormula1989 {
    #[inline(always)]
    fn output<T: Scalar>(&self, input: &TyreInput<T>) -> TyreOutput<T> {
        let fz = contact::load(input.load_n);
        let [low, high] = self.load_range_n;
        let fe = fz.clamp(T::from_f64(low), T::from_f64(high));
        let per_load = fz / fe;
        let a = -input.slip_angle_rad.scale(DEGREES);
        let lean_limit = T::from_f64(self.camber_limit_rad);
        let g = input
            .camber_rad
            .clamp(-lean_limit, lean_limit)
            .scale(DEGREES);
        let f = fe.scale(1.0e-3);

        let road = contact::road(input.friction_ratio);
        let s = self.friction_left(f, road);
        let mu_x = match self.friction {
            Friction::AsFile => road.scale(self.longitudinal_friction_ratio),
            Friction::Absolute => road,
        };
        let stiffness = self.longitudinal_stiffness_ratio * self.longitudinal_gain;
        let bx_kappa = input.slip_ratio.scale(stiffness) / mu_x;
        let (sine, cosine) = contact::shape(1.0, bx_kappa);
        let left = self.combined.side_force_ratio(cosine) * per_load;

        let lean = (fz * input.camber_rad).scale(input.radius_m);
        TyreOutput {
            longitudinal_n: mu_x * fz * sine,
            lateral_n: left * self.side(f, a, g, s),
            overturning_nm: -lean.scale(self.overturning_ratio * self.overturning_gain),
            rolling_resistance_nm: contact::rolling(
                fz,
                input.speed_m_s,
                input.radius_m,
                self.rolling_resistance_ratio,
            ),
            aligning_nm: left * self.moment(f, a, g, s),
            longitudinal_stiffness_n: contact::slope(fz.scale(stiffness), bx_kappa, cosine),
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
        for value in self.side_force {
            contact::finite("side_force", value)?;
        }
        for value in self.aligning {
            contact::finite("aligning", value)?;
        }
        contact::within("side_force[0]", self.side_force[0], 0.1, 4.0, "0.1 to 4")?;
        contact::within("aligning[0]", self.aligning[0], 0.1, 4.0, "0.1 to 4")?;
        contact::positive("side_force[4]", self.side_force[4])?;
        let quarter = core::f64::consts::FRAC_PI_2;
        let angle = |name, value| contact::within(name, value, 1e-3, quarter, "0.001 to pi/2");
        angle("slip_angle_limit_rad", self.slip_angle_limit_rad)?;
        angle("camber_limit_rad", self.camber_limit_rad)?;
        let [low, high] = self.load_range_n;
        contact::positive("load_range_n[0]", low)?;
        contact::within(
            "load_range_n[1]",
            high,
            low,
            f64::MAX,
            "at least load_range_n[0]",
        )?;
        for load_n in [low, high] {
            let f = 1e-3 * load_n;
            let peak = |x: &[f64]| x[1] * f + x[2];
            contact::positive(
                "peak side force at the ends of load_range_n",
                peak(&self.side_force),
            )?;
            contact::positive(
                "peak moment at the ends of load_range_n",
                peak(&self.aligning),
            )?;
        }
        for (name, value) in [
            (
                "longitudinal_stiffness_ratio",
                self.longitudinal_stiffness_ratio,
            ),
            ("rolling_resistance_ratio", self.rolling_resistance_ratio),
            ("overturning_ratio", self.overturning_ratio),
        ] {
            contact::not_negative(name, value)?;
        }
        contact::positive(
            "longitudinal_friction_ratio",
            self.longitudinal_friction_ratio,
        )?;
        for (name, value) in [
            ("longitudinal_gain", self.longitudinal_gain),
            ("cornering_gain", self.cornering_gain),
            ("camber_gain", self.camber_gain),
            ("trail_gain", self.trail_gain),
            ("twisting_gain", self.twisting_gain),
            ("overturning_gain", self.overturning_gain),
        ] {
            contact::gain(name, value)?;
        }
        if let Some(length) = self.relaxation_length_m {
            contact::positive("relaxation_length_m", length)?;
        }
        self.vertical.validate()
    }
    fn explain(&self) -> Explain {
        Explain {
            name: "magic_formula_1989",
            what: "the Magic Formula of 1989 with curvature and offsets, fitted to an e-bike city tyre at three pressures",
            equation: "y = D sin(C atan(B X - E (B X - atan(B X)))) + Sv, X = a + Sh, with polynomials in load for every coefficient",
            source: "Bakker, Pacejka and Lidner (1989), SAE 890087; Schwalbe Energizer Plus 28x1.75 on the VeTyT rig (Politecnico di Milano), coefficients from the mechmotum bicycle-kickplate-model (J. K. Moore)",
            assumes: "longitudinal force, overturning moment and rolling resistance borrowed from Bulsink (2017); offsets pull to one side unless remove_offsets; slip angle, camber and load are held at their limits, chosen by us at 10 degrees, 30 degrees, 200 and 1000 N (the source gives 1000 N only)",
        }
    }
}
