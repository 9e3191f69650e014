//! Motors and force sensors: what is commanded or read is not what acts.

mod front_motor_gain;
mod front_motor_lag;
mod lateral_force_gain;
mod motor_saturation;
mod rear_motor_gain;
mod rear_motor_lag;
mod steer_torque_gain;

pub use front_motor_gain::FrontMotorGain;
pub use front_motor_lag::FrontMotorLag;
pub use lateral_force_gain::LateralForceGain;
pub use motor_saturation::MotorSaturation;
pub use rear_motor_gain::RearMotorGain;
pub use rear_motor_lag::RearMotorLag;
pub use steer_torque_gain::SteerTorqueGain;
