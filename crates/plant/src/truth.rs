//! What a plant is given in a tick, and what is true of it after.

/// What acts on a plant during one step, held constant over it. SI, signs of
/// `twinhub_types::conventions`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PlantInput {
    /// Front hub motor brake torque, Nm.
    pub front_brake_nm: f64,
    /// Rear hub motor traction torque, Nm.
    pub rear_traction_nm: f64,
    /// Rider's torque on the handlebar, Nm.
    pub steer_torque_nm: f64,
    /// Driving force of the pedals at the rear contact, N.
    pub pedal_force_n: f64,
    /// Lateral force on the rear frame, N.
    pub lateral_force_n: f64,
    /// Where the lateral force acts: x forward of the rear contact, m.
    pub lateral_force_x_m: f64,
    /// Where the lateral force acts: height above the road, m.
    pub lateral_force_height_m: f64,
    /// Roll torque on the rear frame, Nm.
    pub roll_torque_nm: f64,
    /// Yaw torque on the rear frame, Nm.
    pub yaw_torque_nm: f64,
    /// Rider's torque between pelvis and trunk, leaning the trunk to the right, Nm.
    pub trunk_lean_torque_nm: f64,
    /// Rider's torques that turn left and right leg outward, Nm.
    pub leg_torque_nm: [f64; 2],
    /// Velocity of the air over the ground, x and y of the map, m/s.
    pub wind_m_s: [f64; 2],
    /// Velocity of the road under the rear wheel to the right of the map, m/s.
    pub rear_road_y_m_s: f64,
}

/// What is true of a plant at a tick.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Truth {
    /// Roll angle of the rear frame, rad.
    pub roll_rad: f64,
    /// Steer angle, rad.
    pub steer_rad: f64,
    /// Heading, rad.
    pub yaw_rad: f64,
    /// Pitch of the rear frame, rad.
    pub pitch_rad: f64,
    /// Roll rate, rad/s.
    pub roll_rate_rad_s: f64,
    /// Steer rate, rad/s.
    pub steer_rate_rad_s: f64,
    /// Yaw rate, rad/s.
    pub yaw_rate_rad_s: f64,
    /// Rear contact, forward on the map, m.
    pub x_m: f64,
    /// Rear contact, to the right on the map, m.
    pub y_m: f64,
    /// Forward speed, m/s.
    pub speed_m_s: f64,
    /// Front wheel rate, forward positive, rad/s.
    pub front_wheel_rate_rad_s: f64,
    /// Rear wheel rate, forward positive, rad/s.
    pub rear_wheel_rate_rad_s: f64,
    /// Vertical load of the front tyre, N.
    pub front_load_n: f64,
    /// Vertical load of the rear tyre, N.
    pub rear_load_n: f64,
    /// Longitudinal slip of the front tyre, driving positive.
    pub front_slip_ratio: f64,
    /// Longitudinal slip of the rear tyre, driving positive.
    pub rear_slip_ratio: f64,
    /// Lean of the trunk relative to the frame, rad; zero where the rider is rigid.
    pub trunk_lean_rad: f64,
    /// Its rate, rad/s.
    pub trunk_lean_rate_rad_s: f64,
    /// Left and right leg about the hip-ankle line, outward positive, rad.
    pub legs_rad: [f64; 2],
    /// Their rates, rad/s.
    pub leg_rates_rad_s: [f64; 2],
    /// Angular velocity of the rear frame in its own axes, rad/s.
    pub body_rates_rad_s: [f64; 3],
    /// Specific force at the sensor's place in the axes of the rear frame, m/s².
    pub specific_force_m_s2: [f64; 3],
}

impl Truth {
    /// True while every number is finite.
    pub fn is_finite(&self) -> bool {
        [
            self.roll_rad,
            self.steer_rad,
            self.yaw_rad,
            self.speed_m_s,
            self.roll_rate_rad_s,
            self.steer_rate_rad_s,
        ]
        .iter()
        .all(|v| v.is_finite())
    }
}

/// Something that a controller rides on.
pub trait PlantModel {
    /// Goes on by `step_s` seconds under `input`.
    fn step(&mut self, input: &PlantInput, step_s: f64);
    /// The state now.
    fn truth(&self) -> Truth;
    /// The roll beyond which the bicycle counts as fallen, rad.
    fn fall_roll_rad(&self) -> f64;
}
