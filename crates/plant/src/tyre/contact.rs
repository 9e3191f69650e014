//! What all tyres share: friction of the road, combined slip, the vertical spring, errors.

use crate::Scalar;
use serde::{Deserialize, Serialize};
use thiserror::Error;

/// How the friction of the road acts on a tyre.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Friction {
    /// The tyre's own coefficient (1.642 in Bulsink 2017, table A3) times that of the road.
    AsFile,
    /// The road's coefficient alone, whatever the tyre file says. Stiffnesses are unaffected.
    Absolute,
}

/// How longitudinal slip takes away side force.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Combined {
    /// Not at all: the printed equations.
    None,
    /// Side force times √(1 - (Fx / (μ Fz))²): the friction ellipse.
    Ellipse,
}

/// Vertical spring and damper between contact point and road.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Vertical {
    /// Stiffness, N/m.
    pub stiffness_n_m: f64,
    /// Damping, N s/m.
    pub damping_n_s_m: f64,
}

/// Why a tyre is refused.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum TyreError {
    /// A parameter lies outside its range.
    #[error("tyre: {parameter} is {found}; accepted: {accepted}")]
    OutOfRange {
        /// Name of the parameter.
        parameter: &'static str,
        /// What was found.
        found: f64,
        /// What would be accepted.
        accepted: &'static str,
    },
    /// Two options exclude each other.
    #[error("tyre: {first} and {second} are both given; accepted: one of them")]
    Exclusive {
        /// One option.
        first: &'static str,
        /// The other.
        second: &'static str,
    },
}

/// Loads above this are held, so that a crash stays finite, N.
const LOAD_LIMIT_N: f64 = 1.0e6;
/// Ice has about 0.02; below this friction is held, because stiffness over friction must exist.
const FRICTION_FLOOR: f64 = 1.0e-6;
/// sin(atan(u)) is 1 to the last bit well before this argument.
const SATURATED: f64 = 1.0e9;
/// Speed above which rolling resistance is the printed one, m/s.
const ROLLING_TURNOVER_M_S: f64 = 0.02;

/// Load that forces are made of: zero off the ground.
#[inline(always)]
pub(super) fn load<T: Scalar>(load_n: T) -> T {
    load_n.clamp(T::zero(), T::from_f64(LOAD_LIMIT_N))
}

/// Friction of the road, kept above zero.
#[inline(always)]
pub(super) fn road<T: Scalar>(friction_ratio: T) -> T {
    friction_ratio.max(T::from_f64(FRICTION_FLOOR))
}

/// sin and cos of C atan(u). With C = 1 both are algebraic.
#[inline(always)]
pub(super) fn shape<T: Scalar>(c: f64, u: T) -> (T, T) {
    let u = u.clamp(T::from_f64(-SATURATED), T::from_f64(SATURATED));
    if c == 1.0 {
        let cosine = T::one() / (T::one() + u * u).sqrt();
        (u * cosine, cosine)
    } else {
        u.atan().scale(c).sin_cos()
    }
}

/// Derivative of D sin(C atan(B x)) with respect to x: B C D cos(C atan(B x)) / (1 + (B x)²), with
/// `stiffness` B C D, `u` B x and the cosine of [`shape`].
#[inline(always)]
pub(super) fn slope<T: Scalar>(stiffness: T, u: T, cosine: T) -> T {
    stiffness * cosine / (T::one() + u * u)
}

/// Rolling resistance moment Fz r q, against the way the wheel rolls (A2.18). The sign turns over
/// smoothly below [`ROLLING_TURNOVER_M_S`].
#[inline(always)]
pub(super) fn rolling<T: Scalar>(fz: T, speed_m_s: T, radius_m: f64, ratio: f64) -> T {
    let way = speed_m_s
        .scale(1.0 / ROLLING_TURNOVER_M_S)
        .clamp(-T::one(), T::one());
    fz.scale(radius_m * ratio) * way * (T::from_f64(1.5) - (way * way).scale(0.5))
}

impl Combined {
    /// What is left of side force, given the cosine of the longitudinal shape: with
    /// Fx = D sin(θ), √(1 - (Fx/D)²) = cos(θ). Past the peak of Fx it stays zero.
    #[inline(always)]
    pub(super) fn side_force_ratio<T: Scalar>(self, cosine: T) -> T {
        match self {
            Self::None => T::one(),
            Self::Ellipse => cosine.max(T::zero()),
        }
    }
}

impl Vertical {
    pub(super) fn validate(&self) -> Result<(), TyreError> {
        positive("vertical.stiffness_n_m", self.stiffness_n_m)?;
        not_negative("vertical.damping_n_s_m", self.damping_n_s_m)
    }
}

pub(super) fn within(
    parameter: &'static str,
    found: f64,
    low: f64,
    high: f64,
    accepted: &'static str,
) -> Result<(), TyreError> {
    if found >= low && found <= high {
        Ok(())
    } else {
        Err(TyreError::OutOfRange {
            parameter,
            found,
            accepted,
        })
    }
}

pub(super) fn positive(parameter: &'static str, found: f64) -> Result<(), TyreError> {
    within(
        parameter,
        found,
        f64::MIN_POSITIVE,
        f64::MAX,
        "finite and above zero",
    )
}

pub(super) fn not_negative(parameter: &'static str, found: f64) -> Result<(), TyreError> {
    within(parameter, found, 0.0, f64::MAX, "finite, zero or above")
}

pub(super) fn finite(parameter: &'static str, found: f64) -> Result<(), TyreError> {
    within(parameter, found, f64::MIN, f64::MAX, "finite")
}

pub(super) fn gain(parameter: &'static str, found: f64) -> Result<(), TyreError> {
    within(parameter, found, 0.0, 1000.0, "0 to 1000")
}

pub(super) fn one() -> f64 {
    1.0
}
