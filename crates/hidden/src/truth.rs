//! What the ridden bicycle has and the declared model has not. A field at its absent value changes
//! nothing.

use crate::bicycle::Bicycle;
use crate::lateral::PointMass;

/// Everything that can be hidden in a ride.
#[derive(Clone, Debug, PartialEq)]
pub struct Truth {
    pub bicycle: Bicycle,
    /// Distance after which the path has followed 63 % of a steered heading.
    pub relaxation_m: f64,
    /// Side slip per side force, both wheels.
    pub compliance_rad_n: f64,
    pub patch: Option<Patch>,
    /// Moment about the vertical per camber angle, each wheel.
    pub twisting_nm_rad: f64,
    /// The road falls to the right.
    pub cross_slope_rad: f64,
    /// The road rises.
    pub slope_rad: f64,
    /// Wind from the left.
    pub wind_m_s: f64,
    /// Standard deviation of a gusty side force.
    pub gust_n: f64,
    pub rolling_n: f64,
    pub brake_drag_n: f64,
    pub drag_kg_m: f64,
    pub front_gain: f64,
    pub rear_gain: f64,
    pub front_lag_s: f64,
    pub rear_lag_s: f64,
    pub saturation_nm: f64,
    pub coulomb_nm: f64,
    pub steer_damping_nms_rad: f64,
    pub backlash_rad: f64,
    /// While the hands hold the bar.
    pub arm_stiffness_nm_rad: f64,
    pub arm_damping_nms_rad: f64,
    pub arm_inertia_kg_m2: f64,
    pub payload: PointMass,
    /// Mass times its distance to the right.
    pub offset_kg_m: f64,
    /// First order of the cranks; the second has 0.4 of it.
    pub pedal_nm: f64,
    /// Mass of an upper body that swings on the hip.
    pub upper_body_kg: f64,
    pub imbalance_nm_s2: f64,
    pub outside: Outside,
    pub sensors: SensorTruth,
}

/// A stretch of road with little grip.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Patch {
    pub mu: f64,
    /// Where it begins, from the start of the ride.
    pub at_m: f64,
    pub length_m: f64,
}

/// What no library names.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Outside {
    /// Steer torque against the cube of the steer angle.
    pub cubic_nm_rad3: f64,
    /// Hydraulic damper with memory: spring and damper in line between frame and fork, stiffness.
    pub maxwell_nm_rad: f64,
    /// Hysteresis of Bouc and Wen between frame and fork: its largest torque.
    pub hysteresis_nm: f64,
    /// Steer torque that comes and goes with speed: amplitude.
    pub speed_torque_nm: f64,
    /// Liquid that sloshes in a tank on the rack: mass.
    pub slosh_kg: f64,
    /// Torsional compliance of the fork: natural frequency of the front against the bar; 0: rigid.
    pub fork_hz: f64,
}

/// What the sensors make of the truth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SensorTruth {
    pub roll_bias_rad: f64,
    pub steer_bias_rad: f64,
    pub steer_scale: f64,
    pub steer_delay_s: f64,
    pub roll_rate_delay_s: f64,
    /// Rotation of the roll-rate axis towards yaw.
    pub gyro_rotation_rad: f64,
    pub speed_scale: f64,
    /// True torque per measured torque.
    pub torque_gain: f64,
    /// True force per measured force.
    pub force_gain: f64,
}

impl Truth {
    /// Exactly the model, with this bicycle.
    pub fn clean(bicycle: Bicycle) -> Self {
        Self {
            bicycle,
            relaxation_m: 0.0,
            compliance_rad_n: 0.0,
            patch: None,
            twisting_nm_rad: 0.0,
            cross_slope_rad: 0.0,
            slope_rad: 0.0,
            wind_m_s: 0.0,
            gust_n: 0.0,
            rolling_n: 0.0,
            brake_drag_n: 0.0,
            drag_kg_m: 0.0,
            front_gain: 1.0,
            rear_gain: 1.0,
            front_lag_s: 0.0,
            rear_lag_s: 0.0,
            saturation_nm: f64::INFINITY,
            coulomb_nm: 0.0,
            steer_damping_nms_rad: 0.0,
            backlash_rad: 0.0,
            arm_stiffness_nm_rad: 0.0,
            arm_damping_nms_rad: 0.0,
            arm_inertia_kg_m2: 0.0,
            payload: PointMass {
                mass_kg: 0.0,
                x_m: -0.05,
                z_m: -0.75,
            },
            offset_kg_m: 0.0,
            pedal_nm: 0.0,
            upper_body_kg: 0.0,
            imbalance_nm_s2: 0.0,
            outside: Outside::default(),
            sensors: SensorTruth {
                roll_bias_rad: 0.0,
                steer_bias_rad: 0.0,
                steer_scale: 1.0,
                steer_delay_s: 0.0,
                roll_rate_delay_s: 0.0,
                gyro_rotation_rad: 0.0,
                speed_scale: 1.0,
                torque_gain: 1.0,
                force_gain: 1.0,
            },
        }
    }

    /// Whether the tyres slip.
    pub fn slips(&self) -> bool {
        self.compliance_rad_n > 0.0 || self.patch.is_some()
    }
}
