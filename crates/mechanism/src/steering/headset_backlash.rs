//! What: bar and fork have play: the measured bar leads the fork by half the gap, on the side of
//! the torque.
//!
//! Equation: reading = fork angle + gap/2 sign(bar torque).
//!
//! Source: own: a light bar stands at the edge of the play to which the torque pushes it.
//!
//! Assumes and ignores: the bar has no inertia of its own; it crosses the gap at once; the sensor
//! sits on the bar.
//!
//! Valid for: small angles.
//!
//! Checked by: the registry's conformance tests.

use crate::card::{Card, Equation, Family, Param, Requirement};
use crate::hooks::Mechanism;
use crate::moment::Moment;
use crate::quantity::Quantity;

/// See the module.
#[derive(Debug)]
pub struct HeadsetBacklash;

static CARD: Card = Card {
    name: "headset_backlash",
    family: Family::Structure,
    equations: &[Equation::Steer, Equation::Sensor],
    claim: "bar and fork have play: the measured bar leads the fork by half the gap, on the side of the torque",
    equation: "reading = fork angle + gap/2 sign(bar torque)",
    source: "own: a light bar stands at the edge of the play to which the torque pushes it",
    parameters: &[Param {
        name: "gap_rad",
        null: 0.0,
        least: 0.0,
        most: 0.2,
        probe: 0.004,
        starts: &[0.01],
        about: "full play",
    }],
    requires: &[
        Requirement::Output(Quantity::Steer),
        Requirement::Input(Quantity::SteerTorque),
    ],
    confounded_with: &["steer_coulomb_friction"],
    separated_by: "two steer encoders, on bar and fork, and slow torque reversals",
};

impl Mechanism for HeadsetBacklash {
    fn card(&self) -> &'static Card {
        &CARD
    }
    fn reads(&self) -> bool {
        true
    }

    fn reading(&self, p: &[f64], quantity: Quantity, at: &Moment<'_>) -> f64 {
        let torque = at.inputs.steer_torque_nm;
        match quantity {
            Quantity::Steer if torque != 0.0 => 0.5 * p[0] * torque.signum(),
            _ => 0.0,
        }
    }
}
