//! Sets as a whole.

use crate::effect::{Effect, LIBRARY, OUTSIDE};
use crate::ride::ride;
use crate::scenario::{Kind, Scenario, band_hz};
use std::collections::BTreeSet;

fn short(mut scenario: Scenario) -> Scenario {
    scenario.layout.duration_s = 12.0;
    scenario
}

#[test]
fn every_effect_can_be_ridden_at_its_usual_size() {
    let mut fell = vec![];
    for effect in LIBRARY.iter().chain(OUTSIDE) {
        let scenario = short(Scenario::of_effect(effect, 1));
        match scenario.ride() {
            Ok(ridden) if ridden.hidden == scenario.hidden => {}
            Ok(ridden) => fell.push(format!("{} but for {}", effect.name, ridden.hidden[0].size)),
            Err(error) => fell.push(format!("{}: {error}", effect.name)),
        }
    }
    assert!(fell.is_empty(), "{fell:#?}");
}

#[test]
fn a_set_repeats_bit_by_bit_and_another_seed_differs() {
    let text = |seed: u64| {
        let folder = tempfile::tempdir().unwrap();
        let sealed = short(Scenario::new(Kind::OneEffect, seed)).seal().unwrap();
        sealed.write(folder.path()).unwrap();
        let ride = std::fs::read(folder.path().join("ride_03.csv.gz")).unwrap();
        (sealed.study, ride)
    };
    assert_eq!(text(4), text(4));
    assert_ne!(text(4).1, text(5).1);
}

#[test]
fn the_study_says_nothing_of_the_answer() {
    for kind in Kind::ALL {
        let sealed = short(Scenario::new(kind, 11)).seal().unwrap();
        let folder = tempfile::tempdir().unwrap();
        sealed.write(&folder.path().join("study")).unwrap();
        let files: BTreeSet<String> = std::fs::read_dir(folder.path().join("study"))
            .unwrap()
            .map(|f| f.unwrap().file_name().to_string_lossy().into_owned())
            .collect();
        assert_eq!(files.len(), 8, "{files:?}");
        assert!(!sealed.study.contains(kind.name()));
        for effect in &sealed.answer.effects {
            assert!(!sealed.study.contains(&effect.mechanism));
        }
        sealed
            .write_answer(&folder.path().join("answer.json"))
            .unwrap();
        let text = std::fs::read_to_string(folder.path().join("answer.json")).unwrap();
        let read: crate::SealedAnswer = serde_json::from_str(&text).unwrap();
        assert_eq!(read, sealed.answer);
    }
}

/// A hidden effect changes what is ridden; the twin without it rides the same courses.
#[test]
fn the_clean_twin_differs_by_the_effect_alone() {
    let effect = Effect::named("steer_damping").unwrap();
    let scenario = short(Scenario::of_effect(effect, 3));
    let (with, without) = (
        scenario.ride().unwrap(),
        scenario.clean_twin().ride().unwrap(),
    );
    assert_eq!(with.courses, without.courses);
    let (a, b) = (&with.tracks[0].moments, &without.tracks[0].moments);
    assert_eq!(a[0].pull_n, b[0].pull_n);
    let apart = a
        .iter()
        .zip(b)
        .map(|(a, b)| (a.steer_rad - b.steer_rad).abs())
        .fold(0.0, f64::max);
    assert!(apart > 0.005, "{apart}");
    // An effect of size zero is no effect.
    let nothing = scenario.sized(&[0.0]).ride().unwrap();
    assert_eq!(nothing.tracks[0].moments[900].roll_rad, b[900].roll_rad);
}

#[test]
fn rides_stay_in_bounds_and_speeds_are_as_planned() {
    let ridden = short(Scenario::new(Kind::Clean, 2)).ride().unwrap();
    for (course, track) in ridden.courses.iter().zip(&ridden.tracks) {
        let mean =
            track.moments.iter().map(|m| m.speed_m_s).sum::<f64>() / track.moments.len() as f64;
        assert!(
            (mean - course.speed_m_s).abs() < 0.5,
            "{mean} {}",
            course.speed_m_s
        );
        let largest = track
            .moments
            .iter()
            .map(|m| m.roll_rad.abs())
            .fold(0.0, f64::max);
        assert!(
            largest > 0.01 && largest < 0.35,
            "{}: {largest}",
            course.name
        );
    }
}

#[test]
fn the_band_of_a_torque_is_where_its_power_lies() {
    let effect = Effect::named("sloshing_tank").unwrap();
    let scenario = short(Scenario::of_effect(effect, 1));
    let ridden = scenario.ride().unwrap();
    let [low, high] = band_hz(&ridden.tracks[0], 0).unwrap();
    assert!(low < 1.3 && high > 0.8 && high < 6.0, "{low} {high}");
    let clean = scenario.clean_twin().ride().unwrap();
    assert_eq!(band_hz(&clean.tracks[0], 0), None);
    let again = ride(&ridden.truths[0], &ridden.courses[0], 1, 2);
    assert!(again.is_ok());
}
