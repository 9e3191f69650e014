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
    for seed in 0..3 {
        let answer = answer(&Effect::default(), seed);
        assert!(answer.causes.is_empty());
    }
}

#[test]
fn friction() {
    let a = answer(
        &Effect {
            friction_nm: 0.4,
            ..Effect::default()
        },
        5,
    );
    assert_eq!(a.causes[0].mechanism, "steer_coulomb_friction");
}

#[test]
fn damping() {
    let a = answer(
        &Effect {
            damping_nms_rad: 0.6,
            ..Effect::default()
        },
        6,
    );
    assert!(a.causes[0].set.contains(&"steer_damping".to_owned()));
}

#[test]
fn others() {
    let e = Effect::default();
    answer(
        &Effect {
            arm_inertia_kg_m2: 0.08,
            ..e
        },
        7,
    );
    answer(
        &Effect {
            torque_gain: 1.2,
            ..e
        },
        8,
    );
    answer(
        &Effect {
            cross_slope_rad: 0.03,
            ..e
        },
        9,
    );
    answer(
        &Effect {
            gyro_rad: 0.06,
            ..e
        },
        10,
    );
    answer(
        &Effect {
            steer_delay_s: 0.03,
            ..e
        },
        11,
    );
    answer(
        &Effect {
            steer_per_roll_cubed_nm: 1000.0,
            ..e
        },
        12,
    );
}
