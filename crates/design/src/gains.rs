//! What: riders who have got used to a bicycle: at each speed the gains that leave the largest margin
//! of growth over all corners of a box of bicycles and both edges of the tube.
//!
//! Equation: gains minimise the largest growth rate over the corners, by Nelder and Mead's simplex
//! from the gains of the neighbouring speed, plus a small price on the squared distance from there: a
//! rider's gains follow speed, and a proof between two speeds lives on it.
//!
//! Source: as `twinhub_plant::rider::design`.
//!
//! Assumes and ignores: gains are linear in speed between the nodes, as in rider files.
//!
//! Valid for: as `loops`.
//!
//! Checked by: the growth rates that a certificate reports.

use crate::family::Vehicle;
use crate::loops::{Gains, Rider, worst_growth_per_s};
use twinhub_plant::rider::design::simplex;

/// Starts where there is no neighbour.
const STARTS: [Gains; 3] = [
    [18.0, 0.0, 0.0, 0.0],
    [-10.0, -2.0, 10.0, 1.0],
    [8.0, 2.0, 10.0, 1.0],
];

/// Steps of the simplex from a neighbour's gains.
const NEAR: Gains = [1.0, 0.3, 1.0, 0.2];
/// What a distance of one such step from the neighbour's gains costs, 1/s.
const DISTANCE_PER_S: f64 = 0.02;

/// The gains, and the growth rate that they leave at worst, 1/s.
pub fn gains(rider: &Rider, vehicles: &[Vehicle], neighbour: Option<&Gains>) -> (Gains, f64) {
    let growth = |k: &[f64]| {
        let gains: Gains = [k[0], k[1], k[2], k[3]];
        worst_growth_per_s(&rider.close_all(vehicles, &gains))
    };
    let distance = |k: &[f64]| {
        let steps = |g: &Gains| -> f64 {
            let parts = k.iter().zip(g).zip(&NEAR);
            parts.map(|((k, g), step)| ((k - g) / step).powi(2)).sum()
        };
        neighbour.map_or(0.0, steps)
    };
    let price = |k: &[f64]| growth(k) + DISTANCE_PER_S * distance(k);
    let starts: Vec<Gains> = neighbour.map_or_else(|| STARTS.to_vec(), |g| vec![*g]);
    let size = if neighbour.is_some() {
        NEAR
    } else {
        [4.0, 1.0, 4.0, 0.5]
    };
    let (best, _) = starts
        .iter()
        .map(|start| simplex(&price, start, &size))
        .min_by(|a, b| a.1.total_cmp(&b.1))
        .unwrap_or((vec![0.0; 4], f64::INFINITY));
    let growth_per_s = growth(&best);
    ([best[0], best[1], best[2], best[3]], growth_per_s)
}
