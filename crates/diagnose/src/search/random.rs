//! What: fits of slow random torques: a gust, or the latent force that says how much of the residual
//! has no name.
//!
//! Equation: the standard deviation and the correlation time that make the innovations most likely,
//! found on a grid and then coordinate by coordinate; standard errors from second differences of the
//! likelihood.
//!
//! Source: latent force models: M. Alvarez, D. Luengo and N. D. Lawrence (2009), of order one half;
//! S. Särkkä and A. Solin, Applied Stochastic Differential Equations (2019), chapter 12.
//!
//! Assumes and ignores: one torque an equation; the calibration stays where it is.
//!
//! Valid for: correlation times from 0.1 s on: what is faster is white noise to the predictor.
//!
//! Checked by: `tests` of the search.

use super::fitting::Baseline;
use super::refit::cost_over;
use super::rides::Rides;
use super::thresholds::THRESHOLDS;
use crate::engine::{Active, Latent};
use twinhub_mechanism::Mechanism;

/// Correlation times that are tried for a latent force.
const TIMES_S: [f64; 2] = [0.4, 2.0];
/// Standard deviations that are tried, Nm.
const SIZES_NM: [f64; 3] = [1.0, 4.0, 16.0];
/// Factor of the first steps away from the grid, and of the last.
const FIRST_FACTOR: f64 = 1.6;
const LAST_FACTOR: f64 = 1.1;

/// Cost at two positive values, or infinity.
type Cost<'a> = &'a dyn Fn([f64; 2]) -> f64;

/// The best of a grid, then better ones next to it; none if nothing on the grid costs less than
/// `enough`.
fn descend(
    grid: &[[f64; 2]],
    [least, most]: [[f64; 2]; 2],
    enough: f64,
    cost: Cost<'_>,
) -> Option<[f64; 2]> {
    let (mut at, mut value) = grid
        .iter()
        .map(|p| (*p, cost(*p)))
        .min_by(|a, b| a.1.total_cmp(&b.1))
        .filter(|best| best.1 < enough)?;
    let mut factor = FIRST_FACTOR;
    while factor > LAST_FACTOR {
        let mut moved = false;
        for index in 0..2 {
            for step in [factor, 1.0 / factor] {
                let mut there = at;
                there[index] = (there[index] * step).clamp(least[index], most[index]);
                let c = cost(there);
                if c < value - 0.05 {
                    (at, value, moved) = (there, c, true);
                    break;
                }
            }
        }
        if !moved {
            factor = factor.sqrt();
        }
    }
    value.is_finite().then_some(at)
}

/// Adds a random mechanism and fits it.
pub fn sketch(
    rides: &Rides,
    baseline: &Baseline,
    mechanism: &'static dyn Mechanism,
) -> Option<Baseline> {
    let extended = |p: [f64; 2]| {
        let mut there = baseline.clone();
        there.model.active.push(Active::new(mechanism, p.to_vec()));
        there
    };
    let cost_of = |p: [f64; 2]| cost_over(rides, &extended(p));
    let [size, time] = mechanism.card().parameters else {
        return None;
    };
    let grid: Vec<[f64; 2]> = (size.starts.iter())
        .flat_map(|s| time.starts.iter().map(move |t| [*s, *t]))
        .collect();
    let best = descend(
        &grid,
        [[1e-3 * size.probe, time.least], [size.most, time.most]],
        baseline.cost - THRESHOLDS.evidence_nats,
        &cost_of,
    )?;
    let mut found = extended(best);
    found.cost = cost_of(best);
    Some(found)
}

/// The latent torque of one axis that explains most, and its nats on the rides.
pub fn latent(rides: &Rides, baseline: &Baseline, axis: usize) -> Option<(Latent, f64)> {
    let with = |p: [f64; 2]| {
        let mut there = baseline.clone();
        there.model.latent[axis] = Some(torque(axis, p));
        there
    };
    let cost_of = |p: [f64; 2]| cost_over(rides, &with(p));
    let grid: Vec<[f64; 2]> = (SIZES_NM.iter())
        .flat_map(|s| TIMES_S.iter().map(move |t| [*s, *t]))
        .collect();
    let enough = baseline.cost - THRESHOLDS.evidence_nats;
    let best = descend(&grid, [[1e-3, 0.1], [1e3, 10.0]], enough, &cost_of)?;
    Some((torque(axis, best), baseline.cost - cost_of(best)))
}

/// A torque on roll (0) or steer (1) alone.
fn torque(axis: usize, [sd, time_s]: [f64; 2]) -> Latent {
    let mut arm = [0.0; 2];
    arm[axis] = 1.0;
    Latent { sd, time_s, arm }
}

/// Standard errors of a random mechanism's parameters.
pub fn errors(rides: &Rides, fit: &Baseline, index: usize) -> Vec<f64> {
    let at = &fit.model.active[index].p;
    let cost_of = |p: &[f64]| {
        let mut there = fit.clone();
        there.model.active[index].p = p.to_vec();
        cost_over(rides, &there)
    };
    let here = cost_of(at);
    (0..at.len())
        .map(|i| {
            let step = 0.1 * at[i].abs();
            let side = |sign: f64| {
                let mut p = at.clone();
                p[i] += sign * step;
                cost_of(&p)
            };
            let curvature = (side(1.0) + side(-1.0) - 2.0 * here) / (step * step);
            if curvature > 0.0 {
                curvature.sqrt().recip()
            } else {
                f64::NAN
            }
        })
        .collect()
}
