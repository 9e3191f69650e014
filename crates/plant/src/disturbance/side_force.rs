//! Random side force.
//!
//! What: a smooth random lateral force with a flat spectrum in a band. Equation:
//! F = r √(2/n) Σ sin(2π f_k t + φ_k), one f_k drawn in each of n equal parts of the band, φ_k
//! drawn uniformly: rms r over a long time, no period. Source: random-phase multisine, e.g.
//! Pintelon and Schoukens (2012), System Identification, chapter 5. Assumes and ignores: nearly
//! normal values for ten lines and more; bounded by r √(2n). Valid for: rides much longer than
//! n/(high - low). Checked by: the parent's tests (rms, band, reproducibility).

use core::f64::consts::PI;

use serde::{Deserialize, Serialize};

use super::pulses::{MAX_DURATION_S, MAX_FORCE_N};
use super::{DisturbanceModel, Effect, MAX_LINES, Place, Places, Signal, Sines, Source};
use crate::admissible::{OutOfRange, within};
use crate::explain::Explain;
use crate::noise::stream;

/// A random lateral force.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SideForce {
    /// Root mean square, N.
    pub rms_n: f64,
    /// Lower edge of the band, Hz.
    pub low_hz: f64,
    /// Upper edge of the band, Hz.
    pub high_hz: f64,
    /// Number of sines.
    pub lines: u32,
    /// Length, s.
    pub duration_s: f64,
    /// Length of beginning and end, s.
    pub fade_s: f64,
    /// Where.
    pub place: Place,
}

impl DisturbanceModel for SideForce {
    fn explain(&self) -> Explain {
        Explain {
            name: "side_force",
            what: "a smooth random lateral force with a flat spectrum in a band",
            equation: "F = r √(2/n) Σ sin(2π f_k t + φ_k), f_k and φ_k drawn by seed",
            source: "random-phase multisine (Pintelon and Schoukens 2012, chapter 5)",
            assumes: "nearly normal for ten lines and more; bounded by r √(2n)",
        }
    }

    fn validate(&self) -> Result<(), OutOfRange> {
        within("rms_n", self.rms_n, 0.0, MAX_FORCE_N)?;
        within("low_hz", self.low_hz, 0.0, 100.0)?;
        within("high_hz", self.high_hz, self.low_hz, 100.0)?;
        within("lines", f64::from(self.lines), 1.0, MAX_LINES as f64)?;
        within("duration_s", self.duration_s, 1e-3, MAX_DURATION_S)?;
        within("fade_s", self.fade_s, 0.0, 0.5 * self.duration_s)?;
        self.place.validate()
    }

    fn build(&self, places: &Places, seed: u64, name: &str) -> Source {
        let mut source = stream(seed, name);
        let n = f64::from(self.lines);
        let amplitude = self.rms_n * libm::sqrt(2.0 / n);
        let part_hz = (self.high_hz - self.low_hz) / n;
        let lines = (0..self.lines).map(|i| {
            let f_hz = self.low_hz + part_hz * (f64::from(i) + source.uniform());
            [amplitude, 2.0 * PI * f_hz, 2.0 * PI * source.uniform()]
        });
        let signal = Signal::Sines(Sines {
            lines: lines.collect(),
            duration_s: self.duration_s,
            fade_s: self.fade_s,
        });
        Source {
            signal,
            effect: Effect::LateralForce(self.place.on(places)),
        }
    }
}
