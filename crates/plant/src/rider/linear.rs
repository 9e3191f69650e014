//! A channel about zero: what the closed loop's eigenvalues need.

use super::Limb;
use nalgebra::Complex;

/// One value for each signal that a rider perceives: the signals themselves, or gains on them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Signals {
    /// Roll angle, rad; or the gain on it.
    pub roll: f64,
    /// Roll rate, rad/s; or the gain on it.
    pub roll_rate: f64,
    /// Heading, rad; or the gain on it.
    pub heading: f64,
    /// Steer angle, rad; or the gain on it.
    pub steer: f64,
    /// Steer rate, rad/s; or the gain on it.
    pub steer_rate: f64,
}

/// A channel at one speed: T = -G(s) e^(-τ s) (gains · signals) - K q - C q'.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinearChannel {
    /// What it moves.
    pub limb: Limb,
    /// Frequency, rad/s, and damping ratio of the muscles' lag G; `None`: no lag.
    pub lag: Option<(f64, f64)>,
    /// Delay τ, s.
    pub delay_s: f64,
    /// Gains to torque, Nm per unit of the signal.
    pub delayed: Signals,
    /// Stiffness K of the limb, Nm/rad.
    pub stiffness_nm_rad: f64,
    /// Damping C of the limb, Nm s/rad.
    pub damping_nm_s_rad: f64,
}

impl LinearChannel {
    /// G(s) e^(-τ s) and its derivative.
    pub(super) fn transfer(&self, s: Complex<f64>) -> (Complex<f64>, Complex<f64>) {
        let dead = exp(-s * self.delay_s);
        match self.lag {
            None => (dead, -dead * self.delay_s),
            Some((w, z)) => {
                let below = s * s + s * (2.0 * z * w) + w * w;
                let g = dead * (w * w) / below;
                (g, -g * (self.delay_s + (s * 2.0 + 2.0 * z * w) / below))
            }
        }
    }

    /// Derivative of the logarithm of the lag's denominator: its poles are not the loop's zeros.
    pub(super) fn poles(&self, s: Complex<f64>) -> Complex<f64> {
        match self.lag {
            None => Complex::new(0.0, 0.0),
            Some((w, z)) => (s * 2.0 + 2.0 * z * w) / (s * s + s * (2.0 * z * w) + w * w),
        }
    }
}

/// Exponential of a complex number, with the functions of `libm`.
fn exp(s: Complex<f64>) -> Complex<f64> {
    let size = libm::exp(s.re);
    let (sin, cos) = libm::sincos(s.im);
    Complex::new(size * cos, size * sin)
}
