//! The predictor's sensitivities, and what must not change with what.

use crate::simulated::{Effect, Setting, write};
use twinhub_diagnose::data::{DataFolders, read_ride};
use twinhub_diagnose::engine::{FreeNoise, Levels, Model, Prepared, Ride, sensitivity};
use twinhub_diagnose::study::{Study, Use};
use twinhub_diagnose::{Answer, diagnose};
use twinhub_mechanism::find;

/// On rides without any noise the innovations vanish, so that the gain's change does not matter and
/// whole passes differ by what the sensitivities say.
#[test]
fn sensitivities_equal_differences() {
    let folder = tempfile::tempdir().unwrap();
    let setting = Setting {
        noise: 0.0,
        spread: 0.0,
        ..Setting::default()
    };
    let path = write(folder.path(), &Effect::default(), [1, 0], 12.0, 3, setting);
    let study = Study::read(&path.to_string_lossy(), &[]).unwrap();
    let data = read_ride(&study.rides[0], &DataFolders::new(&study, None)).unwrap();
    let mut free = FreeNoise::default();
    let ride = Ride::new(&data, Use::Fit, &mut free).unwrap().unwrap();
    let model = Model {
        bicycle: study.bicycle.clone().unwrap(),
        active: vec![],
        levels: Levels {
            process: [1.0, 0.2, 1.0],
            sensors: vec![0.01; free.range.len()],
        },
        latent: [None; 2],
    };
    let plant = model.plant().unwrap();
    let prepared = Prepared::new(ride, &plant);
    let (base, _) = prepared.run(&plant, &model, true);
    for (name, p) in [
        ("steer_damping", vec![0.02]),
        ("arm_inertia", vec![0.002]),
        ("steer_coulomb_friction", vec![0.01]),
        ("tyre_relaxation", vec![0.02]),
        ("cornering_stiffness", vec![1e-5]),
        ("twisting_torque", vec![0.1]),
        ("cross_slope", vec![0.001]),
        ("steer_torque_gain", vec![1.01]),
        ("steer_sensor_scale", vec![1.005]),
        ("gyro_misalignment", vec![0.002]),
        ("speed_scale", vec![1.002]),
        ("payload", vec![0.1, 0.2, -0.9]),
    ] {
        let changed = model.with(find(name).unwrap(), p);
        let other = changed.plant().unwrap();
        let said = sensitivity::of_pass(
            &prepared.ride,
            &prepared.course,
            &plant,
            &other,
            &model,
            &base,
        );
        let (pass, course) = prepared.run(&other, &changed, false);
        assert!(
            course.is_none_or(|c| c.readings.len() == said.len()),
            "{name}"
        );
        let (mut off, mut size) = (0.0, 0.0);
        for (k, s) in said.iter().enumerate() {
            let difference = pass.error[k] - base.error[k];
            off += (difference - s) * (difference - s) / base.variance[k];
            size += difference * difference / base.variance[k];
        }
        let ratio = (off / size).sqrt();
        println!("{name:24} {ratio:.4}");
        // A memory is no part of the linear system that the sensitivities follow.
        let most = if name == "tyre_relaxation" { 0.3 } else { 0.1 };
        assert!(size > 0.0 && ratio < most, "{name}: {ratio}");
    }
}

fn run(folder: &std::path::Path) -> Answer {
    let study = Study::read(&folder.join("study.toml").to_string_lossy(), &[]).unwrap();
    diagnose(&study, |_| {}).unwrap()
}

/// A held-out sample changes no fitted parameter and no test; the same rides give the same answer to
/// the last bit.
#[test]
fn held_out_rides_do_not_leak() {
    let folder = tempfile::tempdir().unwrap();
    let effect = Effect {
        damping_nms_rad: 0.8,
        ..Effect::default()
    };
    write(folder.path(), &effect, [2, 1], 20.0, 21, Setting::default());
    let first = run(folder.path());
    let again = run(folder.path());
    assert_eq!(
        serde_json::to_string(&first).unwrap(),
        serde_json::to_string(&again).unwrap()
    );
    let file = folder.path().join("ride_2.csv");
    let text = std::fs::read_to_string(&file).unwrap();
    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
    let mut cells: Vec<String> = lines[900].split(',').map(str::to_owned).collect();
    cells[5] = format!("{}", cells[5].parse::<f64>().unwrap() + 0.01);
    lines[900] = cells.join(",");
    std::fs::write(&file, lines.join("\n")).unwrap();
    let tampered = run(folder.path());
    assert_eq!(first.calibration, tampered.calibration);
    assert_eq!(first.scores, tampered.scores);
    let values = |a: &Answer| {
        a.candidates
            .iter()
            .map(|c| c.fit_gain_nats)
            .collect::<Vec<_>>()
    };
    assert_eq!(values(&first), values(&tampered));
}
