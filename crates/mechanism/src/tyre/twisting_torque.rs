//! What: a cambered tyre twists about the vertical, into the lean.
//!
//! Equation: Mz = k (roll + steer sin(lam)) at the front, k roll at the rear; steer torque
//! Mz_front (cos(lam) + mu) + Mz_rear mu, mu = c cos(lam)/w.
//!
//! Source: V. E. Bulsink (2017), Bicycling stability, tyre model with twisting torque; reduction
//! to the steer equation own.
//!
//! Assumes and ignores: proportional to camber; load as at rest.
//!
//! Valid for: small angles.
//!
//! Checked by: the registry's conformance tests.

use crate::body::Terms;
use crate::card::{Card, Equation, Family, Param};
use crate::hooks::Mechanism;

/// See the module.
#[derive(Debug)]
pub struct TwistingTorque;

static CARD: Card = Card {
    name: "twisting_torque",
    family: Family::Tyre,
    equations: &[Equation::Steer],
    claim: "a cambered tyre twists about the vertical, into the lean",
    equation: "Mz = k (roll + steer sin(lam)) at the front, k roll at the rear; steer torque Mz_front (cos(lam) + mu) + Mz_rear mu, mu = c cos(lam)/w",
    source: "V. E. Bulsink (2017), Bicycling stability, tyre model with twisting torque; reduction to the steer equation own",
    parameters: &[Param {
        name: "nm_rad",
        null: 0.0,
        least: -20.0,
        most: 20.0,
        probe: 0.2,
        starts: &[],
        about: "torque per camber angle, each wheel",
    }],
    requires: &[],
    confounded_with: &["arm_stiffness", "steer_sensor_bias"],
    separated_by: "steady circles both ways, and another load: the torque is proportional to load, not to speed",
};

impl Mechanism for TwistingTorque {
    fn card(&self) -> &'static Card {
        &CARD
    }
    fn terms(&self, p: &[f64], terms: &mut Terms) {
        let (sin, cos, mu) = (terms.sin_tilt, terms.cos_tilt, terms.trail_ratio);
        terms.stiffness[0][(1, 0)] -= p[0] * (cos + 2.0 * mu);
        terms.stiffness[0][(1, 1)] -= p[0] * (cos + mu) * sin;
    }
}
