//! The search itself: test, refit, decide, accept, again.

use super::contender::{
    Contender, Material, Sketch, Tested, confusion, has_evidence, held_blocks, is_at_end,
    is_decided, is_degenerate, is_within_clock, pick,
};
use super::decide::Gain;
use super::disagreement::disagreement;
use super::fitting::Baseline;
use super::probe::{PROBES, Probe};
use super::refit::{Refit, finish, refreshed, settle};
use super::score::{Bench, Score, discoveries};
use super::screen::{is_strained, screen};
use super::thresholds::THRESHOLDS;
use super::tolerance;
use twinhub_mechanism::{Equation, Mechanism};

/// An accepted cause.
pub struct Accepted {
    pub mechanism: &'static dyn Mechanism,
    pub set: Vec<&'static str>,
    pub gain: Gain,
    pub decided: bool,
}

/// What the search leaves.
pub struct Found {
    pub baseline: Baseline,
    pub refit: Option<Refit>,
    pub accepted: Vec<Accepted>,
    pub first: Vec<Tested>,
    pub contenders: Vec<(String, f64, Gain)>,
    /// Mechanisms whose fit ended at an end of their range: refused.
    pub at_end: Vec<&'static str>,
    /// Delays that were refused because the clocks cannot tell them.
    pub within_clock: Vec<&'static str>,
    /// Probes that still explain something at the end, the strongest first.
    pub left: Vec<Left>,
    /// What rides disagree about, with the p-value: an accepted cause, or without causes a parameter.
    pub disagreement: Option<(&'static str, f64)>,
}

/// A probe that explains part of the residual.
pub struct Left {
    pub probe: &'static Probe,
    pub p_value: f64,
    pub gain: Gain,
}

/// One round's tests.
fn test(bench: &Bench<'_>, library: &[&'static dyn Mechanism]) -> Vec<Tested> {
    library
        .iter()
        .map(|m| Tested {
            mechanism: *m,
            score: bench.score(*m),
        })
        .collect()
}

/// Those that the tests bring up, the strongest first.
fn discovered(tested: &[Tested]) -> Vec<&Score> {
    let p: Vec<f64> = tested
        .iter()
        .map(|t| t.score.as_ref().map_or(1.0, |s| s.p_value))
        .collect();
    let mut found: Vec<&Score> = tested
        .iter()
        .zip(discoveries(&p))
        .filter(|(_, d)| *d)
        .filter_map(|(t, _)| t.score.as_ref())
        .collect();
    found.sort_by(|a, b| b.statistic.total_cmp(&a.statistic));
    found
}

/// Those that are fitted: parameters out of tolerance have places of their own, so that they take none
/// from mechanisms.
fn strongest(tested: &[Tested]) -> Vec<&Score> {
    let (parameters, mechanisms): (Vec<_>, Vec<_>) = discovered(tested)
        .into_iter()
        .partition(|s| tolerance::is_candidate(s.mechanism));
    mechanisms
        .into_iter()
        .take(THRESHOLDS.refits)
        .chain(parameters.into_iter().take(THRESHOLDS.tolerance_refits))
        .collect()
}

/// Runs the search.
pub fn search(
    material: &Material<'_>,
    start: Baseline,
    library: &[&'static dyn Mechanism],
    progress: &mut dyn FnMut(&str),
) -> Option<Found> {
    let decide = !material.held.0.is_empty();
    let clock_s = material.clock_s();
    let mut baseline = start;
    let mut accepted: Vec<Accepted> = vec![];
    let mut first = None;
    let mut contenders = vec![];
    let mut at_end = vec![];
    let mut within_clock = vec![];
    let mut last: Option<Refit> = None;
    for round in 0..=THRESHOLDS.most_causes {
        progress(&format!("tests, round {}", round + 1));
        let left: Vec<&'static dyn Mechanism> = library
            .iter()
            .copied()
            .filter(|m| {
                let name = m.card().name;
                accepted.iter().all(|a| a.mechanism.card().name != name)
                    && (!tolerance::is_candidate(*m) || tolerance::is_at_end(*m, &baseline))
            })
            .collect();
        let bench = Bench::new(material.fit, &baseline)?;
        let tested = test(&bench, &left);
        let blocks = bench.blocks;
        if round < THRESHOLDS.most_causes {
            let before = held_blocks(material.held, &baseline);
            let least = if accepted.is_empty() {
                0.0
            } else {
                THRESHOLDS.later_nats
            };
            let fits = |c: &Contender| {
                !is_degenerate(c)
                    && !is_within_clock(c, clock_s)
                    && has_evidence(c, blocks, library.len())
                    && (!decide || is_decided(c) && c.gain.nats > least)
            };
            let mut sketches: Vec<Sketch> = strongest(&tested)
                .into_iter()
                .filter_map(|score| {
                    progress(&format!("first steps of {}", score.mechanism.card().name));
                    Sketch::new(material, &baseline, score)
                })
                .collect();
            let random = left.iter().copied().filter(|m| m.is_random());
            sketches.extend(random.filter_map(|m| Sketch::random(material, &baseline, m)));
            if is_strained(&baseline) {
                let guesses = screen(material, &baseline, &left, progress);
                for guess in guesses.into_iter().take(THRESHOLDS.screened) {
                    progress(&format!("first steps of {}", guess.mechanism.card().name));
                    let Some(sketch) = Sketch::of_guess(material, &baseline, guess) else {
                        continue;
                    };
                    match sketches.iter_mut().find(|s| s.name() == sketch.name()) {
                        Some(known) if known.nats < sketch.nats => *known = sketch,
                        Some(_) => {}
                        None => sketches.push(sketch),
                    }
                }
            }
            sketches.sort_by(|a, b| b.nats.total_cmp(&a.nats));
            let worth = THRESHOLDS.sketch_share * sketches.first().map_or(0.0, |s| s.nats);
            let mut list: Vec<Contender> = vec![];
            for sketch in sketches {
                // What began far behind is fitted only if nothing ahead of it may be accepted.
                if sketch.nats < worth && pick(&list, fits).is_some() {
                    break;
                }
                progress(&format!("fitting {}", sketch.name()));
                list.extend(sketch.contend(material, &baseline, before.as_ref()));
                list.sort_by(|a, b| b.total().total_cmp(&a.total()));
            }
            for c in &list {
                let name = c.mechanism.card().name;
                contenders.push((name.to_owned(), c.fit_nats, c.gain));
                if is_at_end(c) && !at_end.contains(&name) {
                    at_end.push(name);
                }
                if is_within_clock(c, clock_s) && !within_clock.contains(&name) {
                    within_clock.push(name);
                }
            }
            if let Some(best) = pick(&list, fits) {
                let set = confusion(&list, best, &tested);
                let chosen = list.swap_remove(best);
                accepted.push(Accepted {
                    mechanism: chosen.mechanism,
                    set,
                    gain: chosen.gain,
                    decided: decide,
                });
                baseline = refreshed(material.fit, chosen.refit.baseline.clone())?;
                last = Some(chosen.refit);
                if first.is_none() {
                    first = Some(tested);
                }
                continue;
            }
        }
        if first.is_none() {
            first = Some(tested);
        }
        break;
    }
    if accepted.len() > 1 {
        progress("joint fit");
        baseline = settle(material.fit, material.free, baseline)?;
        baseline = eliminate(material, baseline, &mut accepted, decide)?;
        baseline = refreshed(material.fit, baseline)?;
        last = finish(material.fit, baseline.clone());
    }
    progress("what is left");
    let bench = Bench::new(material.fit, &baseline)?;
    let disagreement = disagreement(&bench, &accepted);
    let left = leftovers(material, &bench, &accepted, decide);
    Some(Found {
        refit: last,
        accepted,
        first: first.unwrap_or_default(),
        contenders,
        at_end,
        within_clock,
        left,
        disagreement,
        baseline,
    })
}

/// Largest gain of the causes but one.
fn most_nats(accepted: &[Accepted], but: usize) -> f64 {
    let others = accepted.iter().enumerate().filter(|(i, _)| *i != but);
    others.map(|(_, a)| a.gain.nats).fold(0.0, f64::max)
}

/// Drops causes that cost nothing to drop.
fn eliminate(
    material: &Material<'_>,
    mut baseline: Baseline,
    accepted: &mut Vec<Accepted>,
    decide: bool,
) -> Option<Baseline> {
    let mut index = 0;
    while accepted.len() > 1 && index < accepted.len() {
        let mut without = baseline.clone();
        without.model.active.remove(index);
        // With levels of its own, as every model that is compared.
        let without = settle(material.fit, material.free, without)?;
        let loss = match (
            held_blocks(material.held, &without),
            held_blocks(material.held, &baseline),
        ) {
            (Some(a), Some(b)) if decide => {
                let gain = Gain::new(&a, &b);
                accepted[index].gain = gain;
                gain.nats
            }
            _ => without.cost - baseline.cost,
        };
        let most = most_nats(accepted, index);
        let least = if loss < most {
            THRESHOLDS.later_nats.max(THRESHOLDS.least_share * most)
        } else {
            THRESHOLDS.elimination_nats
        };
        if loss < least {
            accepted.remove(index);
            baseline = without;
        } else {
            index += 1;
        }
    }
    Some(baseline)
}

/// Probes that still explain something.
fn leftovers(
    material: &Material<'_>,
    bench: &Bench<'_>,
    accepted: &[Accepted],
    decide: bool,
) -> Vec<Left> {
    let baseline = bench.baseline;
    let longitudinal = material.fit.0.iter().any(|r| r.ride.speed.is_none());
    let mut scores: Vec<(&'static Probe, Score)> = PROBES
        .iter()
        .filter(|p| longitudinal || p.equation != Equation::Longitudinal)
        .filter_map(|p| Some((*p, bench.score(*p)?)))
        .filter(|(_, s)| s.p_value < THRESHOLDS.clean_p_value)
        .collect();
    scores.sort_by(|a, b| b.1.statistic.total_cmp(&a.1.statistic));
    let before = held_blocks(material.held, baseline);
    let mut left = vec![];
    let mut tried: Vec<(Equation, usize)> = vec![];
    for (probe, score) in scores {
        let count = tried.iter().filter(|t| t.0 == probe.equation).count();
        if count >= 2 {
            continue;
        }
        tried.push((probe.equation, count));
        let Some(sketch) = Sketch::new(material, baseline, &score) else {
            continue;
        };
        let gain = sketch.gain(material, before.as_ref());
        let least = THRESHOLDS.least_share * most_nats(accepted, usize::MAX);
        if !decide || (gain.is_decisive() && gain.nats > least) {
            left.push(Left {
                probe,
                p_value: score.p_value,
                gain,
            });
        }
    }
    left.sort_by(|a, b| b.gain.nats.total_cmp(&a.gain.nats));
    left
}
