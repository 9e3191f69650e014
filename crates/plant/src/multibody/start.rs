//! Where a ride starts, beside straight and upright.

use super::ride::Ride;
use super::state::{ANGULAR, LEGS, STEER, STEER_RATE, StateAccess, TRUNK, VELOCITY};
use super::steady::Steady;

/// What is added to a steady state.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Disturbed {
    /// Roll about the rear contact point, rad.
    pub roll_rad: f64,
    /// Roll rate about it, rad/s.
    pub roll_rate_rad_s: f64,
    /// Steer, rad.
    pub steer_rad: f64,
    /// Steer rate, rad/s.
    pub steer_rate_rad_s: f64,
    /// Trunk lean, pitch, twist, rad.
    pub trunk_rad: [f64; 3],
    /// Left and right leg, rad.
    pub legs_rad: [f64; 2],
}

impl Ride {
    /// Starts from a steady state, at the height of the road.
    pub fn start_from(&mut self, steady: &Steady) {
        let mut state = steady.state;
        if let Some(road) = self.road() {
            state[2] -= road.height_m(0.0, 0.0);
        }
        self.set_state(&state);
    }

    /// Adds to the state: the frame turns about the rear contact point, speed along the road and
    /// tyre deflection stay.
    pub fn disturb(&mut self, by: &Disturbed) {
        let mut x = *self.state();
        let (yaw, roll, pitch) = x.yaw_roll_pitch_rad();
        if by.roll_rad != 0.0 {
            let road = self.road().map_or(0.0, |r| r.height_m(x[0], x[1]));
            // The hub stands above the contact in the plane of the wheel.
            let height = -(x[2] + road) / libm::cos(roll);
            let (s, c) = libm::sincos(yaw);
            let aside = height * (libm::sin(roll + by.roll_rad) - libm::sin(roll));
            x[0] -= aside * s;
            x[1] += aside * c;
            x[2] = -road - height * libm::cos(roll + by.roll_rad);
            x.set_attitude_rad(yaw, roll + by.roll_rad, pitch);
        }
        let road = self.road().map_or(0.0, |r| r.height_m(x[0], x[1]));
        let height = -(x[2] + road) / libm::cos(roll + by.roll_rad);
        // About the forward axis of the heading, seen from the pitched frame.
        let (sp, cp) = libm::sincos(pitch);
        x[ANGULAR] += cp * by.roll_rate_rad_s;
        x[ANGULAR + 2] += sp * by.roll_rate_rad_s;
        x[VELOCITY + 1] += height * by.roll_rate_rad_s;
        x[STEER] += by.steer_rad;
        x[STEER_RATE] += by.steer_rate_rad_s;
        for k in 0..3 {
            x[TRUNK + k] += by.trunk_rad[k];
        }
        for k in 0..2 {
            x[LEGS + k] += by.legs_rad[k];
        }
        self.set_state(&x);
    }
}

#[cfg(test)]
mod tests {
    use super::super::{BulsinkBicycle, Case, Parameters, Reading};
    use super::*;
    use crate::PlantModel;

    #[test]
    fn a_disturbance_moves_what_it_names_and_keeps_the_tyres_loaded() {
        let p = Parameters::bulsink2017(BulsinkBicycle::One, Case::Full, &Reading::default());
        let mut ride = Ride::new(&p, None, 5.0).unwrap();
        let before = ride.contacts();
        ride.disturb(&Disturbed {
            roll_rad: 0.05,
            roll_rate_rad_s: 0.2,
            steer_rad: -0.01,
            steer_rate_rad_s: 0.1,
            trunk_rad: [0.01, 0.02, 0.03],
            legs_rad: [0.04, 0.05],
        });
        let truth = ride.truth();
        let near = |a: f64, b: f64, by: f64| assert!((a - b).abs() < by, "{a} {b}");
        near(truth.roll_rad, 0.05, 1e-12);
        near(truth.roll_rate_rad_s, 0.2, 1e-9);
        near(truth.steer_rad, -0.01, 1e-15);
        near(ride.state()[TRUNK + 2], 0.03, 1e-15);
        near(ride.state()[LEGS + 1], 0.05, 1e-15);
        near(truth.speed_m_s, 5.0, 1e-3);
        let after = ride.contacts();
        // The rear wheel stands as deep in the road, and its contact point does not slip sideways.
        near(after[0].deflection_m, before[0].deflection_m, 1e-6);
        near(after[0].slip_angle_rad, 0.0, 2e-3);
    }
}
