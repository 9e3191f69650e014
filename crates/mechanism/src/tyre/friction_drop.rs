//! What: for a stretch the front tyre cannot bear its side force.
//!
//! Equation: within the patch the front side force is limited to mu times load; the lack turns
//! the bicycle less: r' = -(F - mu N) w/I, forgotten after it at v/0.1 m.
//!
//! Source: Coulomb; reduction to a lack of yaw rate own.
//!
//! Assumes and ignores: only the front wheel; vertical load at rest.
//!
//! Valid for: small angles.
//!
//! Checked by: the registry's conformance tests.

use crate::card::{Card, Equation, Family, Param};
use crate::hooks::Mechanism;
use crate::moment::{Moment, Wrench};

/// See the module.
#[derive(Debug)]
pub struct FrictionDrop;

static CARD: Card = Card {
    name: "friction_drop",
    family: Family::Tyre,
    equations: &[Equation::Lateral, Equation::Steer, Equation::Roll],
    claim: "for a stretch the front tyre cannot bear its side force",
    equation: "within the patch the front side force is limited to mu times load; the lack turns the bicycle less: r' = -(F - mu N) w/I, forgotten after it at v/0.1 m",
    source: "Coulomb; reduction to a lack of yaw rate own",
    parameters: &[
        Param {
            name: "mu",
            null: 1.0,
            least: 0.0,
            most: 1.0,
            probe: -0.9,
            starts: &[0.05, 0.2],
            about: "friction in the patch",
        },
        Param {
            name: "t_s",
            null: 0.0,
            least: 0.0,
            most: 600.0,
            probe: 1.0,
            starts: &[],
            about: "when the front wheel reaches it, from the start of the window",
        },
        Param {
            name: "length_m",
            null: 1.0,
            least: 0.1,
            most: 20.0,
            probe: 1.0,
            starts: &[],
            about: "length of the patch",
        },
    ],
    requires: &[],
    confounded_with: &["gust"],
    separated_by: "a second pass over the same place: the patch stays, a gust does not",
};

impl Mechanism for FrictionDrop {
    fn card(&self) -> &'static Card {
        &CARD
    }
    fn pushes(&self) -> bool {
        true
    }

    fn memory(&self) -> usize {
        2
    }

    fn remember(&self, p: &[f64], at: &Moment<'_>, memory: &mut [f64], fresh: bool) {
        if fresh {
            memory.fill(0.0);
            return;
        }
        let b = at.body;
        let load = b.mass_kg * b.gravity_m_s2 * b.front_share();
        let inside = at.t_s >= p[1] && at.t_s < p[1] + p[2] / at.speed_m_s.abs().max(0.1);
        let wanted = b.mass_kg * b.front_share() * at.speed_m_s * (at.yaw_rate_rad_s() + memory[0]);
        let lack = if inside {
            wanted - wanted.clamp(-p[0] * load, p[0] * load)
        } else {
            0.0
        };
        let inertia = b.mass_kg * b.centre_m[0] * (b.parameters.w - b.centre_m[0]) + 1.0;
        memory[1] = -lack * b.parameters.w / inertia;
        if !inside {
            memory[1] -= memory[0] * at.speed_m_s.abs() / 0.1;
        }
        memory[0] += memory[1] * at.dt_s;
        if !inside && at.speed_m_s.abs() * at.dt_s > 0.1 {
            memory[0] = 0.0;
        }
    }

    fn wrench(&self, _p: &[f64], at: &Moment<'_>, memory: &[f64]) -> Wrench {
        at.body.slip_wrench(at.speed_m_s, memory[0], memory[1])
    }
}
