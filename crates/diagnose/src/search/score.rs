//! What: score tests: would a mechanism explain what the baseline leaves?
//!
//! Equation: with the mechanism's columns G, whitened innovations e and nuisance columns N of prior
//! precision L: U = G'e, I = G'G - G'N (N'N + L)^-1 N'G, size -I^-1 U, statistic U'I^-1 U ~ chi²
//! under the baseline; V sums the outer products of the scores of blocks after the size is taken
//! off, and U'V^-1 U is the statistic if it is smaller.
//!
//! Source: C. R. Rao's score test; block sandwich after W. K. Newey and K. D. West (1987);
//! Y. Benjamini and D. Yekutieli (2001) for the false discovery rate of dependent tests.
//!
//! Assumes and ignores: effects small enough for the innovations to be linear in them.
//!
//! Valid for: ten blocks and more.
//!
//! Checked by: `tests`: against refits, and p-values on clean rides.

use super::decide::Blocks;
use super::fitting::Baseline;
use super::phases::by_ride;
use super::rides::{Column, Passes, Rides};
use super::skew;
use super::thresholds::THRESHOLDS;
use crate::engine::small::{dot, solve};
use nalgebra::{Cholesky, DMatrix, DVector, Dyn};
use statrs::distribution::{ChiSquared, ContinuousCDF};
use twinhub_mechanism::Mechanism;

/// A mechanism under test.
pub struct Score {
    pub mechanism: &'static dyn Mechanism,
    /// Columns with the nuisances taken out.
    pub projected: Vec<Column>,
    /// In units of the probes.
    pub size: Vec<f64>,
    /// First parameter's deviation from null at the first probe.
    pub unit: f64,
    pub information: Vec<f64>,
    pub statistic: f64,
    pub p_value: f64,
    /// How much wider than the classical variance the blocks say, at least 1.
    pub widening: f64,
}

impl Score {
    /// Information about the first parameter: about an amplitude, whatever the phases of the rides are, half
    /// of what both columns of all rides have.
    pub fn first_information(&self) -> f64 {
        if self.mechanism.has_phase_by_ride() {
            let k = self.size.len();
            0.5 * (0..k).map(|i| self.information[i * k + i]).sum::<f64>()
        } else {
            self.information[0]
        }
    }

    /// Linear estimate of the first parameter, away from null.
    pub fn first_size(&self) -> f64 {
        self.size[0] * self.unit
    }
}

/// What the residual looks like to a test.
pub struct Bench<'a> {
    pub rides: &'a Rides,
    pub baseline: &'a Baseline,
    pub passes: Passes,
    /// Whitened innovations, what channels that lie apart in time explain taken off.
    pub residual: Column,
    pub nuisance: Vec<Column>,
    /// N'N + L, factored; none if there are no nuisances, or none that count.
    factored: Option<Cholesky<f64, Dyn>>,
    pub block: Vec<usize>,
    pub blocks: usize,
    /// Ride of each entry.
    pub ride: Vec<usize>,
}

impl<'a> Bench<'a> {
    /// Predicts the rides with the baseline and gathers what is nuisance.
    pub fn new(rides: &'a Rides, baseline: &'a Baseline) -> Option<Self> {
        let passes = Passes::run(rides, &baseline.model, true)?;
        let stamps = passes.stamps(rides);
        let block = Blocks::numbers(&stamps);
        let limit = THRESHOLDS.calibration_box_sd - 1e-6;
        let mut nuisance: Vec<Column> = vec![];
        let mut precision = vec![];
        // A parameter at its box is held.
        let free: Vec<usize> = (0..baseline.columns.list.len())
            .filter(|i| baseline.z[baseline.columns.list[*i].0].abs() < limit)
            .collect();
        for index in &free {
            nuisance.push(baseline.columns.list[*index].1.clone());
            precision.push(1.0);
        }
        let mut residual = passes.whitened();
        let mut slope = vec![0.0; nuisance.len()];
        for column in skew::columns(rides, &baseline.model, &passes) {
            slope.push(dot(&column, &residual));
            nuisance.push(column);
            precision.push(1.0);
        }
        for index in 0..baseline.model.active.len() {
            for column in active_columns(rides, baseline, &passes, index) {
                let weight = dot(&column, &column);
                if weight > 0.0 {
                    precision.push(1e-6 * weight);
                    slope.push(0.0);
                    nuisance.push(column);
                }
            }
        }
        let m = nuisance.len();
        let mut normal = DMatrix::zeros(m, m);
        for i in 0..m {
            for j in 0..=i {
                let x = if i < free.len() {
                    baseline.columns.product(free[i], free[j])
                } else {
                    dot(&nuisance[i], &nuisance[j])
                };
                normal[(i, j)] = x;
                normal[(j, i)] = x;
            }
            normal[(i, i)] += precision[i];
        }
        let factored = (m > 0).then(|| normal.cholesky()).flatten();
        // What was fitted explains nothing more; channels that lie apart in time may.
        if let Some(factored) = &factored {
            let step = factored.solve(&DVector::from_vec(slope));
            for (size, column) in step.iter().zip(&nuisance) {
                for (e, n) in residual.iter_mut().zip(column) {
                    *e -= size * n;
                }
            }
        }
        Some(Self {
            residual,
            blocks: block.iter().max().map_or(0, |b| b + 1),
            ride: stamps.iter().map(|s| s.0).collect(),
            block,
            rides,
            baseline,
            passes,
            nuisance,
            factored,
        })
    }

    /// Takes the nuisances out of columns: projected columns and information.
    pub fn project(&self, columns: &[Column]) -> (Vec<Column>, Vec<f64>) {
        let k = columns.len();
        let cross: Vec<Vec<f64>> = columns
            .iter()
            .map(|g| self.nuisance.iter().map(|n| dot(n, g)).collect())
            .collect();
        let mut projected = columns.to_vec();
        let mut information = vec![0.0; k * k];
        let solved = self.factored.as_ref().map(|factored| -> Vec<DVector<f64>> {
            let solve = |c: &Vec<f64>| factored.solve(&DVector::from_column_slice(c));
            cross.iter().map(solve).collect()
        });
        for (i, column) in projected.iter_mut().enumerate() {
            if let Some(solved) = &solved {
                for (factor, n) in solved[i].iter().zip(&self.nuisance) {
                    for (x, y) in column.iter_mut().zip(n) {
                        *x -= factor * y;
                    }
                }
            }
            for j in 0..k {
                let lost = solved
                    .as_ref()
                    .map_or(0.0, |s| dot(s[i].as_slice(), &cross[j]));
                information[i * k + j] = dot(&columns[i], &columns[j]) - lost;
            }
        }
        (projected, information)
    }

    /// Columns of a mechanism that is absent from the baseline.
    pub fn columns(&self, mechanism: &'static dyn Mechanism) -> Vec<Column> {
        let bicycle = &self.baseline.model.bicycle;
        let columns: Vec<Column> = mechanism
            .probes(&bicycle.parameters)
            .into_iter()
            .map(|p| {
                let plant = self.baseline.model.with(mechanism, p).plant();
                match plant {
                    Ok(plant) => self.passes.column(self.rides, &self.baseline.model, &plant),
                    Err(_) => vec![0.0; self.residual.len()],
                }
            })
            .collect();
        if mechanism.has_phase_by_ride() {
            by_ride(&columns, &self.ride, self.rides.0.len())
        } else {
            columns
        }
    }

    /// Tests a mechanism; one that is random shows in no mean.
    pub fn score(&self, mechanism: &'static dyn Mechanism) -> Option<Score> {
        if mechanism.is_random() {
            return None;
        }
        let columns = self.columns(mechanism);
        self.score_columns(mechanism, columns)
    }

    fn score_columns(
        &self,
        mechanism: &'static dyn Mechanism,
        columns: Vec<Column>,
    ) -> Option<Score> {
        let k = columns.len();
        let (projected, information) = self.project(&columns);
        // A column that the nuisances explain wholly cannot be tested.
        for i in 0..k {
            let raw = dot(&columns[i], &columns[i]);
            if !(information[i * k + i] > 1e-6 * raw && raw > 1e-12) {
                return None;
            }
        }
        let score: Vec<f64> = columns.iter().map(|g| dot(g, &self.residual)).collect();
        let size: Vec<f64> = solve(&information, &[score.clone()])?[0]
            .iter()
            .map(|x| -x)
            .collect();
        let classical = -dot(&size, &score);
        // Scores of the blocks with the effect taken off.
        let mut blocks = vec![vec![0.0; k]; self.blocks];
        for (index, b) in self.block.iter().enumerate() {
            let mut left = self.residual[index];
            for (c, g) in size.iter().zip(&projected) {
                left += c * g[index];
            }
            for (sum, g) in blocks[*b].iter_mut().zip(&projected) {
                *sum += g[index] * left;
            }
        }
        let mut sandwich = vec![0.0; k * k];
        for sum in &blocks {
            for i in 0..k {
                for j in 0..k {
                    sandwich[i * k + j] += sum[i] * sum[j];
                }
            }
        }
        let count = self.blocks as f64;
        let robust = if self.blocks > 2 * k + 2 {
            for x in &mut sandwich {
                *x *= count / (count - k as f64);
            }
            solve(&sandwich, &[score.clone()]).map_or(classical, |s| dot(&s[0], &score))
        } else {
            classical
        };
        let mut statistic = classical.min(robust).max(0.0);
        let widening = if robust > 0.0 {
            (classical / robust).max(1.0)
        } else {
            1.0
        };
        let card = mechanism.card();
        let first = &card.parameters[0];
        let bicycle = &self.baseline.model.bicycle.parameters;
        let null = mechanism.null(bicycle)[0];
        let unit = mechanism.probes(bicycle)[0][0] - null;
        let by_chance = ChiSquared::new(k as f64).map_or(1.0, |d| d.sf(statistic));
        // A bound at null makes the test one-sided; a size on the forbidden side explains nothing.
        let there = null + size[0] * unit;
        let (above, below) = (first.least >= null, first.most <= null);
        let p_value = if k > 1 || !(above || below) {
            by_chance
        } else if (above && there < null) || (below && there > null) {
            statistic = 0.0;
            1.0 - 0.5 * by_chance
        } else {
            0.5 * by_chance
        };
        Some(Score {
            mechanism,
            projected,
            unit,
            size,
            information,
            statistic,
            p_value,
            widening,
        })
    }
}

/// Columns of an active mechanism's parameters.
pub fn active_columns(
    rides: &Rides,
    baseline: &Baseline,
    passes: &Passes,
    index: usize,
) -> Vec<Column> {
    let active = &baseline.model.active[index];
    let card = active.mechanism.card();
    (0..active.p.len())
        .map(|i| {
            let param = &card.parameters[i];
            let mut step = 0.25 * param.probe.abs();
            if active.p[i] + step > param.most {
                step = -step;
            }
            let mut model = baseline.model.clone();
            model.active[index].p[i] += step;
            match model.plant() {
                Ok(plant) => passes
                    .column(rides, &baseline.model, &plant)
                    .iter()
                    .map(|x| x / step)
                    .collect(),
                Err(_) => vec![0.0; passes.passes.iter().map(|p| p.error.len()).sum()],
            }
        })
        .collect()
}

/// Which p-values are discoveries.
pub fn discoveries(p_values: &[f64]) -> Vec<bool> {
    let m = p_values.len();
    let mut order: Vec<usize> = (0..m).collect();
    order.sort_by(|a, b| p_values[*a].total_cmp(&p_values[*b]));
    let harmonic: f64 = (1..=m).map(|i| 1.0 / i as f64).sum();
    let level = |rank: usize| THRESHOLDS.false_discovery_rate * rank as f64 / (m as f64 * harmonic);
    let last = (1..=m)
        .rev()
        .find(|rank| p_values[order[rank - 1]] <= level(*rank));
    let mut found = vec![false; m];
    for rank in 0..last.unwrap_or(0) {
        found[order[rank]] = true;
    }
    found
}

/// Correlation of two mechanisms' effects with the nuisances taken out: the largest canonical one.
pub fn correlation(a: &Score, b: &Score) -> f64 {
    let white = |s: &Score| -> Option<Vec<Column>> {
        let k = s.projected.len();
        let mut gram = vec![0.0; k * k];
        for i in 0..k {
            for j in 0..k {
                gram[i * k + j] = dot(&s.projected[i], &s.projected[j]);
            }
        }
        let l = nalgebra::DMatrix::from_row_slice(k, k, &gram)
            .cholesky()?
            .l();
        let inverse = l.try_inverse()?;
        Some(
            (0..k)
                .map(|i| {
                    let mut column = vec![0.0; s.projected[0].len()];
                    for j in 0..k {
                        for (x, y) in column.iter_mut().zip(&s.projected[j]) {
                            *x += inverse[(i, j)] * y;
                        }
                    }
                    column
                })
                .collect(),
        )
    };
    let (Some(p), Some(q)) = (white(a), white(b)) else {
        return 0.0;
    };
    let cross = nalgebra::DMatrix::from_fn(p.len(), q.len(), |i, j| dot(&p[i], &q[j]));
    let singular = cross.svd(false, false).singular_values;
    singular.iter().copied().fold(0.0, f64::max).min(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn few_discoveries_among_uniform_p_values() {
        let uniform: Vec<f64> = (1..=40).map(|i| i as f64 / 41.0).collect();
        assert!(discoveries(&uniform).iter().all(|d| !d));
        let mut one = uniform.clone();
        one[7] = 1e-6;
        let found = discoveries(&one);
        assert!(found[7] && found.iter().filter(|d| **d).count() == 1);
    }
}
