//! What a mechanism may look at, and what it gives back.

use crate::body::Body;
use nalgebra::{Matrix2, Vector2};

/// Forces and torques that are known to act.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Inputs {
    pub roll_torque_nm: f64,
    pub steer_torque_nm: f64,
    /// Side force on the rear frame, and its torque about the vertical through the rear contact.
    pub side_force_n: f64,
    pub yaw_torque_nm: f64,
    pub front_brake_nm: f64,
    pub rear_traction_nm: f64,
}

/// One moment of a ride, in the signs of `twinhub_types::conventions`.
#[derive(Clone, Copy, Debug)]
pub struct Moment<'a> {
    pub body: &'a Body,
    pub t_s: f64,
    /// Length of the step that the wrench is held over.
    pub dt_s: f64,
    pub speed_m_s: f64,
    pub accel_m_s2: f64,
    /// Way since the start of the window.
    pub travel_m: f64,
    /// Roll and steer.
    pub angle_rad: [f64; 2],
    pub rate_rad_s: [f64; 2],
    /// As the equations give it without the mechanism.
    pub accel_rad_s2: [f64; 2],
    pub inputs: Inputs,
    /// Angle of the cranks, where it was measured.
    pub crank_rad: Option<f64>,
    /// Angle of the front wheel, where its rate was measured, from where the heavy side is down in front; where
    /// that is not known, from where it stood at first.
    pub wheel_rad: Option<f64>,
    pub trunk_lean_rad: Option<f64>,
    /// Along the road of the study: 1; the other way: -1; a road at an angle: its cosine. What belongs to the
    /// road or the air changes sides with it.
    pub way: f64,
}

impl Moment<'_> {
    /// Yaw rate without slip.
    pub fn yaw_rate_rad_s(&self) -> f64 {
        self.body.yaw[0] * self.speed_m_s * self.angle_rad[1]
            + self.body.yaw[1] * self.rate_rad_s[1]
    }

    /// Yaw acceleration without slip.
    pub fn yaw_accel_rad_s2(&self) -> f64 {
        self.body.yaw[0]
            * (self.speed_m_s * self.rate_rad_s[1] + self.accel_m_s2 * self.angle_rad[1])
            + self.body.yaw[1] * self.accel_rad_s2[1]
    }
}

impl<'a> Moment<'a> {
    /// The same moment with the accelerations that come out when a wrench acts which depends on them
    /// (linearly): it is asked three times.
    pub fn settled(&self, wrench: impl Fn(&Self) -> Wrench) -> Self {
        let torque = |accel: [f64; 2]| {
            let w = wrench(&Self {
                accel_rad_s2: accel,
                ..*self
            });
            Vector2::new(w.roll_nm, w.steer_nm)
        };
        let [roll, steer] = self.accel_rad_s2;
        let here = torque([roll, steer]);
        let slope = Matrix2::from_columns(&[
            torque([roll + 1.0, steer]) - here,
            torque([roll, steer + 1.0]) - here,
        ]);
        let inverse = self.body.mass_inverse;
        let added = (Matrix2::identity() - inverse * slope)
            .try_inverse()
            .map_or_else(Vector2::zeros, |m| m * (inverse * here));
        Self {
            accel_rad_s2: [roll + added.x, steer + added.y],
            ..*self
        }
    }
}

/// What a mechanism adds.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Wrench {
    pub roll_nm: f64,
    pub steer_nm: f64,
    /// Forward.
    pub force_n: f64,
    /// Part of `force_n` that is gravity's: an accelerometer does not feel it.
    pub gravity_n: f64,
    /// Yaw rate that slip adds to the kinematic one, for sensors.
    pub yaw_rate_rad_s: f64,
}

impl std::ops::AddAssign for Wrench {
    fn add_assign(&mut self, other: Self) {
        self.roll_nm += other.roll_nm;
        self.steer_nm += other.steer_nm;
        self.force_n += other.force_n;
        self.gravity_n += other.gravity_n;
        self.yaw_rate_rad_s += other.yaw_rate_rad_s;
    }
}
