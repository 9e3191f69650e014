//! What: the headset rubs with a constant torque and can stick.
//!
//! Equation: torque -T sign(steer rate); it holds the steering still where the rest of the
//! torques cannot overcome T.
//!
//! Source: Coulomb; C. Canudas de Wit and others (1995) for why sticking matters; time-stepping
//! form after Moreau, torque = -clamp(I rate_free/h, T).
//!
//! Assumes and ignores: one torque for sticking and sliding.
//!
//! Valid for: small angles.
//!
//! Checked by: the registry's conformance tests.

use crate::card::{Card, Equation, Family, Param};
use crate::hooks::Mechanism;
use crate::moment::{Moment, Wrench};

/// See the module.
#[derive(Debug)]
pub struct SteerCoulombFriction;

static CARD: Card = Card {
    name: "steer_coulomb_friction",
    family: Family::Structure,
    equations: &[Equation::Steer],
    claim: "the headset rubs with a constant torque and can stick",
    equation: "torque -T sign(steer rate); it holds the steering still where the rest of the torques cannot overcome T",
    source: "Coulomb; C. Canudas de Wit and others (1995) for why sticking matters; time-stepping form after Moreau, torque = -clamp(I rate_free/h, T)",
    parameters: &[Param {
        name: "torque_nm",
        null: 0.0,
        least: 0.0,
        most: 5.0,
        probe: 0.02,
        starts: &[0.05, 0.2, 0.5],
        about: "friction torque",
    }],
    requires: &[],
    confounded_with: &["steer_damping", "headset_backlash"],
    separated_by: "two steering amplitudes at one speed: the apparent damping falls with amplitude",
};

impl Mechanism for SteerCoulombFriction {
    fn card(&self) -> &'static Card {
        &CARD
    }
    fn pushes(&self) -> bool {
        true
    }

    fn feeds_back(&self) -> bool {
        true
    }

    fn wrench(&self, p: &[f64], at: &Moment<'_>, _memory: &[f64]) -> Wrench {
        // Rate at the end of the step if nothing rubbed, and the torque that would stop it just then.
        let free = at.rate_rad_s[1] + at.dt_s * at.accel_rad_s2[1];
        let stop = -free * at.body.steer_inertia_kg_m2() / at.dt_s.max(1e-4);
        Wrench {
            steer_nm: stop.clamp(-p[0], p[0]),
            ..Wrench::default()
        }
    }
}
