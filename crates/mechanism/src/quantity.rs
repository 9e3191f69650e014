//! The closed list of measured quantities.

use serde::{Deserialize, Serialize};

macro_rules! quantities {
    ($($(#[$doc:meta])* $variant:ident = $name:literal,)*) => {
        /// What a channel measures, in the unit at the end of its name.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
        pub enum Quantity { $($(#[$doc])* #[serde(rename = $name)] $variant,)* }

        impl Quantity {
            /// All names, as in study files.
            pub const NAMES: &'static [&'static str] = &[$($name),*];

            /// The name, as in study files.
            pub const fn name(self) -> &'static str {
                match self { $(Self::$variant => $name,)* }
            }
        }
    };
}

quantities! {
    Roll = "roll_rad",
    RollRate = "roll_rate_rad_s",
    Steer = "steer_rad",
    SteerRate = "steer_rate_rad_s",
    Yaw = "yaw_rad",
    YawRate = "yaw_rate_rad_s",
    Speed = "speed_m_s",
    LongitudinalAccel = "longitudinal_accel_m_s2",
    LateralAccel = "lateral_accel_m_s2",
    SteerTorque = "steer_torque_nm",
    RollTorque = "roll_torque_nm",
    LateralForce = "lateral_force_n",
    FrontBrake = "front_brake_nm",
    RearTraction = "rear_traction_nm",
    FrontWheelRate = "front_wheel_rate_rad_s",
    RearWheelRate = "rear_wheel_rate_rad_s",
    CrankAngle = "crank_angle_rad",
    Cadence = "cadence_rad_s",
    PedalTorque = "pedal_torque_nm",
    TrunkLean = "trunk_lean_rad",
    MotorCurrent = "motor_current_a",
    RoadSlope = "road_slope_rad",
}

impl Quantity {
    /// Whether the benchmark bicycle can be driven by it.
    pub fn drives_benchmark(self) -> bool {
        use Quantity::*;
        matches!(
            self,
            Speed | SteerTorque | RollTorque | LateralForce | FrontBrake | RearTraction | RoadSlope
        )
    }

    /// Whether the benchmark bicycle says what it should be.
    pub fn predicted_by_benchmark(self) -> bool {
        use Quantity::*;
        self.is_lateral()
            || matches!(
                self,
                Speed | LongitudinalAccel | FrontWheelRate | RearWheelRate
            )
    }

    /// Whether it belongs to roll, steer and yaw.
    pub fn is_lateral(self) -> bool {
        use Quantity::*;
        matches!(
            self,
            Roll | RollRate | Steer | SteerRate | Yaw | YawRate | LateralAccel
        )
    }
}

impl std::fmt::Display for Quantity {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}
