//! Signals over time, with their first two derivatives.
//!
//! What: the shapes that disturbances have. Equation: rectangle a; half sine a sin(π t/T); step a;
//! sum of sines w(t) Σ a_k sin(ω_k t + φ_k) with a window w that rises and falls by the quintic
//! 6u⁵ - 15u⁴ + 10u³ (twice continuously differentiable); wind as in `gust.rs`. Source:
//! definitions. Assumes and ignores: times are compared in whole nanoseconds, so that a pulse of n
//! ticks lasts n ticks wherever it starts. Valid for: any time. Checked by: the parent's tests.

use core::f64::consts::PI;

/// Most lines of a sum of sines.
pub const MAX_LINES: usize = 64;

/// A signal that is zero before its start.
#[derive(Clone, Debug, PartialEq)]
pub enum Signal {
    /// Constant for a while; derivatives are those between the edges.
    Rectangle {
        /// Height.
        amplitude: f64,
        /// Length, s.
        duration_s: f64,
    },
    /// Half a sine.
    HalfSine {
        /// Height.
        amplitude: f64,
        /// Length, s.
        duration_s: f64,
    },
    /// Constant for ever.
    Step {
        /// Height.
        amplitude: f64,
    },
    /// Side wind w(t) = w (1 - cos(2π t/T))/2 as a force b w(t) √(v² + w(t)²); no derivatives.
    Wind {
        /// Half the air density times the side force area, kg/m.
        b_kg_m: f64,
        /// Peak of the side wind, m/s.
        wind_m_s: f64,
        /// Riding speed, m/s.
        speed_m_s: f64,
        /// Length, s.
        duration_s: f64,
    },
    /// A sum of sines.
    Sines(Sines),
}

/// A sum of sines with a smooth beginning and end.
#[derive(Clone, Debug, PartialEq)]
pub struct Sines {
    /// Amplitude, angular frequency (rad/s), phase (rad) of each line.
    pub lines: Vec<[f64; 3]>,
    /// Length, s; infinite for one that does not end.
    pub duration_s: f64,
    /// Length of beginning and end, s.
    pub fade_s: f64,
}

impl Signal {
    /// Value and first two derivatives, `t_s` after the start.
    pub fn at(&self, t_s: f64) -> [f64; 3] {
        let t_ns = libm::round(t_s * 1e9);
        let over = |duration_s: f64| t_ns >= libm::round(duration_s * 1e9);
        if t_ns < 0.0 {
            return [0.0; 3];
        }
        match self {
            Self::Rectangle {
                amplitude,
                duration_s,
            } if !over(*duration_s) => [*amplitude, 0.0, 0.0],
            Self::Step { amplitude } => [*amplitude, 0.0, 0.0],
            Self::HalfSine {
                amplitude,
                duration_s,
            } if !over(*duration_s) => {
                let w = PI / duration_s;
                let (s, c) = libm::sincos(w * t_s);
                [amplitude * s, amplitude * w * c, -amplitude * w * w * s]
            }
            Self::Wind {
                b_kg_m,
                wind_m_s,
                speed_m_s,
                duration_s,
            } if !over(*duration_s) => {
                let w = 0.5 * wind_m_s * (1.0 - libm::cos(2.0 * PI * t_s / duration_s));
                [
                    b_kg_m * w * libm::sqrt(speed_m_s * speed_m_s + w * w),
                    0.0,
                    0.0,
                ]
            }
            Self::Sines(sines) if !over(sines.duration_s) => sines.at(t_s),
            _ => [0.0; 3],
        }
    }
}

impl Sines {
    fn at(&self, t_s: f64) -> [f64; 3] {
        let mut s = [0.0; 3];
        for [amplitude, rate, phase] in &self.lines {
            let (sin, cos) = libm::sincos(rate * t_s + phase);
            s[0] += amplitude * sin;
            s[1] += amplitude * rate * cos;
            s[2] -= amplitude * rate * rate * sin;
        }
        let w = self.window(t_s);
        // product rule
        [
            w[0] * s[0],
            w[1] * s[0] + w[0] * s[1],
            w[2] * s[0] + 2.0 * w[1] * s[1] + w[0] * s[2],
        ]
    }

    /// The window and its derivatives.
    fn window(&self, t_s: f64) -> [f64; 3] {
        let left_s = self.duration_s - t_s;
        if self.fade_s > 0.0 && t_s < self.fade_s {
            let u = t_s.max(0.0) / self.fade_s;
            quintic(u, 1.0 / self.fade_s)
        } else if self.fade_s > 0.0 && left_s < self.fade_s {
            let u = left_s.max(0.0) / self.fade_s;
            quintic(u, -1.0 / self.fade_s)
        } else {
            [1.0, 0.0, 0.0]
        }
    }
}

fn quintic(u: f64, rate: f64) -> [f64; 3] {
    let u2 = u * u;
    [
        u2 * u * (6.0 * u2 - 15.0 * u + 10.0),
        30.0 * u2 * (u2 - 2.0 * u + 1.0) * rate,
        60.0 * u * (2.0 * u2 - 3.0 * u + 1.0) * rate * rate,
    ]
}
