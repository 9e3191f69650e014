//! The closed list of mechanisms. A new one is one file and one line here.

use crate::hooks::Mechanism;
use crate::{environment, input, resistance, rider, sensor, steering, structure, tyre};

/// All mechanisms, in the order in which they are listed.
pub static ALL: &[&dyn Mechanism] = &[
    &tyre::TyreRelaxation,
    &tyre::CorneringStiffness,
    &tyre::TwistingTorque,
    &tyre::CamberStiffness,
    &steering::SteerCoulombFriction,
    &steering::SteerDamping,
    &steering::HeadsetBacklash,
    &rider::ArmStiffness,
    &rider::ArmDamping,
    &rider::ArmInertia,
    &rider::PedallingTorque,
    &rider::UpperBodyLean,
    &structure::Payload,
    &structure::LateralOffset,
    &structure::WheelRadius,
    &environment::CrossSlope,
    &environment::LongitudinalSlope,
    &environment::Crosswind,
    &environment::Gust,
    &resistance::RollingResistance,
    &resistance::AerodynamicDrag,
    &resistance::BrakeDrag,
    &resistance::MotorDrag,
    &input::FrontMotorGain,
    &input::FrontMotorLag,
    &input::RearMotorGain,
    &input::RearMotorLag,
    &input::MotorSaturation,
    &input::SteerTorqueGain,
    &input::LateralForceGain,
    &sensor::RollSensorBias,
    &sensor::SteerSensorBias,
    &sensor::SteerSensorScale,
    &sensor::SteerSensorDelay,
    &sensor::RollRateSensorDelay,
    &sensor::GyroMisalignment,
    &sensor::SpeedScale,
    &sensor::SpeedQuantisation,
    &sensor::RiderDelay,
    &structure::WheelImbalance,
];

/// The mechanism of a name.
pub fn find(name: &str) -> Option<&'static dyn Mechanism> {
    ALL.iter().copied().find(|m| m.card().name == name)
}

/// All names.
pub fn names() -> impl Iterator<Item = &'static str> {
    ALL.iter().map(|m| m.card().name)
}
