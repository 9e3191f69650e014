//! What: moving air and its drag on bicycle and rider.
//!
//! Equation: F = ½ ρ A |v| v for each axis of the heading frame, v the air's velocity past the
//! bicycle, A the drag area along and the side area across. Gusts: U/2 (1 - cos(2π t / T)), and
//! turbulence with the first-order spectrum S(f) = σ² 4 T / (1 + (2π f T)²), T = length / speed.
//!
//! Source: drag areas from Wilson and Schmidt (2020), Bicycling Science, 4th ed.: about 0.55 m² for
//! an upright rider; the gust is that of EASA CS-23.333; the spectrum is Dryden's along the wind
//! (MIL-F-8785C).
//!
//! Assumes and ignores: the same wind over bicycle and rider; no lift, no yaw moment, no shelter;
//! turbulence is a finite sum of sines, each in a band of equal variance, frequencies beyond the
//! 95 % quantile of the spectrum left out.
//!
//! Valid for: wind up to 20 m/s.
//!
//! Checked by: variance and correlation of the turbulence (10 %), drag by hand, sign of the side
//! force, TOML round trip.

use crate::Scalar;
use crate::explain::Explain;
use crate::road::uniform;
use core::f64::consts::{FRAC_PI_2, PI};
use serde::{Deserialize, Serialize};
use thiserror::Error;

/// Air that moves over the road.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Wind {
    /// Steady wind along x, m/s; positive is a tail wind for a bicycle that rides along x.
    pub along_m_s: f64,
    /// Steady wind along y, m/s; positive blows to the right.
    pub across_m_s: f64,
    /// Gusts on top.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub gusts: Vec<Gust>,
}

/// What moving air does to bicycle and rider.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Drag {
    /// Density of the air, kg/m³ (1.2 at 20 °C and sea level).
    pub air_density_kg_m3: f64,
    /// Drag coefficient times frontal area, m².
    pub drag_area_m2: f64,
    /// Drag coefficient times side area, m².
    pub side_area_m2: f64,
    /// Height of the centre of pressure above the road, bicycle upright, m.
    pub centre_height_m: f64,
}

/// Wind that changes with time.
pub trait GustModel {
    /// Velocity along x and y at `time_s`, m/s: a pure function of time.
    fn velocity_m_s(&self, time_s: f64) -> [f64; 2];
    /// Refuses what cannot be.
    fn validate(&self) -> Result<(), WindError>;
    /// What `twinhub explain` says.
    fn explain(&self) -> Explain;
}

twinhub_types::registry! {
    /// Every kind of gust.
    #[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
    #[serde(rename_all = "snake_case")]
    pub enum Gust: GustModel {
        /// One wave of a cosine.
        OneMinusCosine(OneMinusCosine) = "one_minus_cosine",
        /// Random wind with a first-order spectrum.
        Turbulence(Turbulence) = "turbulence",
    }
    fn velocity_m_s(&self, time_s: f64) -> [f64; 2];
    fn validate(&self) -> Result<(), WindError>;
    fn explain(&self) -> Explain;
}

/// One example of every gust, with a sentence.
pub const GUSTS: [(&str, Gust); 2] = [
    (
        "a gust of 8 m/s from the left for 3 s",
        Gust::OneMinusCosine(OneMinusCosine {
            start_s: 2.0,
            duration_s: 3.0,
            along_m_s: 0.0,
            across_m_s: 8.0,
        }),
    ),
    (
        "turbulence of 1.5 m/s",
        Gust::Turbulence(Turbulence {
            seed: 1,
            along_sd_m_s: 1.5,
            across_sd_m_s: 1.5,
            correlation_time_s: 2.0,
            lines: 50,
        }),
    ),
];

/// U/2 (1 - cos(2π t / T)).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OneMinusCosine {
    /// When it begins, s.
    pub start_s: f64,
    /// How long it lasts, s.
    pub duration_s: f64,
    /// Its peak along x, m/s.
    pub along_m_s: f64,
    /// Its peak along y, m/s; positive blows to the right.
    pub across_m_s: f64,
}

impl GustModel for OneMinusCosine {
    fn velocity_m_s(&self, time_s: f64) -> [f64; 2] {
        let s = ((time_s - self.start_s) / self.duration_s).clamp(0.0, 1.0);
        let share = 0.5 * (1.0 - libm::cos(2.0 * PI * s));
        [share * self.along_m_s, share * self.across_m_s]
    }
    fn explain(&self) -> Explain {
        Explain {
            name: "one_minus_cosine",
            what: "a gust: wind that rises and falls once",
            equation: "U/2 (1 - cos(2π t / T))",
            source: "EASA CS-23.333",
            assumes: "the same wind over bicycle and rider",
        }
    }
    fn validate(&self) -> Result<(), WindError> {
        within("gusts.start_s", self.start_s, f64::MIN, f64::MAX, "finite")?;
        within(
            "gusts.duration_s",
            self.duration_s,
            1e-3,
            f64::MAX,
            "0.001 s or more",
        )?;
        speed("gusts.along_m_s", self.along_m_s)?;
        speed("gusts.across_m_s", self.across_m_s)
    }
}

/// Random wind: a sum of sines, each with the same share of the variance.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Turbulence {
    /// Chooses frequencies and phases.
    pub seed: u64,
    /// Standard deviation along x, m/s.
    pub along_sd_m_s: f64,
    /// Standard deviation along y, m/s.
    pub across_sd_m_s: f64,
    /// Correlation time T, s: length of an eddy over the speed at which it passes.
    pub correlation_time_s: f64,
    /// Number of sines for each axis, 1 to 1000.
    pub lines: u32,
}

/// Share of the variance below the highest frequency.
const KEPT: f64 = 0.95;

impl Turbulence {
    fn axis(&self, time_s: f64, sd_m_s: f64, first: u32) -> f64 {
        let lines = f64::from(self.lines);
        let mut sum = 0.0;
        for line in 0..self.lines {
            let index = first + 4 * line;
            // quantile of the spectrum: (2/π) atan(ω T) = share
            let share = KEPT * (f64::from(line) + uniform(self.seed, index)) / lines;
            let omega_rad_s = libm::tan(FRAC_PI_2 * share) / self.correlation_time_s;
            let phase = 2.0 * PI * uniform(self.seed, index + 1);
            sum += libm::sin(omega_rad_s * time_s + phase);
        }
        sd_m_s * libm::sqrt(2.0 / lines) * sum
    }
}

impl GustModel for Turbulence {
    fn velocity_m_s(&self, time_s: f64) -> [f64; 2] {
        [
            self.axis(time_s, self.along_sd_m_s, 0),
            self.axis(time_s, self.across_sd_m_s, 2),
        ]
    }
    fn explain(&self) -> Explain {
        Explain {
            name: "turbulence",
            what: "random wind",
            equation: "sum of sines with the first-order spectrum S(f) = σ² 4 T / (1 + (2π f T)²)",
            source: "Dryden along the wind, MIL-F-8785C",
            assumes: "bands of equal variance; frequencies beyond the 95 % quantile are left out",
        }
    }
    fn validate(&self) -> Result<(), WindError> {
        within(
            "gusts.along_sd_m_s",
            self.along_sd_m_s,
            0.0,
            50.0,
            "0 to 50 m/s",
        )?;
        within(
            "gusts.across_sd_m_s",
            self.across_sd_m_s,
            0.0,
            50.0,
            "0 to 50 m/s",
        )?;
        within(
            "gusts.correlation_time_s",
            self.correlation_time_s,
            0.01,
            1e4,
            "0.01 to 10000 s",
        )?;
        within(
            "gusts.lines",
            f64::from(self.lines),
            1.0,
            1000.0,
            "1 to 1000",
        )
    }
}

/// Why wind or drag is refused.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum WindError {
    /// A parameter lies outside its range.
    #[error("wind: {parameter} is {found}; accepted: {accepted}")]
    OutOfRange {
        /// Name of the parameter.
        parameter: &'static str,
        /// What was found.
        found: f64,
        /// What would be accepted.
        accepted: &'static str,
    },
}

impl Wind {
    /// Velocity of the air over the road along x and y at `time_s`, m/s.
    pub fn velocity_m_s(&self, time_s: f64) -> [f64; 2] {
        self.gusts.iter().fold(
            [self.along_m_s, self.across_m_s],
            |[along, across], gust| {
                let [x, y] = gust.velocity_m_s(time_s);
                [along + x, across + y]
            },
        )
    }

    /// Refuses wind that cannot be.
    pub fn validate(&self) -> Result<(), WindError> {
        speed("along_m_s", self.along_m_s)?;
        speed("across_m_s", self.across_m_s)?;
        self.gusts.iter().try_for_each(Gust::validate)
    }
}

impl Drag {
    /// Force forward and to the right, N, of air that moves past the bicycle at `past_m_s` forward
    /// and to the right (the air's velocity less the bicycle's, in the heading frame).
    #[inline]
    pub fn force_n<T: Scalar>(&self, past_m_s: [T; 2]) -> [T; 2] {
        let [x, y] = past_m_s;
        // the millimetre per second keeps the derivative at rest
        let speed = (x * x + y * y + T::from_f64(1e-6)).sqrt();
        let half_density = 0.5 * self.air_density_kg_m3;
        [
            (speed * x).scale(half_density * self.drag_area_m2),
            (speed * y).scale(half_density * self.side_area_m2),
        ]
    }

    /// Refuses drag that cannot be.
    pub fn validate(&self) -> Result<(), WindError> {
        within(
            "air_density_kg_m3",
            self.air_density_kg_m3,
            0.0,
            2.0,
            "0 to 2 kg/m³",
        )?;
        within("drag_area_m2", self.drag_area_m2, 0.0, 5.0, "0 to 5 m²")?;
        within("side_area_m2", self.side_area_m2, 0.0, 5.0, "0 to 5 m²")?;
        within(
            "centre_height_m",
            self.centre_height_m,
            0.0,
            3.0,
            "0 to 3 m",
        )
    }
}

fn speed(parameter: &'static str, found: f64) -> Result<(), WindError> {
    within(parameter, found, -50.0, 50.0, "-50 to 50 m/s")
}

fn within(
    parameter: &'static str,
    found: f64,
    low: f64,
    high: f64,
    accepted: &'static str,
) -> Result<(), WindError> {
    if found >= low && found <= high {
        Ok(())
    } else {
        Err(WindError::OutOfRange {
            parameter,
            found,
            accepted,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TURBULENCE: Turbulence = Turbulence {
        seed: 3,
        along_sd_m_s: 1.5,
        across_sd_m_s: 0.5,
        correlation_time_s: 2.0,
        lines: 100,
    };

    #[test]
    fn turbulence_has_its_variance_and_correlation_time() {
        let at = |t: f64| TURBULENCE.velocity_m_s(t);
        let samples = 50_000;
        let (mut variance, mut lagged, mut cross) = ([0.0; 2], 0.0, 0.0);
        for i in 0..samples {
            let t = 0.37 * f64::from(i);
            let [x, y] = at(t);
            variance = [variance[0] + x * x, variance[1] + y * y];
            lagged += x * at(t + 2.0)[0];
            cross += x * y;
        }
        let n = f64::from(samples);
        let sd = variance.map(|v| libm::sqrt(v / n));
        assert!(
            (sd[0] / 1.5 - 1.0).abs() < 0.1 && (sd[1] / 0.5 - 1.0).abs() < 0.1,
            "{sd:?}"
        );
        // first-order: correlation exp(-1) after T; the cut tail moves it a little
        let correlation = lagged / variance[0];
        assert!(
            (correlation - libm::exp(-1.0)).abs() < 0.1,
            "correlation {correlation}"
        );
        assert!(
            (cross / n / (sd[0] * sd[1])).abs() < 0.1,
            "axes are independent"
        );
    }

    #[test]
    fn drag_by_hand_and_side_wind_pushes_downwind() {
        let drag = Drag {
            air_density_kg_m3: 1.2,
            drag_area_m2: 0.5,
            side_area_m2: 0.9,
            centre_height_m: 1.0,
        };
        // ½ x 1.2 x 0.5 x 5² = 7.5 N against riding at 5 m/s in still air
        let [x, y] = drag.force_n([-5.0, 0.0]);
        assert!((x + 7.5).abs() < 1e-6 && y == 0.0, "{x} {y}");
        assert!(drag.force_n([-5.0, 3.0])[1] > 0.0);
    }

    #[test]
    fn a_gust_peaks_in_the_middle_and_ends() {
        let gust = OneMinusCosine {
            start_s: 1.0,
            duration_s: 2.0,
            along_m_s: 0.0,
            across_m_s: 6.0,
        };
        let wind = Wind {
            along_m_s: -2.0,
            across_m_s: 1.0,
            gusts: vec![Gust::OneMinusCosine(gust)],
        };
        assert_eq!(wind.velocity_m_s(0.5), [-2.0, 1.0]);
        assert!((wind.velocity_m_s(2.0)[1] - 7.0).abs() < 1e-12);
        assert!((wind.velocity_m_s(9.0)[1] - 1.0).abs() < 1e-12);
    }

    #[test]
    fn toml_goes_round_and_nonsense_is_refused() {
        let wind = Wind {
            along_m_s: 1.0,
            across_m_s: 2.0,
            gusts: vec![Gust::Turbulence(TURBULENCE)],
        };
        wind.validate().unwrap();
        assert_eq!(
            toml::from_str::<Wind>(&toml::to_string(&wind).unwrap()).unwrap(),
            wind
        );
        assert!(toml::from_str::<Wind>("along_m_s = 1.0\nacross_m_s = 0.0\ngust = 3").is_err());
        assert!(
            Wind {
                along_m_s: f64::NAN,
                ..wind.clone()
            }
            .validate()
            .is_err()
        );
        let bad = Turbulence {
            lines: 0,
            ..TURBULENCE
        };
        assert!(
            Wind {
                gusts: vec![Gust::Turbulence(bad)],
                ..wind
            }
            .validate()
            .is_err()
        );
    }
}
