//! What: a first look for effects that are so strong that the calibration cannot be trusted.
//!
//! Equation: on an excerpt of each ride, every mechanism is fitted together with the calibration,
//! from the declared values on, with noise levels of its own; what it gains over the calibration
//! alone orders the mechanisms.
//!
//! Source: own. A strong effect drives calibration parameters to the ends of their range; scores
//! taken there point anywhere, while few seconds are enough to see such an effect.
//!
//! Assumes and ignores: the excerpt shows the effect.
//!
//! Valid for: ordering alone; what comes first is fitted on all rides and decided as any other.
//!
//! Checked by: `tests` of the search.

use super::contender::Material;
use super::fitting::{Baseline, moved};
use super::levels::{FIRST_PROCESS, fit_levels};
use super::refit::{polish, refreshed, sketch};
use super::rides::Rides;
use super::score::Bench;
use crate::engine::FreeNoise;
use crate::engine::small::dot;
use twinhub_mechanism::Mechanism;

/// How many mechanisms have their noise levels fitted.
const MOST_LEVELLED: usize = 5;

/// A mechanism, and where its fit may begin. Columns are those of the excerpt.
pub struct Guess {
    pub mechanism: &'static dyn Mechanism,
    pub fit: Baseline,
}

/// Whether the calibration cannot be trusted: taken together, its parameters lie farther from the
/// declared values than chance lets them.
pub fn is_strained(baseline: &Baseline) -> bool {
    const LEAST_Z: f64 = 3.0;
    let count = baseline.columns.list.len() as f64;
    dot(&baseline.z, &baseline.z) > count + LEAST_Z * (2.0 * count).sqrt()
}

/// The mechanisms that explain most, the best first.
pub fn screen(
    material: &Material<'_>,
    baseline: &Baseline,
    library: &[&'static dyn Mechanism],
    progress: &mut dyn FnMut(&str),
) -> Vec<Guess> {
    guesses(material, baseline, library, progress).unwrap_or_default()
}

fn guesses(
    material: &Material<'_>,
    baseline: &Baseline,
    library: &[&'static dyn Mechanism],
    progress: &mut dyn FnMut(&str),
) -> Option<Vec<Guess>> {
    let rides = &material.fit.excerpt(&baseline.model)?;
    let mut declared = baseline.clone();
    declared.z.fill(0.0);
    declared.model = moved(&baseline.model, &baseline.all, &declared.z)?;
    declared.model.levels.process = FIRST_PROCESS;
    let declared = refreshed(rides, declared)?;
    let bench = Bench::new(rides, &declared)?;
    let mut list: Vec<Guess> = vec![];
    for mechanism in library.iter().filter(|m| !m.is_random()) {
        progress(&format!("first look at {}", mechanism.card().name));
        // Without a score the calibration explains all that it could.
        let found = bench
            .score(*mechanism)
            .and_then(|score| sketch(rides, &declared, *mechanism, &score.size))
            .and_then(|fit| polish(rides, fit, 1));
        list.extend(found.map(|fit| Guess {
            mechanism: *mechanism,
            fit,
        }));
    }
    order(&mut list);
    list.truncate(MOST_LEVELLED);
    for guess in &mut list {
        level(rides, material.free, &mut guess.fit);
    }
    order(&mut list);
    Some(list)
}

fn order(list: &mut [Guess]) {
    list.sort_by(|a, b| a.fit.cost.total_cmp(&b.fit.cost));
}

fn level(rides: &Rides, free: &FreeNoise, fit: &mut Baseline) {
    fit.model = fit_levels(rides, free, &fit.model, 3);
    if let Some(better) = polish(rides, fit.clone(), 1) {
        *fit = better;
    }
}
