//! Masses and sizes that differ from the file.

mod lateral_offset;
mod payload;
mod wheel_imbalance;
mod wheel_radius;

pub use lateral_offset::LateralOffset;
pub use payload::Payload;
pub use wheel_imbalance::WheelImbalance;
pub use wheel_radius::WheelRadius;
