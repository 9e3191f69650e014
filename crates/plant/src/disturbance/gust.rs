//! Gusts of side wind.
//!
//! What: a side wind that comes and goes once. Equation: w(t) = w (1 - cos(2π t/T))/2,
//! F = ½ ρ C_s A w √(v² + w²): the side force of a body whose coefficient is C_s sin β in the
//! relative wind. Source: the one-minus-cosine gust is the discrete gust of aircraft
//! certification; the force is the definition of a side-force coefficient. Assumes and ignores:
//! riding speed constant during the gust, no yaw torque but that of the point, drag unchanged.
//! Valid for: side winds of any size at a constant speed. Checked by: the parent's tests.

use serde::{Deserialize, Serialize};

use super::pulses::MAX_DURATION_S;
use super::{DisturbanceModel, Effect, Place, Places, Signal, Source};
use crate::admissible::{OutOfRange, within};
use crate::explain::Explain;

/// A gust of side wind.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Gust {
    /// Peak of the side wind, blowing to the right, m/s.
    pub wind_m_s: f64,
    /// Length, s.
    pub duration_s: f64,
    /// Riding speed during the gust, m/s.
    pub speed_m_s: f64,
    /// Side-force coefficient times side area C_s A of bicycle and rider, m².
    pub side_area_m2: f64,
    /// Air density, kg/m³.
    pub air_density_kg_m3: f64,
    /// Centre of the side force.
    pub place: Place,
}

impl DisturbanceModel for Gust {
    fn explain(&self) -> Explain {
        Explain {
            name: "gust",
            what: "a side wind that comes and goes once",
            equation: "w(t) = w (1 - cos(2π t/T))/2; F = ½ ρ C_s A w √(v² + w²)",
            source: "one-minus-cosine gust of aircraft certification; definition of a side-force coefficient",
            assumes: "constant riding speed during the gust; drag unchanged",
        }
    }

    fn validate(&self) -> Result<(), OutOfRange> {
        within("wind_m_s", self.wind_m_s, -50.0, 50.0)?;
        within("duration_s", self.duration_s, 1e-2, MAX_DURATION_S)?;
        within("speed_m_s", self.speed_m_s, 0.0, 30.0)?;
        within("side_area_m2", self.side_area_m2, 0.0, 10.0)?;
        within("air_density_kg_m3", self.air_density_kg_m3, 0.0, 2.0)?;
        self.place.validate()
    }

    fn build(&self, places: &Places, _: u64, _: &str) -> Source {
        let signal = Signal::Wind {
            b_kg_m: 0.5 * self.air_density_kg_m3 * self.side_area_m2,
            wind_m_s: self.wind_m_s,
            speed_m_s: self.speed_m_s,
            duration_s: self.duration_s,
        };
        Source {
            signal,
            effect: Effect::LateralForce(self.place.on(places)),
        }
    }
}
