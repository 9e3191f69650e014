//! What: which rides went along the road, and which came back.
//!
//! Equation: the direction of the mean of (cos, sin) of the heading in a ride's first seconds is the road's;
//! rides within 45 degrees of the first one's road go along it (1), within 45 degrees of its opposite back
//! (-1), others at its cosine.
//!
//! Source: mean of directions: K. V. Mardia and P. E. Jupp, Directional Statistics (2000), section 2.2.
//!
//! Assumes and ignores: a ride starts along its road; headings drift, bicycles that are pushed turn away, and
//! neither turns the road. Where the heading is not known, or goes round, a ride counts as going along.
//!
//! Valid for: headings in one frame over all rides; an integrated gyro that starts at zero knows none.
//!
//! Checked by: `tests`.

use super::ride::Ride;
use crate::data::RideData;
use crate::quantity::Quantity;

/// Length of the mean of the unit vectors from which on a ride has a direction.
const LEAST_LENGTH: f64 = 0.5;
/// Length of a start.
const START_S: f64 = 2.0;

/// Gives every ride its way; the road is that of the first ride to fit that has one. Held-out headings turn
/// no ride that is fitted.
pub fn set(fit: &mut [Ride], held: &mut [Ride], data: &[RideData]) {
    let road = |ride: &Ride| {
        let recorded = data.iter().find(|d| d.spec.file == ride.file)?;
        road_rad(recorded, &ride.windows)
    };
    let Some(first) = fit.iter().find_map(road) else {
        return;
    };
    for ride in fit.iter_mut().chain(held) {
        ride.way = road(ride).map_or(1.0, |road| way(road - first));
    }
}

/// Direction at the start of the first of these windows.
fn road_rad(data: &RideData, windows: &[[f64; 2]]) -> Option<f64> {
    let heading = data
        .channels
        .iter()
        .find(|c| c.spec.quantity == Quantity::Yaw && !c.samples.is_empty())?;
    let from = windows.iter().map(|w| w[0]).fold(f64::INFINITY, f64::min);
    let start = (heading.samples.iter())
        .skip_while(|s| s.0 < from)
        .take_while(|s| s.0 < from + START_S);
    mean_direction_rad(start.map(|s| s.1))
}

fn mean_direction_rad(headings: impl Iterator<Item = f64>) -> Option<f64> {
    let (mut cos, mut sin, mut count) = (0.0, 0.0, 0.0);
    for heading in headings {
        let (s, c) = libm::sincos(heading);
        (cos, sin, count) = (cos + c, sin + s, count + 1.0);
    }
    (libm::hypot(cos, sin) > LEAST_LENGTH * count).then(|| libm::atan2(sin, cos))
}

fn way(turned_rad: f64) -> f64 {
    let cos = libm::cos(turned_rad);
    if cos.abs() > std::f64::consts::FRAC_1_SQRT_2 {
        cos.signum()
    } else {
        cos
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weaving_about_a_road_is_going_along_it() {
        let weave = |k: usize| 3.1 + 0.4 * libm::sin(0.3 * k as f64);
        let road = mean_direction_rad((0..1000).map(weave)).unwrap();
        assert!((road - 3.1).abs() < 0.01, "{road}");
        assert_eq!(way(road), -1.0);
        assert_eq!(way(0.3), 1.0);
        assert!((way(1.4) - libm::cos(1.4)).abs() < 1e-12);
    }

    #[test]
    fn a_circle_has_no_direction() {
        assert_eq!(mean_direction_rad((0..1000).map(|k| 0.05 * k as f64)), None);
    }
}
