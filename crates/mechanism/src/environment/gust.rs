//! What: the wind pushes sideways in gusts.
//!
//! Equation: a random side force at 1 m height and 0.45 of the wheelbase, a first-order Markov process
//! of standard deviation s and correlation time T: F' = -F/T + sqrt(2/T) s w, w white.
//!
//! Source: first-order spectrum of turbulence, H. L. Dryden; the point is a guess.
//!
//! Assumes and ignores: the wind's speed behind it.
//!
//! Valid for: gusts that last longer than the steps of a ride.
//!
//! Checked by: the registry's conformance tests.

use crate::card::{Card, Equation, Family, Param, Requirement};
use crate::hooks::{Mechanism, RandomForce};
use twinhub_linear::Parameters;

/// See the module.
#[derive(Debug)]
pub struct Gust;

/// Where the force acts: height, and share of the wheelbase ahead of the rear contact.
const HEIGHT_M: f64 = 1.0;
const AHEAD: f64 = 0.45;

static CARD: Card = Card {
    name: "gust",
    family: Family::Environment,
    equations: &[Equation::Roll, Equation::Steer],
    claim: "the wind pushes sideways in gusts",
    equation: "random side force at 1 m height and 0.45 of the wheelbase, a first-order Markov process",
    source: "first-order spectrum of turbulence, H. L. Dryden; the point is a guess",
    parameters: &[
        Param {
            name: "force_sd_n",
            null: 0.0,
            least: 0.0,
            most: 300.0,
            probe: 1.0,
            starts: &[2.0, 8.0, 30.0],
            about: "standard deviation of the side force",
        },
        Param {
            name: "time_s",
            null: 0.7,
            least: 0.1,
            most: 10.0,
            probe: 0.2,
            starts: &[0.4, 2.0],
            about: "correlation time of the force",
        },
    ],
    requires: &[Requirement::Road],
    confounded_with: &["upper_body_lean", "crosswind"],
    separated_by: "the same course in calm air: a gust goes with no input and no state of the bicycle",
};

impl Mechanism for Gust {
    fn card(&self) -> &'static Card {
        &CARD
    }

    fn is_random(&self) -> bool {
        true
    }

    fn random_force(&self, p: &[f64], bicycle: &Parameters) -> Option<RandomForce> {
        (p[0] > 0.0).then(|| RandomForce {
            sd: p[0],
            time_s: p[1].max(1e-3),
            arm: [HEIGHT_M, AHEAD * bicycle.c * libm::cos(bicycle.lam)],
        })
    }
}
