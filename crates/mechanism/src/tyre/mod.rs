//! What tyres do beyond rolling without slip.

mod camber_stiffness;
mod cornering_stiffness;
mod twisting_torque;
mod tyre_relaxation;

pub use camber_stiffness::CamberStiffness;
pub use cornering_stiffness::CorneringStiffness;
pub use twisting_torque::TwistingTorque;
pub use tyre_relaxation::TyreRelaxation;
