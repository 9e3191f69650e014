//! What the rider adds: arms, load, pedals, trunk.

mod arm_damping;
mod arm_inertia;
mod arm_stiffness;
mod pedalling_torque;
mod upper_body_lean;

pub use arm_damping::ArmDamping;
pub use arm_inertia::ArmInertia;
pub use arm_stiffness::ArmStiffness;
pub use pedalling_torque::PedallingTorque;
pub use upper_body_lean::UpperBodyLean;
