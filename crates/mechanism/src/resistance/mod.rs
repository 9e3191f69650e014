//! What slows the bicycle down.

mod aerodynamic_drag;
mod brake_drag;
mod motor_drag;
mod rolling_resistance;

pub use aerodynamic_drag::AerodynamicDrag;
pub use brake_drag::BrakeDrag;
pub use motor_drag::MotorDrag;
pub use rolling_resistance::RollingResistance;
