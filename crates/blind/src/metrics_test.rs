//! Scoring, with diagnoses made up for the purpose.

use crate::engine::{Ask, Engine};
use crate::metrics::{Metric, metrics};
use crate::plan::{Planned, plan};
use crate::reading::{Cause, Estimate, Reading};
use crate::run::{Outcome, run_scenario};
use crate::suite::suite;
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};
use twinhub_hidden::{Effect, HiddenEffect, Kind, Scenario, SealedAnswer};

fn truth(kind: &str, mechanisms: &[&str]) -> SealedAnswer {
    let effect = |name: &&str| HiddenEffect {
        mechanism: (*name).to_owned(),
        in_library: true,
        parameter: Some("p".to_owned()),
        value: 1.0,
        size: 1.0,
        equation: "steer".to_owned(),
        band_hz: Some([0.5, 2.0]),
    };
    SealedAnswer {
        schema_version: 1,
        kind: kind.to_owned(),
        seed: 1,
        effects: mechanisms.iter().map(effect).collect(),
        confounded: vec![],
        spread_ratio: 0.02,
        declared_ratio: 0.02,
    }
}

fn outcome(kind: &str, mechanisms: &[&str], multiple: f64, found: Reading) -> Outcome {
    Outcome {
        planned: Planned {
            kind: kind.to_owned(),
            seed: 1,
            multiples: vec![multiple; mechanisms.len()],
            oracle: true,
        },
        truth: truth(kind, mechanisms),
        multiples: vec![Some(multiple); mechanisms.len()],
        found,
        separated: None,
        oracle_nats: Some(20.0),
        seconds: 1.0,
    }
}

fn says(verdict: &str, causes: &[(&str, &[&str], f64)]) -> Reading {
    let cause = |(name, set, value): &(&str, &[&str], f64)| Cause {
        mechanism: (*name).to_owned(),
        confirmed: true,
        parameters: [(
            "p".to_owned(),
            Estimate {
                value: *value,
                ci95: Some([value - 0.1, value + 0.1]),
            },
        )]
        .into(),
        set: set.iter().map(|s| (*s).to_owned()).collect(),
        held_out_gain_nats: Some(18.0),
    };
    Reading {
        verdict: verdict.to_owned(),
        causes: causes.iter().map(cause).collect(),
        ..Reading::default()
    }
}

fn row(outcomes: &[Outcome], id: &str) -> Metric {
    metrics(outcomes, Some(3.0))
        .into_iter()
        .find(|m| m.id == id)
        .unwrap()
}

#[test]
fn a_false_cause_on_clean_data_counts_and_few_sets_do_not_pass() {
    let silent = || outcome("clean", &[], 0.0, says("no_effect", &[]));
    let mut outcomes: Vec<Outcome> = (0..99).map(|_| silent()).collect();
    assert_eq!(row(&outcomes, "M1").verdict, "moonshot");
    // Ten silent sets say too little: the interval reaches 28 %.
    assert_eq!(row(&outcomes[..10], "M1").verdict, "fail");
    outcomes.push(outcome(
        "clean",
        &[],
        0.0,
        says("cause", &[("a", &["a"], 1.0)]),
    ));
    let found = row(&outcomes, "M1");
    assert_eq!(found.value, Some(0.01));
    // 1 of 100: Wilson reaches 5.4 %.
    assert_eq!(found.verdict, "fail");
    outcomes.push(outcome("clean", &[], 0.0, says("unknown", &[])));
    assert_eq!(row(&outcomes, "M1").value, Some(1.0 / 101.0));
    assert_eq!(row(&outcomes, "M1 silent").value, Some(2.0 / 101.0));
}

#[test]
fn names_sets_and_parameters_are_scored_from_their_limits() {
    let outcomes = [
        outcome("one_effect", &["a"], 1.0, says("no_effect", &[])),
        outcome("one_effect", &["a"], 2.0, says("no_effect", &[])),
        outcome(
            "one_effect",
            &["a"],
            4.0,
            says("cause", &[("a", &["a", "b"], 1.05)]),
        ),
        outcome(
            "one_effect",
            &["a"],
            8.0,
            says("causes", &[("b", &["b", "a"], 1.0)]),
        ),
        outcome(
            "one_effect",
            &["a"],
            6.0,
            says("cause", &[("c", &["c"], 1.0)]),
        ),
    ];
    assert_eq!(row(&outcomes, "M2").value, Some(0.75));
    assert_eq!(row(&outcomes, "M3").value, Some(1.0 / 3.0));
    assert_eq!(row(&outcomes, "M4").value, Some(2.0 / 3.0));
    assert_eq!(row(&outcomes, "M4 size").value, Some(2.0));
    assert!((row(&outcomes, "M6").value.unwrap() - 0.05).abs() < 1e-12);
    assert_eq!(row(&outcomes, "M6 interval").value, Some(1.0));
    assert_eq!(row(&outcomes, "M7").value, Some(0.9));
    assert_eq!(row(&outcomes, "M9").verdict, "no data");
    assert_eq!(row(&outcomes, "M10").verdict, "pass");
}

#[test]
fn outside_the_library_a_name_is_wrong_and_the_place_counts() {
    let place = |equation: &str, band: [f64; 2]| {
        let mut found = says("unknown", &[]);
        found.places = vec![crate::reading::Located {
            order: None,
            equation: equation.to_owned(),
            band_hz: Some(band),
        }];
        found
    };
    let outcomes = [
        outcome("outside", &["x"], 1.0, place("steer", [1.0, 3.0])),
        outcome("outside", &["x"], 1.0, place("steer", [3.0, 9.0])),
        outcome("outside", &["x"], 1.0, place("roll", [1.0, 3.0])),
        outcome("outside", &["x"], 1.0, says("cause", &[("a", &["a"], 1.0)])),
    ];
    assert_eq!(row(&outcomes, "M8 name").value, Some(0.25));
    assert_eq!(row(&outcomes, "M8 place").value, Some(0.25));
}

#[test]
fn a_pair_is_resolved_by_the_rides_that_part_it() {
    let mut open = outcome(
        "confounded",
        &["a"],
        5.0,
        says("causes", &[("b", &["a", "b"], 1.0)]),
    );
    open.truth.confounded = vec!["a".to_owned(), "b".to_owned()];
    open.separated = Some(says("cause", &[("a", &["a"], 1.0)]));
    assert_eq!(
        row(&[open.clone()], "M5").value,
        Some(0.0),
        "no experiment proposed"
    );
    open.found.next_experiment = Some(crate::reading::NextExperiment {
        what: "the other way".to_owned(),
        separates: vec!["b".to_owned(), "a".to_owned()],
    });
    assert_eq!(row(&[open.clone()], "M5").value, Some(1.0));
    open.separated = Some(says("cause", &[("b", &["b"], 1.0)]));
    assert_eq!(
        row(&[open.clone()], "M5").value,
        Some(0.0),
        "resolved to the wrong one"
    );
}

#[test]
fn controls_must_not_be_named() {
    let outcomes = [
        outcome("shifted", &[], 0.0, says("bad_data", &[])),
        outcome("mixed", &[], 0.0, says("unknown", &[])),
        outcome("mixed", &[], 0.0, says("cause", &[("a", &["a"], 1.0)])),
        outcome("mixed", &[], 0.0, says("no_effect", &[])),
    ];
    assert_eq!(row(&outcomes, "M12 name").value, Some(0.25));
    assert_eq!(row(&outcomes, "M12").value, Some(0.5));
}

#[test]
fn p_values_that_pile_up_are_seen() {
    let clean = |p: f64| {
        let mut found = says("no_effect", &[]);
        found.scores = [("a".to_owned(), crate::reading::Score { p_value: Some(p) })].into();
        outcome("clean", &[], 0.0, found)
    };
    let even: Vec<Outcome> = (0..40)
        .map(|k| clean((f64::from(k) + 0.5) / 40.0))
        .collect();
    assert_eq!(row(&even, "M1 uniform").verdict, "moonshot");
    let piled: Vec<Outcome> = (0..40)
        .map(|k| clean((f64::from(k) + 0.5) / 400.0))
        .collect();
    assert_eq!(row(&piled, "M1 uniform").verdict, "fail");
}

/// Reads the sizes off the file's rides: none; it only tells what it was asked.
struct Recorder(AtomicUsize);

impl Engine for Recorder {
    fn diagnose(&self, study: &Path, ask: &Ask) -> Result<Reading, String> {
        self.0.fetch_add(1, Ordering::Relaxed);
        assert!(study.is_file() && study.with_file_name("ride_07.csv.gz").is_file());
        let mut found = says("cause", &[("steer_damping", &["steer_damping"], 1.0)]);
        found.causes[0].held_out_gain_nats = Some(if ask.only.is_empty() { 9.0 } else { 10.0 });
        found.detection_limits = [(
            "steer_damping".to_owned(),
            [("nms_rad".to_owned(), 0.2)].into(),
        )]
        .into();
        Ok(found)
    }
}

#[test]
fn a_set_is_sized_by_the_printed_limit() {
    let effect = Effect::named("steer_damping").unwrap();
    let mut scenario = Scenario::of_effect(effect, 1);
    scenario.layout.duration_s = 5.0;
    let planned = Planned {
        kind: "one_effect".to_owned(),
        seed: 1,
        multiples: vec![4.0],
        oracle: true,
    };
    let engine = Recorder(AtomicUsize::new(0));
    let found = run_scenario(&engine, &planned, &scenario).unwrap();
    assert!((found.truth.effects[0].size - 0.8).abs() < 1e-12);
    assert!((found.multiples[0].unwrap() - 4.0).abs() < 1e-12);
    assert_eq!(found.oracle_nats, Some(10.0));
    // Limits of the clean twin, the set itself, the oracle.
    assert_eq!(engine.0.load(Ordering::Relaxed), 3);
}

#[test]
fn a_suite_takes_up_where_it_stopped() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("outcomes.jsonl");
    let engine = Recorder(AtomicUsize::new(0));
    let sets = plan(1, 5, &[Kind::Mismatched]);
    let first = suite(&engine, &sets, Some(&file), &|_, _| {}).unwrap();
    let asked = engine.0.load(Ordering::Relaxed);
    let again = suite(&engine, &sets, Some(&file), &|_, _| {}).unwrap();
    assert_eq!(engine.0.load(Ordering::Relaxed), asked);
    let unwrap = |o: Vec<Result<Outcome, _>>| o.into_iter().map(Result::unwrap).collect::<Vec<_>>();
    assert_eq!(unwrap(first), unwrap(again));
    std::fs::write(&file, "0123456789abcdef\n").unwrap();
    assert!(suite(&engine, &sets, Some(&file), &|_, _| {}).is_err());
}
