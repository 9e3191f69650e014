//! What: tyres slip sideways in proportion to their side force.
//!
//! Equation: r = v k (F_rear - F_front)/w added to the yaw rate, with the side forces of the no-
//! slip motion, and -v k F_rear to the lateral velocity.
//!
//! Source: Meijaard, Papadopoulos, Ruina and Schwab (2007), equations (4.1)-(4.6); slip as a
//! perturbation, own.
//!
//! Assumes and ignores: the side forces are those without slip; one compliance for both wheels.
//!
//! Valid for: small angles.
//!
//! Checked by: the registry's conformance tests.

use crate::card::{Card, Equation, Family, Param, Requirement};
use crate::hooks::Mechanism;
use crate::moment::{Moment, Wrench};

/// See the module.
#[derive(Debug)]
pub struct CorneringStiffness;

static CARD: Card = Card {
    name: "cornering_stiffness",
    family: Family::Tyre,
    equations: &[Equation::Roll, Equation::Steer, Equation::Lateral],
    claim: "tyres slip sideways in proportion to their side force",
    equation: "r = v k (F_rear - F_front)/w added to the yaw rate, with the side forces of the no-slip motion, and -v k F_rear to the lateral velocity",
    source: "Meijaard, Papadopoulos, Ruina and Schwab (2007), equations (4.1)-(4.6); slip as a perturbation, own",
    parameters: &[Param {
        name: "compliance_rad_n",
        null: 0.0,
        least: 0.0,
        most: 2e-3,
        probe: 1e-5,
        starts: &[5e-5, 2e-4],
        about: "slip angle per side force",
    }],
    requires: &[Requirement::SpeedRange(1.15)],
    confounded_with: &["steer_sensor_scale", "tyre_relaxation"],
    separated_by: "a range of speeds: the effect grows with the square of speed",
};

impl Mechanism for CorneringStiffness {
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
        slipping(p[0], &at.settled(|at| slipping(p[0], at)))
    }
}

/// Wrench of the slip with the accelerations of `at`.
fn slipping(compliance_rad_n: f64, at: &Moment<'_>) -> Wrench {
    let (v, b) = (at.speed_m_s, at.body);
    let share = b.front_share();
    let front = b.mass_kg * share * v;
    let rear = b.mass_kg * (1.0 - share) * v;
    let (yaw, turn) = (at.yaw_rate_rad_s(), at.yaw_accel_rad_s2());
    // Roll acceleration loads both wheels through the height of the centre.
    let lift = b.mass_kg * b.centre_m[1] * at.accel_rad_s2[0];
    let (front_n, rear_n) = (
        front * yaw + lift * share,
        rear * yaw + lift * (1.0 - share),
    );
    let wheelbase = b.parameters.w;
    let rate = v * compliance_rad_n * (rear_n - front_n) / wheelbase;
    let slope = v * compliance_rad_n * (rear - front) * turn / wheelbase;
    let mut wrench = b.slip_wrench(v, rate, slope);
    // The rear contact's sideways acceleration.
    let aside = -v * compliance_rad_n * rear * turn;
    wrench.roll_nm -= b.mass_kg * b.centre_m[1] * aside;
    wrench.steer_nm -= b.yaw[1] * b.mass_kg * b.centre_m[0] * aside;
    wrench
}
