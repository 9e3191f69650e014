//! The search on simulated rides.

mod engine;
mod simulated;

use simulated::{Effect, Setting, write};
use twinhub_diagnose::study::Study;
use twinhub_diagnose::{Answer, diagnose};

fn answer(effect: &Effect, seed: u64) -> Answer {
    let folder = tempfile::tempdir().unwrap();
    let path = write(
        folder.path(),
        effect,
        [3, 2],
        30.0,
        seed,
        Setting::default(),
    );
    let study = Study::read(&path.to_string_lossy(), &[]).unwrap();
    let answer = diagnose(&study, |_| {}).unwrap();
    println!("{effect:?}");
    for s in &answer.statements {
        println!("   {s}");
    }
    for c in &answer.candidates {
        println!(
            "   candidate {} fit {:.1} held {:?}",
            c.mechanism, c.fit_gain_nats, c.held_out_gain_nats
        );
    }
    answer
}

#[test]
fn clean_is_silent() {
    for seed in 0..2 {
        let answer = answer(&Effect::default(), seed);
        assert!(answer.causes.is_empty());
    }
}

/// The right name first. The size comes out low (0.28 of 0.4 Nm): friction that changes its sign
/// within a sampling step is smeared by the predictor.
#[test]
fn friction() {
    let effect = Effect {
        friction_nm: 0.4,
        ..Effect::default()
    };
    let answer = answer(&effect, 5);
    assert_eq!(answer.causes[0].mechanism, "steer_coulomb_friction");
    assert!(answer.causes[0].held_out_gain_nats.unwrap() > 6.0);
}
