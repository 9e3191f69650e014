//! Pushes, kicks and pulls.
//!
//! What: single events of known shape. Equation: see each entry. Source: definitions; the push of
//! Bulsink (2017), section 3.2.3, is 0.1 N for 0.1 s at the rear frame's centre of mass. Assumes
//! and ignores: the force stays lateral and keeps its point on the frame. Valid for: any size.
//! Checked by: the parent's tests (impulse, length in ticks).

use core::f64::consts::PI;

use serde::{Deserialize, Serialize};

use super::{DisturbanceModel, Effect, Place, Places, Signal, Source};
use crate::admissible::{OutOfRange, within};
use crate::explain::Explain;

/// Largest force that is accepted, N.
pub(super) const MAX_FORCE_N: f64 = 10_000.0;
/// Longest event that is accepted, s.
pub(super) const MAX_DURATION_S: f64 = 36_000.0;

/// A constant lateral force for a while.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Push {
    /// Force to the right, N.
    pub force_n: f64,
    /// Length, s.
    pub duration_s: f64,
    /// Where.
    pub place: Place,
}

/// Half a sine of lateral force.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HalfSine {
    /// Peak force to the right, N.
    pub force_n: f64,
    /// Length, s.
    pub duration_s: f64,
    /// Where.
    pub place: Place,
}

/// A lateral force that stays.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Step {
    /// Force to the right, N.
    pub force_n: f64,
    /// Where.
    pub place: Place,
}

/// A lateral impulse as half a sine.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Kick {
    /// Impulse to the right, N s.
    pub impulse_n_s: f64,
    /// Length, s.
    pub duration_s: f64,
    /// Where.
    pub place: Place,
}

/// A pull at the handlebar as half a sine of steer torque.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HandlebarPull {
    /// Peak torque to the right, Nm.
    pub torque_nm: f64,
    /// Length, s.
    pub duration_s: f64,
}

impl DisturbanceModel for Push {
    fn explain(&self) -> Explain {
        Explain {
            name: "push",
            what: "a constant lateral force on the rear frame for a while",
            equation: "F = F_0 for 0 <= t < T",
            source: "definition; Bulsink (2017), section 3.2.3 uses 0.1 N for 0.1 s at the frame's centre of mass",
            assumes: "the force stays lateral and keeps its point on the frame",
        }
    }

    fn validate(&self) -> Result<(), OutOfRange> {
        within("force_n", self.force_n, -MAX_FORCE_N, MAX_FORCE_N)?;
        within("duration_s", self.duration_s, 1e-3, MAX_DURATION_S)?;
        self.place.validate()
    }

    fn build(&self, places: &Places, _: u64, _: &str) -> Source {
        let signal = Signal::Rectangle {
            amplitude: self.force_n,
            duration_s: self.duration_s,
        };
        Source {
            signal,
            effect: Effect::LateralForce(self.place.on(places)),
        }
    }
}

impl DisturbanceModel for HalfSine {
    fn explain(&self) -> Explain {
        Explain {
            name: "half_sine",
            what: "half a sine of lateral force on the rear frame",
            equation: "F = F_0 sin(π t/T) for 0 <= t < T",
            source: "definition",
            assumes: "the force stays lateral and keeps its point on the frame",
        }
    }

    fn validate(&self) -> Result<(), OutOfRange> {
        within("force_n", self.force_n, -MAX_FORCE_N, MAX_FORCE_N)?;
        within("duration_s", self.duration_s, 1e-3, MAX_DURATION_S)?;
        self.place.validate()
    }

    fn build(&self, places: &Places, _: u64, _: &str) -> Source {
        let signal = Signal::HalfSine {
            amplitude: self.force_n,
            duration_s: self.duration_s,
        };
        Source {
            signal,
            effect: Effect::LateralForce(self.place.on(places)),
        }
    }
}

impl DisturbanceModel for Step {
    fn explain(&self) -> Explain {
        Explain {
            name: "step",
            what: "a lateral force on the rear frame that stays",
            equation: "F = F_0 for t >= 0",
            source: "definition",
            assumes: "the force stays lateral and keeps its point on the frame",
        }
    }

    fn validate(&self) -> Result<(), OutOfRange> {
        within("force_n", self.force_n, -MAX_FORCE_N, MAX_FORCE_N)?;
        self.place.validate()
    }

    fn build(&self, places: &Places, _: u64, _: &str) -> Source {
        let signal = Signal::Step {
            amplitude: self.force_n,
        };
        Source {
            signal,
            effect: Effect::LateralForce(self.place.on(places)),
        }
    }
}

impl DisturbanceModel for Kick {
    fn explain(&self) -> Explain {
        Explain {
            name: "kick",
            what: "a lateral impulse on the rear frame",
            equation: "F = (π J/2T) sin(π t/T) for 0 <= t < T, whose integral is J",
            source: "definition",
            assumes: "the force stays lateral and keeps its point on the frame; no contact stiffness",
        }
    }

    fn validate(&self) -> Result<(), OutOfRange> {
        within("impulse_n_s", self.impulse_n_s, -1000.0, 1000.0)?;
        within("duration_s", self.duration_s, 5e-3, 10.0)?;
        self.place.validate()
    }

    fn build(&self, places: &Places, _: u64, _: &str) -> Source {
        let amplitude = PI * self.impulse_n_s / (2.0 * self.duration_s);
        let signal = Signal::HalfSine {
            amplitude,
            duration_s: self.duration_s,
        };
        Source {
            signal,
            effect: Effect::LateralForce(self.place.on(places)),
        }
    }
}

impl DisturbanceModel for HandlebarPull {
    fn explain(&self) -> Explain {
        Explain {
            name: "handlebar_pull",
            what: "a pull at the handlebar, as a bag that catches or a hand that slips",
            equation: "T_delta = T_0 sin(π t/T) for 0 <= t < T",
            source: "definition",
            assumes: "a torque between the bar and the world; the trunk feels nothing",
        }
    }

    fn validate(&self) -> Result<(), OutOfRange> {
        within("torque_nm", self.torque_nm, -500.0, 500.0)?;
        within("duration_s", self.duration_s, 1e-3, MAX_DURATION_S)
    }

    fn build(&self, _: &Places, _: u64, _: &str) -> Source {
        let signal = Signal::HalfSine {
            amplitude: self.torque_nm,
            duration_s: self.duration_s,
        };
        Source {
            signal,
            effect: Effect::SteerTorque,
        }
    }
}
