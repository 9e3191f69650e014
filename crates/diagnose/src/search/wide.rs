//! What: whether tolerances that were declared too small explain as much as the causes found.
//!
//! Equation: the calibration with every declared standard deviation doubled and no cause, against the
//! causes with the calibration as declared. Evidence on the fit rides: cost, prior included, plus half
//! the logarithm of what doubling does to the volume of the prior, ½ Σ ln((1 + 4 λ) / (1 + λ)) with the
//! eigenvalues λ of the information in declared standard deviations; causes pay for their parameters and
//! for the size of the library. On held-out rides: paired blocks.
//!
//! Source: MacKay (1992), Bayesian interpolation, Neural Computation 4, for the volume.
//!
//! Assumes and ignores: all tolerances are too small by the same factor.
//!
//! Valid for: a choice between two whole explanations; single parameters far out are candidates of the
//! search.
//!
//! Checked by: `tests` of the search, sealed sets with twofold spread.

use super::contender::{Material, held_blocks, penalty};
use super::decide::Gain;
use super::fitting::{Baseline, Calibrated, is_at_end};
use super::greedy::{Accepted, Found};
use super::limits::duration_s;
use super::refit::{refreshed, settle};
use super::screen::is_strained;
use super::thresholds::THRESHOLDS;
use super::tolerance;
use nalgebra::DMatrix;

/// How many times wider than declared.
pub const FACTOR: f64 = 2.0;

/// Half the logarithm of what widening costs.
fn volume_nats(baseline: &Baseline) -> f64 {
    let columns = &baseline.columns;
    let m = columns.list.len();
    let products = DMatrix::from_fn(m, m, |i, j| columns.product(i, j));
    // Columns are those of the widened deviations already.
    let eigenvalues = products.symmetric_eigenvalues();
    let wide = eigenvalues.iter().map(|l| l.max(0.0));
    0.5 * wide
        .map(|l| libm::log((1.0 + l) / (1.0 + l / (FACTOR * FACTOR))))
        .sum::<f64>()
}

/// The calibration with doubled tolerances where it explains what the causes do, or more. `declared` is
/// the calibration before any cause, `library` the number of names.
pub fn rival(
    material: &Material<'_>,
    declared: &Baseline,
    found: &Found,
    library: usize,
    progress: &mut dyn FnMut(&str),
) -> Option<Baseline> {
    let is_mechanism = |a: &Accepted| !tolerance::is_candidate(a.mechanism);
    let is_pulled = is_strained(declared) || declared.z.iter().any(|z| is_at_end(*z));
    if !is_pulled || !found.accepted.iter().any(is_mechanism) {
        return None;
    }
    progress("tolerances twice as wide");
    let wider = |c: &Calibrated| Calibrated {
        sd: FACTOR * c.sd,
        ..*c
    };
    // From the calibration as it is, with the noise levels that the causes leave.
    let mut start = Baseline {
        all: declared.all.iter().map(wider).collect(),
        z: declared.z.iter().map(|z| z / FACTOR).collect(),
        ..declared.clone()
    };
    start.model.levels = found.baseline.model.levels.clone();
    let start = refreshed(material.fit, start)?;
    let wide = settle(material.fit, material.free, start)?;
    let blocks = libm::ceil(duration_s(material.fit) / THRESHOLDS.block_s) as usize;
    let causes: f64 = (found.accepted.iter())
        .map(|a| penalty(a.mechanism, blocks, library))
        .sum();
    let ahead = wide.cost + volume_nats(&wide) - (found.baseline.cost + causes);
    let t = &*THRESHOLDS;
    if ahead > 2.0 * t.set_nats {
        return None;
    }
    if let (Some(a), Some(b)) = (
        held_blocks(material.held, &wide),
        held_blocks(material.held, &found.baseline),
    ) {
        let lost = Gain::new(&a, &b);
        if lost.z >= t.set_z && lost.nats >= t.set_nats {
            return None;
        }
    }
    Some(wide)
}
