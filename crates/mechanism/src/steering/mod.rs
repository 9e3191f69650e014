//! The steering: friction, damping, play.

mod headset_backlash;
mod steer_coulomb_friction;
mod steer_damping;

pub use headset_backlash::HeadsetBacklash;
pub use steer_coulomb_friction::SteerCoulombFriction;
pub use steer_damping::SteerDamping;
