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

use super::decide::Blocks;
use super::fitting::{Baseline, Columns, moved};
use super::levels::fit_levels;
use super::phases;
use super::random;
use super::rides::{Column, Passes, Rides};
use super::score::active_columns;
use super::skew;
use super::step::bounded_step;
use super::thresholds::THRESHOLDS;
use crate::engine::small::{dot, solve};
use crate::engine::{Active, FreeNoise};
use crate::quantity::Quantity;
use std::collections::BTreeMap;
use twinhub_mechanism::Mechanism;

/// A fitted extension of a baseline.
#[derive(Clone)]
pub struct Refit {
    pub baseline: Baseline,
    /// Standard deviation of every parameter of every active mechanism.
    pub sd: Vec<Vec<f64>>,
}

/// Steps of a sketch, and of the fit that follows it, at most.
const FIRST_ROUNDS: usize = 1;
const ROUNDS: usize = 4;
/// Turns of levels and parameters at most, the gain of a turn that is the last, and the gain of levels
/// from which on the calibration's columns are formed again.
const MOST_TURNS: usize = 6;
const SETTLED_NATS: f64 = 3.0;
const REFRESHED_FROM_NATS: f64 = 30.0;

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

/// Cost of a model over rides; infinite where it cannot be.
pub fn cost_over(rides: &Rides, baseline: &Baseline) -> f64 {
    Passes::run(rides, &baseline.model, false).map_or(f64::INFINITY, |p| cost(&p, baseline))
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
        let (mut more, mut weights): (Vec<&Column>, Vec<f64>) = (vec![], vec![]);
        let (mut at, mut origin, mut least, mut most) = (vec![], vec![], vec![], vec![]);
        for (i, _) in &now.columns.list {
            weights.push(1.0);
            at.push(now.z[*i]);
            origin.push(0.0);
            least.push(-limit);
            most.push(limit);
        }
        for (a, list) in now.model.active.iter().zip(&own) {
            let null = a.mechanism.null(&now.model.bicycle.parameters);
            for (k, (param, column)) in a.mechanism.card().parameters.iter().zip(list).enumerate() {
                more.push(column);
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
            &now.columns,
            &more,
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
            for (i, _) in &now.columns.list {
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

/// Adds a mechanism to the baseline and takes the first steps of its fit: from the linear size, and
/// from the grid.
pub fn sketch(
    rides: &Rides,
    baseline: &Baseline,
    mechanism: &'static dyn Mechanism,
    size: &[f64],
) -> Option<Baseline> {
    let card = mechanism.card();
    let parameters = &baseline.model.bicycle.parameters;
    let mut starts = vec![if mechanism.has_phase_by_ride() {
        phases::active(mechanism, size, rides, parameters)
    } else {
        Active::new(mechanism, mechanism.from_probes(size, parameters))
    }];
    for value in card.parameters[0].starts {
        let mut p = mechanism.null(parameters);
        p[0] = *value;
        starts.push(Active::new(mechanism, p));
    }
    for active in &mut starts {
        for (x, param) in active.p.iter_mut().zip(card.parameters) {
            *x = x.clamp(param.least, param.most);
        }
    }
    let extended = |active: Active| {
        let mut there = baseline.clone();
        there.model.active.push(active);
        there
    };
    if starts.len() > 1 {
        let mut trials: Vec<(f64, Active)> = starts
            .into_iter()
            .filter_map(|active| {
                let value = cost_over(rides, &extended(active.clone()));
                value.is_finite().then_some((value, active))
            })
            .collect();
        trials.sort_by(|a, b| a.0.total_cmp(&b.0));
        trials.truncate(2);
        starts = trials.into_iter().map(|(_, active)| active).collect();
    }
    starts
        .into_iter()
        .filter_map(|active| polish(rides, extended(active), FIRST_ROUNDS))
        .filter(|b| b.cost.is_finite())
        .min_by(|a, b| a.cost.total_cmp(&b.cost))
}

/// The rest of the fit that a sketch began, with its uncertainties.
pub fn refit(rides: &Rides, free: &FreeNoise, sketch: Baseline) -> Option<Refit> {
    finish(rides, settle(rides, free, sketch)?)
}

/// Parameters, levels and columns in turn for as long as that gains anything. A strong effect takes several
/// turns: levels fall once it is explained, and what the calibration did without it has to be undone.
pub fn settle(rides: &Rides, free: &FreeNoise, begun: Baseline) -> Option<Baseline> {
    let mut best = polish(rides, begun, ROUNDS)?;
    for turn in 0..MOST_TURNS {
        let before = best.cost;
        // The first turn whatever the innovations say: a random walk that has swallowed a small steady force
        // leaves them as large as they should be.
        if turn > 0 && !are_levels_off(rides, &best)? {
            break;
        }
        best.model = fit_levels(rides, free, &best.model, 1);
        let is_strong = before - cost_over(rides, &best) > REFRESHED_FROM_NATS;
        if is_strong {
            best = refreshed(rides, best)?;
        }
        best = polish(rides, best, if is_strong { 2 } else { 1 })?;
        if before - best.cost < SETTLED_NATS {
            break;
        }
    }
    Some(best)
}

/// The calibration's columns at the present model.
pub fn refreshed(rides: &Rides, mut baseline: Baseline) -> Option<Baseline> {
    let passes = Passes::run(rides, &baseline.model, true)?;
    baseline.columns = Columns::of(rides, &baseline, &passes);
    baseline.cost = cost(&passes, &baseline);
    Some(baseline)
}

/// Whether the innovations of some sensor are smaller or larger than the levels say, by more than
/// chance.
fn are_levels_off(rides: &Rides, fit: &Baseline) -> Option<bool> {
    const LEAST_Z: f64 = 3.0;
    let passes = Passes::run(rides, &fit.model, false)?;
    // By quantity: sum of squares over variances, and count.
    let mut sums: BTreeMap<Quantity, [f64; 2]> = BTreeMap::new();
    for (index, pass) in passes.passes.iter().enumerate() {
        let sensors = &rides.0[index].ride.sensors;
        let readings = &passes.course(rides, index).readings;
        for (reading, (e, s)) in readings.iter().zip(pass.error.iter().zip(&pass.variance)) {
            let sum = sums.entry(sensors[reading.sensor].quantity).or_default();
            sum[0] += e * e / s;
            sum[1] += 1.0;
        }
    }
    Some(
        sums.values()
            .any(|[squares, count]| (squares - count).abs() > LEAST_Z * (2.0 * count).sqrt()),
    )
}

/// Variance of the estimate `row` times the columns' scores, from its parts in the blocks: with more noise
/// than the levels say, or noise that is not white, it is larger than the information lets expect.
fn between_blocks(row: &[f64], columns: &[&Column], residual: &Column, block: &[usize]) -> f64 {
    let mut sums = vec![0.0; block.iter().max().map_or(0, |b| b + 1)];
    for (k, b) in block.iter().enumerate() {
        let influence: f64 = row.iter().zip(columns).map(|(c, g)| c * g[k]).sum();
        sums[*b] += influence * residual[k];
    }
    sums.iter().map(|s| s * s).sum()
}

/// Uncertainties of a fit: the classical ones, or those of the blocks where these are larger.
pub fn finish(rides: &Rides, mut best: Baseline) -> Option<Refit> {
    let passes = Passes::run(rides, &best.model, true)?;
    let own: Vec<Vec<Column>> = (0..best.model.active.len())
        .map(|i| active_columns(rides, &best, &passes, i))
        .collect();
    let skew = skew::columns(rides, &best.model, &passes);
    let flat: Vec<&Column> = skew.iter().chain(own.iter().flatten()).collect();
    let mut normal = best.columns.with(&flat);
    let k = flat.len() - skew.len();
    let m = best.columns.list.len() + flat.len();
    for i in 0..m {
        normal[i * m + i] += if i < m - k {
            1.0
        } else {
            1e-9 + 1e-9 * normal[i * m + i]
        };
    }
    let units: Vec<Vec<f64>> = (m - k..m)
        .map(|i| (0..m).map(|j| if i == j { 1.0 } else { 0.0 }).collect())
        .collect();
    let rows: Vec<Vec<f64>> = if k == 0 {
        vec![]
    } else {
        solve(&normal, &units)?
    };
    let columns: Vec<&Column> = (best.columns.list.iter().map(|(_, c)| c))
        .chain(flat.iter().copied())
        .collect();
    let block = Blocks::numbers(&passes.stamps(rides));
    let residual = passes.whitened();
    let mut rows = rows.iter().enumerate().map(|(i, row)| {
        let classical = row[m - k + i];
        classical
            .max(between_blocks(row, &columns, &residual, &block))
            .max(0.0)
            .sqrt()
    });
    let sd: Vec<Vec<f64>> = best
        .model
        .active
        .iter()
        .map(|a| rows.by_ref().take(a.p.len()).collect())
        .collect();
    let random = |(index, own): (usize, Vec<f64>)| {
        if best.model.active[index].mechanism.is_random() {
            random::errors(rides, &best, index)
        } else {
            own
        }
    };
    let sd = sd.into_iter().enumerate().map(random).collect();
    best.cost = cost(&passes, &best);
    Some(Refit { baseline: best, sd })
}
