//! Road and wind.

mod cross_slope;
mod crosswind;
mod gust;
mod longitudinal_slope;

pub use cross_slope::CrossSlope;
pub use crosswind::Crosswind;
pub use gust::Gust;
pub use longitudinal_slope::LongitudinalSlope;
