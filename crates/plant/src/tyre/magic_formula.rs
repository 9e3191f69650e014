//! What: the Magic Formula of bicycle tyres, without curvature factor, with load dependence.
//!
//! Equation (ISO axes of the source: y left, z up; symbols and signs of the coefficients as there):
//! ```text
//! df  = (Fz - Fz0) / Fz0
//! Fx  = μx Fz sin(Cx atan(Bx κ)),  Bx = Kκ / (Cx μx Fz),  Kκ = PKX1 Fz          (A2.1, A2.2)
//! Fy  = Dy sin(Cα atan(Bα α) + Cγ atan(Bγ γ)),  Dy = PDY1 exp(PDY2 df) Fz    (A2.3 to A2.7)
//! Kα  = Kαmax Fz0 sin(atan(Fz / (Kαpeak Fz0))),  Bα = Kα / (Cα Dy)           (A2.8, A2.9)
//! Kγ  = Fz (Kγ1 + Kγ2 df),  Bγ = Kγ / (Cγ Dy)                              (A2.10, A2.11)
//! Tz  = -t Fy(α, γ = 0) + Fz r (DTT1 + DTT2 df) γ                          (A2.12 to A2.17)
//! t   = Fz r / Fz0 (Dt1 + Dt2 df) cos(Ct atan((Bt1 + Bt2 df) α)) cos(α)
//! Ty  = -r Fz DTy,  Tx = -Fz r DTx γ                                       (A2.18, A2.19)
//! ```
//! The appendix prints a second sine inside f(α) and g(γ) (A2.4, A2.5). The tyre property file of
//! the source feeds the motorcycle tyre of Adams, which has none (Pacejka 2012, Tire and Vehicle
//! Dynamics, equation 11.32); [`LateralForm`] offers both. Slopes at the origin are the same.
//!
//! Source: Bulsink (2017), Bicycling stability, thesis, University of Twente, appendix A.2 and
//! table A3; measurements by Doria et al. (2013), Vehicle System Dynamics 51, 405-420.
//!
//! Assumes and ignores: longitudinal slip was never measured (PKX1 is the low end of motorcycle
//! tyres); the twisting torque knows no friction limit of its own; combined slip is not in the
//! source and is an option, which takes from side force and both parts of Tz alike; curvature and
//! offsets are zero.
//!
//! Valid for: 400 to 600 N, slip angles to about 6°, camber to about 25°. Extrapolated, the
//! pneumatic trail turns over at 902 N and the twisting torque at 1038 N; `load_range_n` holds the
//! coefficients instead.
//!
//! Checked by: stiffnesses, trail and moments at 400 and 600 N worked by hand from table A3
//! (1e-12 relative), the conformance suite.

use super::contact::{self, Combined, Friction, TyreError, Vertical};
use super::{TyreInput, TyreModel, TyreOutput};
use crate::Scalar;
use crate::explain::Explain;
use serde::{Deserialize, Serialize};

/// How side slip and camber add up.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum LateralForm {
    /// Fy = Dy sin(Cα atan(Bα α) + Cγ atan(Bγ γ)), the motorcycle tyre of Adams. Where the sum
    /// passes π/2 (much lean and slip, little friction) the force falls again.
    #[default]
    Motorcycle,
    /// As `motorcycle`, with the sum held at ±π/2 (smooth to the first derivative): force never
    /// falls with slip or lean.
    Saturating,
    /// Fy = Dy sin(sin(Cα atan(Bα α)) + sin(Cγ atan(Bγ γ))): the appendix to the letter. Peak
    /// force without camber is 0.84 Dy.
    AsPrinted,
}

/// Magic Formula of Bulsink (2017), appendix A.2. Names in brackets are those of the source's
/// tyre property file; signs are the source's (ISO axes).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MagicFormula {
    /// Load at which the tyre was measured Fz0, N.
    pub nominal_load_n: f64,
    /// Shape of longitudinal force Cx [PCX1].
    pub longitudinal_shape_ratio: f64,
    /// Longitudinal friction μx [PDX1].
    pub longitudinal_friction_ratio: f64,
    /// Longitudinal stiffness per load and slip Kκ / Fz [PKX1].
    pub longitudinal_stiffness_ratio: f64,
    /// Shape of side-slip force Cα [PCY1].
    pub slip_shape_ratio: f64,
    /// Shape of camber force Cγ [PCY2].
    pub camber_shape_ratio: f64,
    /// Lateral friction at Fz0 [PDY1].
    pub lateral_friction_ratio: f64,
    /// Exponent of lateral friction with load [PDY2].
    pub lateral_friction_load_ratio: f64,
    /// Largest cornering stiffness over Fz0, 1/rad, negative [PKY1].
    pub cornering_max_per_rad: f64,
    /// Load factor of cornering stiffness Kαpeak [PKY3].
    pub cornering_peak_ratio: f64,
    /// Camber stiffness over load at Fz0, 1/rad, negative pushes into the lean [PKY6].
    pub camber_stiffness_per_rad: f64,
    /// Its variation with df, 1/rad [PKY7].
    pub camber_stiffness_load_per_rad: f64,
    /// Slope factor of the pneumatic trail Bt1, 1/rad [QBZ1].
    pub trail_slope_per_rad: f64,
    /// Its variation with df, 1/rad [QBZ2].
    pub trail_slope_load_per_rad: f64,
    /// Shape of the pneumatic trail Ct [QCZ1].
    pub trail_shape_ratio: f64,
    /// Peak trail over wheel radius at Fz0, Dt1 [QDZ1].
    pub trail_peak_ratio: f64,
    /// Its variation with df [QDZ2].
    pub trail_peak_load_ratio: f64,
    /// Twisting torque over load and radius at Fz0, 1/rad, negative steers into the lean [QDZ8].
    pub twisting_per_rad: f64,
    /// Its variation with df, 1/rad [QDZ9].
    pub twisting_load_per_rad: f64,
    /// Rolling resistance moment over load and radius [QSY1].
    pub rolling_resistance_ratio: f64,
    /// Crown radius over wheel radius, giving the overturning moment [QSX2].
    pub overturning_ratio: f64,

    /// Scales longitudinal stiffness; 1 as measured.
    #[serde(default = "contact::one")]
    pub longitudinal_gain: f64,
    /// Scales cornering stiffness Kα; 1 as measured.
    #[serde(default = "contact::one")]
    pub cornering_gain: f64,
    /// Scales camber stiffness Kγ; 1 as measured.
    #[serde(default = "contact::one")]
    pub camber_gain: f64,
    /// Scales peak trail Dt; 1 as measured.
    #[serde(default = "contact::one")]
    pub trail_gain: f64,
    /// Scales twisting torque DTT; 1 as measured.
    #[serde(default = "contact::one")]
    pub twisting_gain: f64,
    /// Scales overturning moment DTx; 1 as measured.
    #[serde(default = "contact::one")]
    pub overturning_gain: f64,

    /// How the friction of the road acts.
    pub friction: Friction,
    /// How longitudinal slip takes away side force.
    pub combined: Combined,
    /// How side slip and camber add up.
    #[serde(default)]
    pub lateral_form: LateralForm,
    /// Coefficients as at this load, N, at every load: forces are then proportional to load. This
    /// is a tyre "measured at" that load, without load dependence. Absent: coefficients follow load.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub frozen_load_n: Option<f64>,
    /// Coefficients follow load within these bounds, N, and are held outside. Absent: no bounds.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub load_range_n: Option<[f64; 2]>,
    /// Vertical spring and damper.
    pub vertical: Vertical,
    /// Distance over which side slip builds up, m; absent: none (the source has none).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub relaxation_length_m: Option<f64>,
}

impl MagicFormula {
    /// Load at which coefficients are evaluated.
    #[inline(always)]
    fn coefficient_load<T: Scalar>(&self, fz: T) -> T {
        if let Some(frozen) = self.frozen_load_n {
            T::from_f64(frozen)
        } else if let Some([low, high]) = self.load_range_n {
            fz.clamp(T::from_f64(low), T::from_f64(high))
        } else {
            fz
        }
    }

    /// Side force over Dy: with side slip alone, and with camber. `u` = -Bα α, `w` = -Bγ γ are the
    /// arguments turned to the contact frame.
    #[inline(always)]
    fn lateral<T: Scalar>(&self, u: T, w: T) -> (T, T) {
        let (sa, ca) = contact::shape(self.slip_shape_ratio, u);
        let (sg, cg) = contact::shape(self.camber_shape_ratio, w);
        if self.lateral_form == LateralForm::AsPrinted {
            return (sa.sin(), (sa + sg).sin());
        }
        let sum = sa * cg + ca * sg;
        if self.lateral_form == LateralForm::Motorcycle {
            return (sa, sum);
        }
        let cosine = ca * cg - sa * sg;
        let held = (sa + sg).select(T::one(), T::from_f64(-1.0));
        (sa, cosine.select(sum, held))
    }
}

impl TyreModel for MagicFormula {
    #[inline(always)]
    fn output<T: Scalar>(&self, input: &TyreInput<T>) -> TyreOutput<T> {
        let (alpha, gamma, r) = (input.slip_angle_rad, input.camber_rad, input.radius_m);
        let fz = contact::load(input.load_n);
        let fe = self.coefficient_load(fz);
        let fz0 = self.nominal_load_n;
        let df = fe.scale(1.0 / fz0) - T::one();
        let linear =
            |at_nominal: f64, with_load: f64| T::from_f64(at_nominal) + df.scale(with_load);

        // μx = PDX1, μy = PDY1 exp(PDY2 df)                                              (A2.7)
        let road = contact::road(input.friction_ratio);
        let (mu_x, mu_y) = match self.friction {
            Friction::Absolute => (road, road),
            Friction::AsFile => (
                road.scale(self.longitudinal_friction_ratio),
                road.scale(self.lateral_friction_ratio)
                    * df.scale(self.lateral_friction_load_ratio).exp(),
            ),
        };

        // Fx = μx Fz sin(Cx atan(Kκ κ / (Cx μx Fz)))                               (A2.1, A2.2)
        let stiffness = self.longitudinal_stiffness_ratio * self.longitudinal_gain;
        let bx_kappa = input
            .slip_ratio
            .scale(stiffness / self.longitudinal_shape_ratio)
            / mu_x;
        let (sine, cosine) = contact::shape(self.longitudinal_shape_ratio, bx_kappa);
        let longitudinal_n = mu_x * fz * sine;
        let left = self.combined.side_force_ratio(cosine);

        // Kα / Fz = Kαmax Fz0 / √(Fz² + (Kαpeak Fz0)²), because sin(atan x) = x / √(1 + x²) (A2.8)
        let peak = self.cornering_peak_ratio * fz0;
        let peak = T::from_f64(peak * peak);
        let k_alpha =
            self.cornering_max_per_rad * self.cornering_gain * fz0 / self.slip_shape_ratio;
        let u = alpha.scale(k_alpha) / ((fe * fe + peak).sqrt() * mu_y);
        // Kγ / Fz = Kγ1 + Kγ2 df                                                        (A2.10)
        let k_gamma = linear(
            self.camber_stiffness_per_rad,
            self.camber_stiffness_load_per_rad,
        );
        let w = -(gamma * k_gamma).scale(self.camber_gain / self.camber_shape_ratio) / mu_y;
        // Fy = Dy sin(f(α) + g(γ))                                                       (A2.3)
        let dy = mu_y * fz * left;
        let (side_slip, side) = self.lateral(u, w);

        // t = Fz r / Fz0 (Dt1 + Dt2 df) cos(Ct atan(Bt α)) cos(α)               (A2.13 to A2.15)
        let bt = linear(self.trail_slope_per_rad, self.trail_slope_load_per_rad);
        let dt = linear(self.trail_peak_ratio, self.trail_peak_load_ratio);
        let (_, bell) = contact::shape(self.trail_shape_ratio, bt * alpha);
        let trail = fe * dt.scale(r / fz0 * self.trail_gain) * bell * alpha.cos();
        // Tz(γ) = Fz r (DTT1 + DTT2 df) γ                                       (A2.16, A2.17)
        let dtt = linear(self.twisting_per_rad, self.twisting_load_per_rad);
        let lean = (fz * gamma).scale(r);
        // It is slip across the patch: a tyre that slides along has none of it left.
        let twisting = -lean * dtt.scale(self.twisting_gain) * left;

        TyreOutput {
            longitudinal_n,
            lateral_n: dy * side,
            // Tx = -Fz rc γ, rc = DTx r                                                 (A2.19)
            overturning_nm: -lean.scale(self.overturning_ratio * self.overturning_gain),
            rolling_resistance_nm: contact::rolling(
                fz,
                input.speed_m_s,
                r,
                self.rolling_resistance_ratio,
            ),
            // Tz = -t Fy(α)                                                             (A2.12)
            aligning_nm: twisting - trail * dy * side_slip,
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
        let shape = |name, value| contact::within(name, value, 0.1, 2.0, "0.1 to 2");
        shape("longitudinal_shape_ratio", self.longitudinal_shape_ratio)?;
        shape("slip_shape_ratio", self.slip_shape_ratio)?;
        shape("camber_shape_ratio", self.camber_shape_ratio)?;
        shape("trail_shape_ratio", self.trail_shape_ratio)?;
        for (name, value) in [
            ("nominal_load_n", self.nominal_load_n),
            (
                "longitudinal_friction_ratio",
                self.longitudinal_friction_ratio,
            ),
            ("lateral_friction_ratio", self.lateral_friction_ratio),
            ("cornering_peak_ratio", self.cornering_peak_ratio),
        ] {
            contact::positive(name, value)?;
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
        if self.cornering_max_per_rad > 0.0 || !self.cornering_max_per_rad.is_finite() {
            return Err(TyreError::OutOfRange {
                parameter: "cornering_max_per_rad",
                found: self.cornering_max_per_rad,
                accepted: "finite, zero or below (the sign of the ISO axes)",
            });
        }
        contact::within(
            "lateral_friction_load_ratio",
            self.lateral_friction_load_ratio,
            -0.2,
            0.2,
            "-0.2 to 0.2",
        )?;
        for (name, value) in [
            ("camber_stiffness_per_rad", self.camber_stiffness_per_rad),
            (
                "camber_stiffness_load_per_rad",
                self.camber_stiffness_load_per_rad,
            ),
            ("trail_slope_per_rad", self.trail_slope_per_rad),
            ("trail_slope_load_per_rad", self.trail_slope_load_per_rad),
            ("trail_peak_ratio", self.trail_peak_ratio),
            ("trail_peak_load_ratio", self.trail_peak_load_ratio),
            ("twisting_per_rad", self.twisting_per_rad),
            ("twisting_load_per_rad", self.twisting_load_per_rad),
        ] {
            contact::finite(name, value)?;
        }
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
        if self.frozen_load_n.is_some() && self.load_range_n.is_some() {
            return Err(TyreError::Exclusive {
                first: "frozen_load_n",
                second: "load_range_n",
            });
        }
        if let Some(load) = self.frozen_load_n {
            contact::positive("frozen_load_n", load)?;
        }
        if let Some([low, high]) = self.load_range_n {
            contact::positive("load_range_n[0]", low)?;
            contact::within(
                "load_range_n[1]",
                high,
                low,
                f64::MAX,
                "at least load_range_n[0]",
            )?;
        }
        if let Some(length) = self.relaxation_length_m {
            contact::positive("relaxation_length_m", length)?;
        }
        self.vertical.validate()
    }
    fn explain(&self) -> Explain {
        Explain {
            name: "magic_formula",
            what: "bicycle tyre with load dependence, side slip, camber, self-aligning, twisting and overturning moment, rolling resistance and longitudinal slip",
            equation: "y = D sin(C atan(B x)) for each force, cosine form for the pneumatic trail, moments linear in camber: A2.1 to A2.19 of the source",
            source: "Bulsink (2017), thesis, University of Twente, appendix A.2 and table A3; measured by Doria et al. (2013), Vehicle System Dynamics 51",
            assumes: "longitudinal slip was never measured (motorcycle data); combined slip is not in the source (option `combined`); twisting torque knows no friction limit but that of combined slip; holds for 400 to 600 N, slip angles to 6 degrees, camber to 25 degrees",
        }
    }
}
