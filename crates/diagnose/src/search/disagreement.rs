//! What: whether all rides are of one bicycle: they have to want the same size of every cause.
//!
//! Equation: with U the score and I the information of a ride about the size, and V the variance of U
//! between its blocks, the sum of U²/max(I, V) is chi² with one degree of freedom less than rides; a ride
//! would move the size by -U/I.
//!
//! Source: score test of homogeneity, C. R. Rao, as in `score`.
//!
//! Assumes and ignores: the size was fitted on all of them together.
//!
//! Valid for: rides of several blocks.
//!
//! Checked by: the tests that hide two bicycles in one study.

use super::greedy::Accepted;
use super::score::{Bench, active_columns};
use super::thresholds::THRESHOLDS;
use statrs::distribution::{ChiSquared, ContinuousCDF};

/// What rides disagree about most, if they do: an accepted cause, or most parameters of the bicycle.
/// Judged when all causes are in, for one that is still missing lets rides disagree about the others.
pub fn disagreement(bench: &Bench<'_>, accepted: &[Accepted]) -> Option<(&'static str, f64)> {
    let count = bench.rides.0.len();
    if count < 2 {
        return None;
    }
    let of = |index: usize| {
        let columns = active_columns(bench.rides, bench.baseline, &bench.passes, index);
        let active = &bench.baseline.model.active[index];
        let null = active
            .mechanism
            .null(&bench.baseline.model.bicycle.parameters);
        let found = Disagreement::new(bench, columns.first()?, count)?;
        // A strong effect shows where the model's own errors differ from ride to ride: that is no other size.
        let is_material = found.spread > THRESHOLDS.agreement_share * (active.p[0] - null[0]).abs();
        is_material.then_some(found.p_value)
    };
    accepted
        .iter()
        .enumerate()
        .filter_map(|(index, cause)| Some((cause.mechanism.card().name, of(index)?)))
        .filter(|(_, p)| *p < THRESHOLDS.agreement_p_value)
        .min_by(|a, b| a.1.total_cmp(&b.1))
        .or_else(|| two_bicycles(bench, count))
}

/// The parameter about which rides disagree most, where they disagree about most parameters: one alone
/// can stand in for what changes from ride to ride, such as a sensor's offset.
fn two_bicycles(bench: &Bench<'_>, count: usize) -> Option<(&'static str, f64)> {
    let baseline = bench.baseline;
    let of = |(index, column): &(usize, Vec<f64>)| {
        let found = Disagreement::new(bench, column, count)?;
        Some((baseline.all[*index].symbol, found.p_value))
    };
    let mut found: Vec<_> = baseline.columns.list.iter().filter_map(of).collect();
    found.sort_by(|a, b| a.1.total_cmp(&b.1));
    let median = found.get(found.len() / 2)?.1;
    (median < THRESHOLDS.one_bicycle_p_value).then(|| found[0])
}

/// How far rides are from wanting the same size of one effect.
struct Disagreement {
    p_value: f64,
    /// Root of the mean square of what rides would move the size by, weighed by what they know of it.
    spread: f64,
}

impl Disagreement {
    /// About the effect in `column`.
    fn new(bench: &Bench<'_>, column: &[f64], count: usize) -> Option<Self> {
        // By ride: score and information. By block: score, and whose it is.
        let mut sums = vec![[0.0; 2]; count];
        let mut blocks = vec![(0.0, 0); bench.blocks];
        for (k, g) in column.iter().enumerate() {
            let ride = bench.ride[k];
            sums[ride][0] += g * bench.residual[k];
            sums[ride][1] += g * g;
            blocks[bench.block[k]].0 += g * bench.residual[k];
            blocks[bench.block[k]].1 = ride;
        }
        // Variance of a ride's score from its blocks, about their mean: a ride that wants another size
        // does not widen its own yardstick.
        let mut spread = vec![0.0; count];
        for (ride, spread) in spread.iter_mut().enumerate() {
            let own: Vec<f64> = blocks.iter().filter(|b| b.1 == ride).map(|b| b.0).collect();
            let n = own.len() as f64;
            if n > 1.0 {
                let mean = own.iter().sum::<f64>() / n;
                *spread = own.iter().map(|u| (u - mean) * (u - mean)).sum::<f64>() * n / (n - 1.0);
            }
        }
        let told: Vec<([f64; 2], f64)> = sums
            .into_iter()
            .zip(spread)
            // A cause that does not act in a ride cannot disagree there.
            .filter(|(s, _)| s[1] > 0.0)
            .collect();
        let statistic: f64 = told.iter().map(|([u, i], v)| u * u / i.max(*v)).sum();
        let moved: f64 = told.iter().map(|([u, i], _)| u * u / i).sum();
        let known: f64 = told.iter().map(|([_, i], _)| i).sum();
        let chance = ChiSquared::new(told.len().saturating_sub(1) as f64).ok()?;
        Some(Self {
            p_value: chance.sf(statistic),
            spread: (moved / known).sqrt(),
        })
    }
}
