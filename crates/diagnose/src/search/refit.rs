//! What: the fit of a mechanism's parameters, jointly with calibration and the causes accepted
//! before, on the fit rides.
//!
//! Equation: Gauss-Newton on the whitened innovations with bounds; every trial is a whole pass with
//! the gain of its own model; starts from the linear size and the card's grid.
//!
//! Source: Ljung (1999), section 10.2.
//!
//! Assumes and ignores: the calibration's columns stay those of the baseline.
//!
//! Valid for: effects up to the bounds of the cards.
//!
//! Checked by: `tests` of the search.

use super::fitting::{Baseline, Column, Passes, Rides, bounded_step, fit_levels, moved};
use super::score::active_columns;
use super::thresholds::THRESHOLDS;
use crate::engine::small::{dot, solve};
use crate::engine::{Active, FreeNoise};
use twinhub_mechanism::Mechanism;

/// A fitted extension of a baseline.
#[derive(Clone)]
pub struct Refit {
    pub baseline: Baseline,
    /// Standard deviation of every parameter of every active mechanism.
    pub sd: Vec<Vec<f64>>,
}

const ROUNDS: usize = 4;

fn prior(baseline: &Baseline) -> f64 {
    let z = 0.5 * dot(&baseline.z, &baseline.z);
    let secondary = baseline.model.active.iter().map(|a| {
        let null = a.mechanism.null(&baseline.model.bicycle.parameters);
        let parameters = a.mechanism.card().parameters.iter().enumerate();
        parameters
            .map(|(i, p)| {
                0.5 * precision(i, p.name, p.most - p.least)
                    * (a.p[i] - null[i])
                    * (a.p[i] - null[i])
            })
            .sum::<f64>()
    });
    z + secondary.sum::<f64>()
}

/// A place where a load may sit is known roughly; sizes, phases and times are not.
fn precision(index: usize, name: &str, range: f64) -> f64 {
    if index > 0 && name.ends_with("_m") {
        36.0 / (range * range)
    } else {
        0.0
    }
}

/// Cost of a model: minus log likelihood and priors.
pub fn cost(passes: &Passes, baseline: &Baseline) -> f64 {
    passes.minus_log_likelihood() + prior(baseline)
}

/// Fits everything that is active, from where the baseline stands.
pub fn polish(rides: &Rides, start: Baseline, rounds: usize) -> Option<Baseline> {
    let mut now = start;
    let mut passes = Passes::run(rides, &now.model, true)?;
    let mut value = cost(&passes, &now);
    let limit = THRESHOLDS.calibration_box_sd;
    for _ in 0..rounds {
        let own: Vec<Vec<Column>> = (0..now.model.active.len())
            .map(|i| active_columns(rides, &now, &passes, i))
            .collect();
        let (mut columns, mut weights): (Vec<&Column>, Vec<f64>) = (vec![], vec![]);
        let (mut at, mut origin, mut least, mut most) = (vec![], vec![], vec![], vec![]);
        for (i, column) in &now.columns {
            columns.push(column);
            weights.push(1.0);
            at.push(now.z[*i]);
            origin.push(0.0);
            least.push(-limit);
            most.push(limit);
        }
        for (a, list) in now.model.active.iter().zip(&own) {
            let null = a.mechanism.null(&now.model.bicycle.parameters);
            for (k, (param, column)) in a.mechanism.card().parameters.iter().zip(list).enumerate() {
                columns.push(column);
                weights.push(
                    precision(k, param.name, param.most - param.least) + 1e-7 * dot(column, column),
                );
                at.push(a.p[k]);
                origin.push(null[k]);
                least.push(param.least);
                most.push(param.most);
            }
        }
        let step = bounded_step(
            &passes.whitened(),
            &columns,
            &weights,
            &at,
            &origin,
            &least,
            &most,
        );
        let mut share = 1.0;
        let mut gained = 0.0;
        while share > 0.05 {
            let mut there = now.clone();
            let mut next = step
                .iter()
                .zip(&at)
                .zip(least.iter().zip(&most))
                .map(|((d, a), (l, m))| (a + share * d).clamp(*l, *m));
            for (i, _) in &now.columns {
                there.z[*i] = next.next()?;
            }
            for a in &mut there.model.active {
                for p in &mut a.p {
                    *p = next.next()?;
                }
            }
            let trial = moved(&there.model, &there.all, &there.z);
            if let Some(model) = trial {
                there.model = model;
                if let Some(p) = Passes::run(rides, &there.model, true) {
                    let c = cost(&p, &there);
                    if c < value {
                        gained = value - c;
                        (now, passes, value) = (there, p, c);
                        break;
                    }
                }
            }
            share *= 0.35;
        }
        if gained < 0.1 {
            break;
        }
    }
    now.cost = value;
    Some(now)
}

/// Adds a mechanism to the baseline and fits it: from the linear size, and from the grid.
pub fn refit(
    rides: &Rides,
    free: &FreeNoise,
    baseline: &Baseline,
    mechanism: &'static dyn Mechanism,
    size: &[f64],
) -> Option<Refit> {
    let card = mechanism.card();
    let parameters = &baseline.model.bicycle.parameters;
    let inside = |mut p: Vec<f64>| {
        for (x, param) in p.iter_mut().zip(card.parameters) {
            *x = x.clamp(param.least, param.most);
        }
        p
    };
    let mut starts = vec![inside(mechanism.from_probes(size, parameters))];
    for value in card.parameters[0].starts {
        let mut p = mechanism.null(parameters);
        p[0] = *value;
        starts.push(inside(p));
    }
    let mut trials: Vec<(f64, Baseline)> = starts
        .into_iter()
        .filter_map(|p| {
            let mut there = baseline.clone();
            there.model.active.push(Active { mechanism, p });
            let passes = Passes::run(rides, &there.model, false)?;
            let value = cost(&passes, &there);
            value.is_finite().then_some((value, there))
        })
        .collect();
    trials.sort_by(|a, b| a.0.total_cmp(&b.0));
    trials.truncate(2);
    let best = trials
        .into_iter()
        .filter_map(|(_, start)| polish(rides, start, ROUNDS))
        .min_by(|a, b| a.cost.total_cmp(&b.cost))?;
    finish(rides, free, best, 1)
}

/// Levels once more, and uncertainties.
pub fn finish(
    rides: &Rides,
    free: &FreeNoise,
    mut best: Baseline,
    level_rounds: usize,
) -> Option<Refit> {
    if level_rounds > 0 {
        best.model = fit_levels(rides, free, &best.model, level_rounds);
        best = polish(rides, best, 1)?;
    }
    let passes = Passes::run(rides, &best.model, true)?;
    let own: Vec<Vec<Column>> = (0..best.model.active.len())
        .map(|i| active_columns(rides, &best, &passes, i))
        .collect();
    let flat: Vec<&Column> = own.iter().flatten().collect();
    let all: Vec<&Column> = best
        .columns
        .iter()
        .map(|(_, c)| c)
        .chain(flat.iter().copied())
        .collect();
    let (m, k) = (all.len(), flat.len());
    let mut normal = vec![0.0; m * m];
    for i in 0..m {
        for j in 0..=i {
            let x = dot(all[i], all[j]);
            normal[i * m + j] = x;
            normal[j * m + i] = x;
        }
        normal[i * m + i] += if i < m - k {
            1.0
        } else {
            1e-9 + 1e-9 * normal[i * m + i]
        };
    }
    let units: Vec<Vec<f64>> = (m - k..m)
        .map(|i| (0..m).map(|j| if i == j { 1.0 } else { 0.0 }).collect())
        .collect();
    let covariance: Vec<Vec<f64>> = if k == 0 {
        vec![]
    } else {
        solve(&normal, &units)?
            .iter()
            .map(|c| c[m - k..].to_vec())
            .collect()
    };
    let mut index = 0;
    let sd = best
        .model
        .active
        .iter()
        .map(|a| {
            a.p.iter()
                .map(|_| {
                    index += 1;
                    covariance[index - 1][index - 1].max(0.0).sqrt()
                })
                .collect()
        })
        .collect();
    best.cost = cost(&passes, &best);
    Some(Refit { baseline: best, sd })
}
