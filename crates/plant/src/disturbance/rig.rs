//! The multisine of the laboratory rig.
//!
//! What: in the rig the front wheel runs on a treadmill, the rear wheel on rollers that a Stewart
//! platform moves sideways. Equation: y = Y Σ f_k^-s sin(2π f_k t + φ_k)/max|Σ ..|, f_k = 0.4, 0.6,
//! 0.8, 1.0, 1.2, 1.4, 1.8, 2.2, 2.6 and 3.0 Hz, phases after Schroeder (1970), low crest. Source:
//! Bulsink (2017), sections 4.2.1 and 6.2: these ten lines, repeated every 10 s for 100 s, largest
//! amplitude 1.75 cm (young) and 1.25 cm (older), power falling with frequency. Assumes and
//! ignores: the phases and the slope s of the amplitudes are not published (only drawn in figures
//! 4.2 and 6.3): the slope is a parameter, the phases are ours. All ten lines are multiples of
//! 0.2 Hz, so the signal repeats every 5 s already. Rollers and platform follow exactly; the
//! rear wheel's forward motion on rollers is the plant's business. Valid for: responses at the
//! lines. Checked by: the parent's tests (discrete Fourier transform over 10 s, peak, derivatives).

use core::f64::consts::PI;

use serde::{Deserialize, Serialize};

use super::pulses::{MAX_DURATION_S, MAX_FORCE_N};
use super::{DisturbanceModel, Effect, Place, Places, Signal, Sines, Source};
use crate::admissible::{OutOfRange, within};
use crate::explain::Explain;

/// The lines, Hz.
pub const RIG_LINES_HZ: [f64; 10] = [0.4, 0.6, 0.8, 1.0, 1.2, 1.4, 1.8, 2.2, 2.6, 3.0];

/// The platform under the rear wheel.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RigMultisine {
    /// Largest displacement, m.
    pub amplitude_m: f64,
    /// Amplitudes fall with frequency to this power.
    pub slope: f64,
    /// Length, s.
    pub duration_s: f64,
    /// Length of beginning and end, s.
    pub fade_s: f64,
}

/// The rig's lines as a lateral force.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MultisineForce {
    /// Largest force, N.
    pub force_n: f64,
    /// Amplitudes fall with frequency to this power.
    pub slope: f64,
    /// Length, s.
    pub duration_s: f64,
    /// Length of beginning and end, s.
    pub fade_s: f64,
    /// Where.
    pub place: Place,
}

/// The ten lines with largest value `peak`.
fn sines(peak: f64, slope: f64, duration_s: f64, fade_s: f64) -> Sines {
    let amplitude = RIG_LINES_HZ.map(|f| libm::pow(f, -slope));
    let power: f64 = amplitude.iter().map(|a| a * a).sum();
    // Schroeder (1970): φ_k = -2π Σ_{j<k} (k - j) p_j with p_j the share of power of line j
    let mut lines = Vec::with_capacity(RIG_LINES_HZ.len());
    for (k, (f, a)) in RIG_LINES_HZ.iter().zip(amplitude).enumerate() {
        let sum: f64 = amplitude[..k]
            .iter()
            .enumerate()
            .map(|(j, b)| (k - j) as f64 * b * b / power)
            .sum();
        lines.push([a, 2.0 * PI * f, -2.0 * PI * sum]);
    }
    let raw = Signal::Sines(Sines {
        lines: lines.clone(),
        duration_s: f64::INFINITY,
        fade_s: 0.0,
    });
    let largest = (0..5_000)
        .map(|i| raw.at(f64::from(i) * 1e-3)[0].abs())
        .fold(0.0, f64::max);
    for line in &mut lines {
        line[0] *= peak / largest;
    }
    Sines {
        lines,
        duration_s,
        fade_s,
    }
}

const EQUATION: &str =
    "y = Y Σ f_k^-s sin(2π f_k t + φ_k)/max, ten lines from 0.4 to 3.0 Hz, Schroeder phases";

impl DisturbanceModel for RigMultisine {
    fn explain(&self) -> Explain {
        Explain {
            name: "rig_multisine",
            what: "the laboratory's platform moving the road under the rear wheel sideways",
            equation: EQUATION,
            source: "Bulsink (2017), sections 4.2.1 and 6.2: lines, period, 1.75 cm (young) and 1.25 cm (older)",
            assumes: "phases and slope are not published: slope is a parameter, phases are ours; exact platform",
        }
    }

    fn validate(&self) -> Result<(), OutOfRange> {
        within("amplitude_m", self.amplitude_m, 0.0, 0.5)?;
        within("slope", self.slope, 0.0, 4.0)?;
        within("duration_s", self.duration_s, 1e-3, MAX_DURATION_S)?;
        within("fade_s", self.fade_s, 0.0, 0.5 * self.duration_s)
    }

    fn build(&self, _: &Places, _: u64, _: &str) -> Source {
        let sines = sines(self.amplitude_m, self.slope, self.duration_s, self.fade_s);
        Source {
            signal: Signal::Sines(sines),
            effect: Effect::RearRoad,
        }
    }
}

impl DisturbanceModel for MultisineForce {
    fn explain(&self) -> Explain {
        Explain {
            name: "multisine_force",
            what: "the rig's ten lines as a lateral force on the rear frame, for plants without a moving road",
            equation: EQUATION,
            source: "lines of Bulsink (2017), sections 4.2.1 and 6.2; as a force it is ours",
            assumes: "the force stays lateral and keeps its point on the frame",
        }
    }

    fn validate(&self) -> Result<(), OutOfRange> {
        within("force_n", self.force_n, 0.0, MAX_FORCE_N)?;
        within("slope", self.slope, 0.0, 4.0)?;
        within("duration_s", self.duration_s, 1e-3, MAX_DURATION_S)?;
        within("fade_s", self.fade_s, 0.0, 0.5 * self.duration_s)?;
        self.place.validate()
    }

    fn build(&self, places: &Places, _: u64, _: &str) -> Source {
        let sines = sines(self.force_n, self.slope, self.duration_s, self.fade_s);
        let effect = Effect::LateralForce(self.place.on(places));
        Source {
            signal: Signal::Sines(sines),
            effect,
        }
    }
}
