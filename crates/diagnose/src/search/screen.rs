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
use super::fitting::{Baseline, FIRST_PROCESS, Rides, fit_levels, moved};
use super::refit::{polish, refreshed, sketch};
use super::score::Bench;
use super::thresholds::THRESHOLDS;
use crate::engine::{FreeNoise, Prepared};
use twinhub_mechanism::Mechanism;

/// Longest excerpt of a ride.
const EXCERPT_S: f64 = 8.0;
/// How many mechanisms have their noise levels fitted.
const MOST_LEVELLED: usize = 8;

/// A mechanism, and where its fit may begin. Columns are those of the excerpt.
pub struct Guess {
    pub mechanism: &'static dyn Mechanism,
    pub fit: Baseline,
}

/// Whether the calibration cannot be trusted: parameters lie at the ends of their range, one while
/// tests find something, or several in any case.
pub fn is_strained(baseline: &Baseline, is_something_found: bool) -> bool {
    let most = THRESHOLDS.calibration_box_sd - 1e-3;
    let at_end = baseline.z.iter().filter(|z| z.abs() > most).count();
    at_end >= 3 || at_end > 0 && is_something_found
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
    let rides = &excerpt(material.fit, &baseline.model)?;
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

/// The middle of the longest window of each ride.
fn excerpt(rides: &Rides, model: &crate::engine::Model) -> Option<Rides> {
    let plant = model.plant().ok()?;
    let cut = |prepared: &Prepared| {
        let mut ride = prepared.ride.clone();
        let longest = ride
            .windows
            .iter()
            .copied()
            .max_by(|a, b| (a[1] - a[0]).total_cmp(&(b[1] - b[0])))?;
        let middle = 0.5 * (longest[0] + longest[1]);
        ride.windows = vec![[
            longest[0].max(middle - 0.5 * EXCERPT_S),
            longest[1].min(middle + 0.5 * EXCERPT_S),
        ]];
        for sensor in &mut ride.sensors {
            let [from, to] = ride.windows[0];
            sensor.samples.retain(|(t, _)| *t >= from && *t < to);
        }
        Some(Prepared::new(ride, &plant))
    };
    let rides: Vec<Prepared> = rides.0.iter().filter_map(cut).collect();
    let empty = rides.iter().all(|r| r.course.readings.is_empty());
    (!empty).then_some(Rides(rides))
}
