//! Road and wind.

mod cross_slope;
mod crosswind;
mod longitudinal_slope;

pub use cross_slope::CrossSlope;
pub use crosswind::Crosswind;
pub use longitudinal_slope::LongitudinalSlope;
