//! The metric table: M1 to M12.

use crate::gates;
use crate::interval::{bootstrap_median, median, uniform_p, wilson};
use crate::run::Outcome;
use serde::Serialize;
use std::collections::BTreeMap;
use twinhub_hidden::same_one_way;

/// One row of the table.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Metric {
    pub id: &'static str,
    pub what: &'static str,
    /// None: no set tells.
    pub value: Option<f64>,
    pub ci95: Option<[f64; 2]>,
    /// Sets that it counts.
    pub sets: usize,
    pub pass: String,
    pub moonshot: String,
    /// "pass", "moonshot", "fail", or "no data".
    pub verdict: &'static str,
}

/// A condition and how it reads.
struct Gate {
    met: bool,
    text: String,
}

fn at_most(value: Option<f64>, limit: f64) -> Gate {
    Gate {
        met: value.is_some_and(|v| v <= limit),
        text: format!("<= {limit}"),
    }
}

fn at_least(value: Option<f64>, limit: f64) -> Gate {
    Gate {
        met: value.is_some_and(|v| v >= limit),
        text: format!(">= {limit}"),
    }
}

fn within(value: Option<f64>, [low, high]: [f64; 2]) -> Gate {
    Gate {
        met: value.is_some_and(|v| (low..=high).contains(&v)),
        text: format!("{low} to {high}"),
    }
}

fn metric(
    id: &'static str,
    what: &'static str,
    (value, ci95, sets): (Option<f64>, Option<[f64; 2]>, usize),
    pass: Gate,
    moonshot: Gate,
) -> Metric {
    let verdict = match (value, pass.met, moonshot.met) {
        (None, ..) => "no data",
        (_, true, true) => "moonshot",
        (_, true, false) => "pass",
        (_, false, _) => "fail",
    };
    Metric {
        id,
        what,
        value,
        ci95,
        sets,
        pass: pass.text,
        moonshot: moonshot.text,
        verdict,
    }
}

type Figure = (Option<f64>, Option<[f64; 2]>, usize);

/// Share of `of` for which `hit` holds.
fn share<'a>(of: impl Iterator<Item = &'a Outcome>, hit: impl Fn(&Outcome) -> bool) -> Figure {
    let (hits, count) = of.fold((0, 0), |(h, n), o| (h + usize::from(hit(o)), n + 1));
    let value = (count > 0).then(|| hits as f64 / count as f64);
    (value, value.map(|_| wilson(hits, count)), count)
}

fn middle(values: &[f64]) -> Figure {
    (median(values), bootstrap_median(values), values.len())
}

fn shares(id: &'static str, what: &'static str, figure: Figure, gates: [f64; 2]) -> Metric {
    metric(
        id,
        what,
        figure,
        at_least(figure.0, gates[0]),
        at_least(figure.0, gates[1]),
    )
}

fn rates(id: &'static str, what: &'static str, figure: Figure, gates: [f64; 2]) -> Metric {
    metric(
        id,
        what,
        figure,
        at_most(figure.0, gates[0]),
        at_most(figure.0, gates[1]),
    )
}

/// Whether the single effect of a set is at least `from` times its limit.
fn beyond(outcome: &Outcome, from: f64) -> bool {
    !outcome.multiples.is_empty()
        && outcome
            .multiples
            .iter()
            .all(|m| m.is_some_and(|m| m >= from - 1e-9))
}

/// The table from the outcomes. `seconds` is the time of one diagnosis as declared for M10.
pub fn metrics(outcomes: &[Outcome], seconds: Option<f64>) -> Vec<Metric> {
    let of = |kind: &'static str| outcomes.iter().filter(move |o| o.planned.kind == kind);
    let named = |o: &Outcome| o.found.names_a_cause();
    let detected = |o: &Outcome| o.found.detects();
    let mut table = vec![];

    let false_cause = share(of("clean"), named);
    let upper_met = false_cause
        .1
        .is_some_and(|ci| ci[1] <= gates::FALSE_CAUSE_UPPER);
    let mut pass = at_most(false_cause.0, gates::FALSE_CAUSE[0]);
    pass.met &= upper_met;
    pass.text = format!("{}, upper end <= {}", pass.text, gates::FALSE_CAUSE_UPPER);
    let moonshot = at_most(false_cause.0, gates::FALSE_CAUSE[1]);
    table.push(metric(
        "M1",
        "named cause on clean sets",
        false_cause,
        pass,
        moonshot,
    ));
    let silent = share(of("clean"), detected);
    table.push(rates(
        "M1 silent",
        "any finding on clean sets",
        silent,
        gates::FALSE_CAUSE,
    ));
    let uniform = uniformity(of("clean"));
    table.push(metric(
        "M1 uniform",
        "smallest p of uniform p-values, times mechanisms",
        uniform,
        at_least(uniform.0, gates::UNIFORM_P),
        at_least(uniform.0, gates::UNIFORM_P),
    ));

    let from_two = || of("one_effect").filter(|o| beyond(o, gates::DETECTED_FROM));
    let from_four = || of("one_effect").filter(|o| beyond(o, gates::FIRST_FROM));
    let hidden = |o: &Outcome| o.truth.effects[0].mechanism.clone();
    table.push(shares(
        "M2",
        "detected from twice the limit",
        share(from_two(), detected),
        gates::DETECTED,
    ));
    // Where the hidden one is the same force under another name, either name is right.
    let first = |o: &Outcome| {
        let first = o.found.causes.first();
        first.is_some_and(|c| c.holds(&hidden(o)) && same_one_way(&c.mechanism, &hidden(o)))
    };
    table.push(shares(
        "M3",
        "first cause right from 4 times the limit",
        share(from_four(), first),
        gates::FIRST,
    ));
    let covered = share(from_two().filter(|o| named(o)), |o| {
        o.found.covers(&hidden(o))
    });
    table.push(shares(
        "M4",
        "true cause in the named set",
        covered,
        gates::COVERED,
    ));
    let sizes: Vec<f64> = from_two()
        .filter_map(|o| o.found.causes.iter().find(|c| c.holds(&hidden(o))))
        .map(|c| c.set.len().max(1) as f64)
        .collect();
    table.push(rates(
        "M4 size",
        "median size of the set",
        middle(&sizes),
        gates::SET_SIZE,
    ));
    table.push(shares(
        "M5",
        "confounded pairs resolved",
        share(of("confounded"), resolved),
        gates::RESOLVED,
    ));

    let (errors, hits) = parameters(from_two());
    table.push(rates(
        "M6",
        "median error of the parameter",
        middle(&errors),
        gates::PARAMETER_ERROR,
    ));
    let count = hits.iter().filter(|h| **h).count();
    let coverage = (!hits.is_empty()).then(|| count as f64 / hits.len() as f64);
    let figure = (
        coverage,
        coverage.map(|_| wilson(count, hits.len())),
        hits.len(),
    );
    table.push(metric(
        "M6 interval",
        "truth inside the 95 % interval",
        figure,
        within(coverage, gates::COVERAGE[0]),
        within(coverage, gates::COVERAGE[1]),
    ));
    let ratios: Vec<f64> = from_four()
        .filter_map(|o| Some((o.found.gain_nats(), o.oracle_nats?)))
        .filter(|(_, oracle)| *oracle > 0.0)
        .map(|(gain, oracle)| gain / oracle)
        .collect();
    table.push(shares(
        "M7",
        "held-out gain over the oracle's, median",
        middle(&ratios),
        gates::GAIN_RATIO,
    ));

    let wrong = share(of("outside"), |o| {
        o.found.causes.iter().any(|c| c.confirmed)
    });
    table.push(rates(
        "M8 name",
        "confirmed name outside the library",
        wrong,
        gates::WRONG_NAME,
    ));
    table.push(shares(
        "M8 place",
        "right equation and band",
        share(of("outside"), located),
        gates::LOCATED,
    ));
    let both = share(
        of("two_effects").filter(|o| beyond(o, gates::FIRST_FROM)),
        |o| o.truth.effects.iter().all(|e| o.found.covers(&e.mechanism)),
    );
    table.push(shares("M9", "both of two effects named", both, gates::BOTH));
    let time = (seconds, None, usize::from(seconds.is_some()));
    table.push(rates(
        "M10",
        "seconds for seven rides of 60 s, one core",
        time,
        gates::SECONDS,
    ));
    table.push(rates(
        "M11",
        "named cause, tolerances twice too small",
        share(of("mismatched"), named),
        gates::MISMATCHED,
    ));
    let controls = || of("shifted").chain(of("mixed"));
    table.push(rates(
        "M12 name",
        "named cause, shifted or mixed",
        share(controls(), named),
        gates::CONTROL_CAUSE,
    ));
    let refused = share(controls(), |o| {
        matches!(o.found.verdict.as_str(), "bad_data" | "unknown")
    });
    table.push(shares(
        "M12",
        "bad data or unknown, shifted or mixed",
        refused,
        gates::CONTROL_VERDICT,
    ));
    table
}

/// Answered as a set with the truth in it (or at once by the truth alone), and the rides that part
/// the pair leave the truth alone.
fn resolved(o: &Outcome) -> bool {
    let truth = &o.truth.effects[0].mechanism;
    let other = o.truth.confounded.iter().find(|m| *m != truth);
    let single =
        |r: &crate::Reading| r.covers(truth) && other.is_some_and(|other| !r.covers(other));
    let asked = o
        .found
        .next_experiment
        .as_ref()
        .is_some_and(|n| o.truth.confounded.iter().all(|m| n.separates.contains(m)));
    single(&o.found) || (o.found.covers(truth) && asked && o.separated.as_ref().is_some_and(single))
}

/// Right equation, and a band that overlaps the true one.
fn located(o: &Outcome) -> bool {
    let effect = &o.truth.effects[0];
    o.found.places.iter().any(|p| {
        let band = match (p.band_hz, effect.band_hz) {
            (Some(a), Some(b)) => a[0] <= b[1] && b[0] <= a[1],
            _ => true,
        };
        p.equation == effect.equation && band
    })
}

/// Relative errors of the parameter and whether its interval holds the truth, where the right
/// cause was named first and confirmed.
fn parameters<'a>(of: impl Iterator<Item = &'a Outcome>) -> (Vec<f64>, Vec<bool>) {
    let (mut errors, mut hits) = (vec![], vec![]);
    for o in of {
        let truth = &o.truth.effects[0];
        let estimate = o
            .found
            .causes
            .first()
            .filter(|c| c.confirmed && c.mechanism == truth.mechanism);
        let estimate = estimate
            .zip(truth.parameter.as_ref())
            .and_then(|(c, p)| c.parameters.get(p));
        if let Some(estimate) = estimate {
            errors.push(((estimate.value - truth.value) / truth.size).abs());
            hits.extend(
                estimate
                    .ci95
                    .map(|ci| (ci[0]..=ci[1]).contains(&truth.value)),
            );
        }
    }
    (errors, hits)
}

/// Kolmogorov's test for each mechanism on clean sets; the smallest p-value, times their number.
fn uniformity<'a>(clean: impl Iterator<Item = &'a Outcome>) -> Figure {
    let mut values: BTreeMap<&str, Vec<f64>> = BTreeMap::new();
    let mut sets = 0;
    for o in clean {
        sets += 1;
        for (mechanism, score) in &o.found.scores {
            values.entry(mechanism).or_default().extend(score.p_value);
        }
    }
    // The asymptotic test needs some ten values.
    let tests: Vec<f64> = values
        .values()
        .filter(|v| v.len() >= 10)
        .map(|v| uniform_p(v))
        .collect();
    let least = tests.iter().copied().fold(f64::INFINITY, f64::min);
    let value = (!tests.is_empty()).then(|| (least * tests.len() as f64).min(1.0));
    (value, None, sets)
}

/// Share detected by multiple of the limit: the detection curve.
pub fn detection_curve(outcomes: &[Outcome]) -> Vec<(f64, usize, usize)> {
    let mut bins: BTreeMap<u32, (usize, usize)> = BTreeMap::new();
    for o in outcomes.iter().filter(|o| o.planned.kind == "one_effect") {
        if let Some(Some(multiple)) = o.multiples.first() {
            let bin = bins.entry((multiple * 2.0).round() as u32).or_default();
            bin.0 += usize::from(o.found.detects());
            bin.1 += 1;
        }
    }
    bins.into_iter()
        .map(|(k, (hits, of))| (f64::from(k) / 2.0, hits, of))
        .collect()
}
