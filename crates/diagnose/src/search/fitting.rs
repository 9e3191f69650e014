//! What: calibration parameters of the baseline, on the fit rides.
//!
//! Equation: parameters z (in declared standard deviations) by Gauss-Newton on sum e²/s + z², within
//! a box.
//!
//! Source: Harvey (1989), section 3.4.5; the box after the finding that free calibration eats
//! causes, see `thresholds.toml`.
//!
//! Assumes and ignores: levels shared by all rides.
//!
//! Valid for: some hundred readings a level.
//!
//! Checked by: `tests` of the search on simulated rides.

use super::levels::fit_levels;
use super::rides::{Column, Passes, Rides};
use super::step::bounded_step;
use super::thresholds::THRESHOLDS;
use crate::engine::small::dot;
use crate::engine::{FreeNoise, Model};
use crate::study::{Study, Tolerance};
use std::sync::Arc;
use twinhub_linear::SYMBOLS;

/// Columns of the calibration parameters that matter, with their index into all, and their products.
#[derive(Debug, Default)]
pub struct Columns {
    pub list: Vec<(usize, Column)>,
    /// One column times another, by rows.
    products: Vec<f64>,
}

impl Columns {
    /// Leaves out those that move the innovations too little.
    fn new(all: Vec<Column>) -> Arc<Self> {
        let matters = |c: &Column| 0.5 * dot(c, c) > THRESHOLDS.calibration_least_nats;
        let list: Vec<(usize, Column)> = all
            .into_iter()
            .enumerate()
            .filter(|(_, c)| matters(c))
            .collect();
        let m = list.len();
        let mut products = vec![0.0; m * m];
        for i in 0..m {
            for j in 0..=i {
                let x = dot(&list[i].1, &list[j].1);
                products[i * m + j] = x;
                products[j * m + i] = x;
            }
        }
        Arc::new(Self { list, products })
    }

    /// Of the baseline's model, after a pass over the rides.
    pub fn of(rides: &Rides, baseline: &Baseline, passes: &Passes) -> Arc<Self> {
        Self::new(calibration_columns(
            rides,
            &baseline.model,
            passes,
            &baseline.all,
            &baseline.z,
        ))
    }

    /// Products of all columns, with more behind them, by rows.
    pub fn with(&self, more: &[&Column]) -> Vec<f64> {
        let known = self.list.len();
        let m = known + more.len();
        let mut products = vec![0.0; m * m];
        for i in 0..m {
            for j in 0..=i {
                let x = match (i.checked_sub(known), j.checked_sub(known)) {
                    (None, _) => self.product(i, j),
                    (Some(i), Some(j)) => dot(more[i], more[j]),
                    (Some(i), None) => dot(more[i], &self.list[j].1),
                };
                products[i * m + j] = x;
                products[j * m + i] = x;
            }
        }
        products
    }

    /// Product of the columns at two places of the list.
    pub fn product(&self, i: usize, j: usize) -> f64 {
        self.products[i * self.list.len() + j]
    }
}

/// One calibration parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Calibrated {
    pub symbol: &'static str,
    pub value: f64,
    pub sd: f64,
}

/// The parameters that may be calibrated, with their declared standard deviations.
pub fn calibrated(study: &Study, bicycle: &twinhub_linear::Bicycle) -> Vec<Calibrated> {
    let free = SYMBOLS
        .iter()
        .filter(|s| !matches!(**s, "g" | "IByy" | "IHyy"));
    free.filter_map(|&symbol| {
        let value = bicycle.get(symbol)?;
        let sd = match study.tolerances.get(symbol) {
            Some(Tolerance::Ratio(r)) => r * value.abs(),
            Some(Tolerance::Absolute(a)) => *a,
            None => study.tolerance_ratio * value.abs(),
        };
        (sd > 0.0).then_some(Calibrated { symbol, value, sd })
    })
    .collect()
}

/// A model with calibration parameters z away from the declared values, or none if it cannot be.
pub fn moved(model: &Model, all: &[Calibrated], z: &[f64]) -> Option<Model> {
    let mut model = model.clone();
    for (c, z) in all.iter().zip(z) {
        model.bicycle.set(c.symbol, c.value + z * c.sd).ok()?;
    }
    Some(model)
}

/// Columns of the calibration parameters, one declared standard deviation each.
fn calibration_columns(
    rides: &Rides,
    model: &Model,
    passes: &Passes,
    all: &[Calibrated],
    z: &[f64],
) -> Vec<Column> {
    (0..all.len())
        .map(|i| {
            let step = if z[i] > 0.0 { -0.5 } else { 0.5 };
            let mut there = z.to_vec();
            there[i] += step;
            let plant = moved(model, all, &there).and_then(|m| m.plant().ok());
            match plant {
                Some(plant) => passes
                    .column(rides, model, &plant)
                    .iter()
                    .map(|x| x / step)
                    .collect(),
                None => vec![0.0; passes.passes.iter().map(|p| p.error.len()).sum()],
            }
        })
        .collect()
}

/// Whether a calibration parameter stands at the end of its box.
pub fn is_at_end(z: f64) -> bool {
    z.abs() > THRESHOLDS.calibration_box_sd - 1e-3
}

/// A calibrated model.
#[derive(Clone)]
pub struct Baseline {
    pub model: Model,
    pub all: Vec<Calibrated>,
    pub z: Vec<f64>,
    pub columns: Arc<Columns>,
    /// Log likelihood of the fit rides, prior included, with the sign turned.
    pub cost: f64,
}

impl Baseline {
    /// Levels and calibration in turn.
    pub fn fit(
        rides: &Rides,
        free: &FreeNoise,
        model: Model,
        all: Vec<Calibrated>,
        progress: &mut dyn FnMut(&str),
    ) -> Option<Self> {
        let mut this = Self {
            z: vec![0.0; all.len()],
            model,
            all,
            columns: Arc::default(),
            cost: 0.0,
        };
        progress("noise levels");
        // Long rides: most of the way on an excerpt.
        let excerpt = rides.excerpt(&this.model);
        let excerpt = excerpt.filter(|e| 3 * e.readings() < rides.readings());
        let (first, rounds) = excerpt.as_ref().map_or((rides, 5), |e| (e, 6));
        this.model = fit_levels(first, free, &this.model, rounds);
        this.calibrate(first, 2)?;
        this.model = fit_levels(first, free, &this.model, 3);
        progress("calibration");
        this.calibrate(rides, 2)?;
        this.model = fit_levels(rides, free, &this.model, 3);
        this.calibrate(rides, 2)?;
        Some(this)
    }

    /// Symbols whose value lies farther from the declared one than `limit` standard deviations.
    pub fn beyond(&self, limit: f64) -> Vec<String> {
        let all = self.all.iter().zip(&self.z);
        all.filter(|(_, z)| z.abs() > limit)
            .map(|(c, _)| c.symbol.to_owned())
            .collect()
    }

    /// Gauss-Newton steps on the calibration parameters at fixed levels, `most` of them.
    fn calibrate(&mut self, rides: &Rides, most: usize) -> Option<()> {
        let prior = |z: &[f64]| 0.5 * dot(z, z);
        self.model = moved(&self.model, &self.all, &self.z)?;
        let mut passes = Passes::run(rides, &self.model, true)?;
        self.cost = passes.minus_log_likelihood() + prior(&self.z);
        let limit = THRESHOLDS.calibration_box_sd;
        for _ in 0..most {
            self.columns = Columns::of(rides, self, &passes);
            let kept = &self.columns.list;
            let m = kept.len();
            if m == 0 {
                break;
            }
            let at: Vec<f64> = kept.iter().map(|(i, _)| self.z[*i]).collect();
            let step = bounded_step(
                &passes.whitened(),
                &self.columns,
                &[],
                &vec![1.0; m],
                &at,
                &vec![0.0; m],
                &vec![-limit; m],
                &vec![limit; m],
            );
            let mut share = 1.0;
            let mut gained = 0.0;
            while share > 0.1 {
                let mut there = self.z.clone();
                for ((i, _), d) in kept.iter().zip(&step) {
                    there[*i] = (there[*i] + share * d).clamp(-limit, limit);
                }
                let trial = moved(&self.model, &self.all, &there);
                let found = trial.and_then(|m| Passes::run(rides, &m, true).map(|p| (m, p)));
                if let Some((m, p)) = found {
                    let value = p.minus_log_likelihood() + prior(&there);
                    if value < self.cost {
                        gained = self.cost - value;
                        (self.model, passes, self.cost, self.z) = (m, p, value, there);
                        break;
                    }
                }
                share *= 0.4;
            }
            if gained < 0.1 {
                break;
            }
        }
        Some(())
    }
}
