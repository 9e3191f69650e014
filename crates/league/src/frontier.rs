//! Benefit against energy, with every controller on it.
//!
//! What: for riders who give torque, how much less effort and how many fewer falls than without a
//! stabilizer, as a share of what the largest constant pair gives, and at which share of its energy.

use crate::interval::{Estimate, ratio};
use crate::league::Part;
use crate::spec::Spec;
use serde::Serialize;
use twinhub_control::Law;

/// A controller on the frontier.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Point {
    /// The controller.
    pub controller: String,
    /// Energy, net from the battery, Wh/km.
    pub energy_wh_per_km: Option<f64>,
    /// Less effort than without, mean over rides that stay up with every controller, Nm.
    pub effort_saved_nm: Option<f64>,
    /// Fewer falls than without, per 1,000 km of the rides without.
    pub falls_saved_per_1000_km: Option<f64>,
    /// Effort saved as a share of what the reference saves.
    pub effort_share: Option<Estimate>,
    /// Falls saved as a share of what the reference saves.
    pub falls_share: Option<Estimate>,
    /// Energy as a share of the reference's.
    pub energy_share: Option<Estimate>,
    /// No other controller saves at least as much effort for less energy.
    pub on_frontier: bool,
}

/// The constant pair with the largest torque: what the others are measured in; `None` if none rides.
pub fn reference(spec: &Spec) -> Option<usize> {
    let pair = |law: &Law| match law {
        Law::Constant(constant) => Some(constant.pair_nm),
        _ => None,
    };
    let constants = spec.controllers.iter().enumerate().filter_map(|(i, c)| {
        let pair_nm = pair(&c.law.law)?;
        Some((i, pair_nm))
    });
    constants
        .max_by(|a, b| a.1.total_cmp(&b.1))
        .map(|(index, _)| index)
}

/// Every controller's place; riders who give torque.
pub fn frontier(spec: &Spec, parts: &[Part]) -> Vec<Point> {
    let parts: Vec<&Part> = parts.iter().filter(|p| p.class.gives_torque()).collect();
    let up: Vec<&&Part> = parts
        .iter()
        .filter(|part| part.scores.iter().all(|s| !s.metrics.fell))
        .collect();
    let effort = |part: &Part, index: usize| part.scores[index].metrics.rider_effort_rms_nm;
    let saved = |part: &Part, index: usize| effort(part, 0) - effort(part, index);
    let fell = |part: &Part, index: usize| f64::from(u8::from(part.scores[index].metrics.fell));
    let energy = |part: &Part, index: usize| {
        let m = &part.scores[index].metrics;
        // Per distance, so that a ride that ends early is not a cheap one.
        m.energy_j / 3600.0 / (m.distance_m / 1000.0).max(1e-3)
    };
    let reference = reference(spec);
    let mut points: Vec<Point> = spec
        .controllers
        .iter()
        .enumerate()
        .map(|(i, contestant)| {
            let share = |pairs: Option<Vec<(f64, f64)>>| pairs.and_then(|p| ratio(&p));
            let km: f64 = parts
                .iter()
                .map(|p| p.scores[0].metrics.distance_m / 1000.0)
                .sum();
            let falls: f64 = parts.iter().map(|p| fell(p, 0) - fell(p, i)).sum();
            let mean = |sum: f64, n: usize| (n > 0).then(|| sum / n as f64);
            let energy_wh: f64 = parts
                .iter()
                .map(|p| p.scores[i].metrics.energy_j / 3600.0)
                .sum();
            let own_km: f64 = parts
                .iter()
                .map(|p| p.scores[i].metrics.distance_m / 1000.0)
                .sum();
            Point {
                controller: contestant.name.clone(),
                energy_wh_per_km: (own_km > 0.0).then(|| energy_wh / own_km),
                effort_saved_nm: mean(up.iter().map(|p| saved(p, i)).sum(), up.len()),
                falls_saved_per_1000_km: (km > 0.0).then(|| falls / (km / 1000.0)),
                effort_share: share(
                    reference.map(|r| up.iter().map(|p| (saved(p, i), saved(p, r))).collect()),
                ),
                falls_share: share(reference.map(|r| {
                    let pair = |p: &&Part| (fell(p, 0) - fell(p, i), fell(p, 0) - fell(p, r));
                    parts.iter().map(pair).collect()
                })),
                energy_share: share(
                    reference.map(|r| parts.iter().map(|p| (energy(p, i), energy(p, r))).collect()),
                ),
                on_frontier: false,
            }
        })
        .collect();
    let place = |p: &Point| Some((p.energy_wh_per_km?, p.effort_saved_nm?));
    let places: Vec<_> = points.iter().map(place).collect();
    for (i, point) in points.iter_mut().enumerate() {
        let Some((energy, saved)) = places[i] else {
            continue;
        };
        point.on_frontier = !places
            .iter()
            .flatten()
            .any(|(e, s)| *e <= energy && *s >= saved && (*e < energy || *s > saved));
    }
    points
}
