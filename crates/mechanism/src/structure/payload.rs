//! What: something heavy rides along.
//!
//! Equation: a point mass at (x, z) joins the rear frame: mass, centre and inertias of B follow.
//!
//! Source: parallel axes.
//!
//! Assumes and ignores: rigidly fixed, in the middle plane.
//!
//! Valid for: small angles.
//!
//! Checked by: the registry's conformance tests.

use crate::card::{Card, Equation, Family, Param};
use crate::hooks::Mechanism;
use twinhub_linear::Parameters;

/// See the module.
#[derive(Debug)]
pub struct Payload;

static CARD: Card = Card {
    name: "payload",
    family: Family::Structure,
    equations: &[Equation::Roll, Equation::Longitudinal],
    claim: "something heavy rides along",
    equation: "a point mass at (x, z) joins the rear frame: mass, centre and inertias of B follow",
    source: "parallel axes",
    parameters: &[
        Param {
            name: "mass_kg",
            null: 0.0,
            least: 0.0,
            most: 60.0,
            probe: 0.5,
            starts: &[],
            about: "added mass",
        },
        Param {
            name: "x_m",
            null: 0.2,
            least: -0.5,
            most: 1.2,
            probe: 0.05,
            starts: &[],
            about: "forward of the rear contact",
        },
        Param {
            name: "z_m",
            null: -0.9,
            least: -1.6,
            most: -0.2,
            probe: 0.05,
            starts: &[],
            about: "height, negative above the ground",
        },
    ],
    requires: &[],
    confounded_with: &["arm_inertia", "lateral_offset"],
    separated_by: "a ride with and one without the load",
};

impl Mechanism for Payload {
    fn card(&self) -> &'static Card {
        &CARD
    }
    fn reshape(&self, p: &[f64], b: &mut Parameters) {
        let (mass, x, z) = (p[0], p[1], p[2]);
        if mass == 0.0 {
            return;
        }
        let total = b.mB + mass;
        let (dx, dz) = (x - b.xB, z - b.zB);
        let reduced = b.mB * mass / total;
        b.IBxx += reduced * dz * dz;
        b.IByy += reduced * (dx * dx + dz * dz);
        b.IBzz += reduced * dx * dx;
        b.IBxz -= reduced * dx * dz;
        b.xB += mass / total * dx;
        b.zB += mass / total * dz;
        b.mB = total;
    }
}
