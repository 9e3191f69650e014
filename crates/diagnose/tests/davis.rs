//! Measured rides: what the model makes of the Davis instrumented bicycle, and effects planted in rides.
//! Skipped, loudly, where the data is absent.

use std::path::PathBuf;
use twinhub_diagnose::compare::{Comparison, compare};
use twinhub_diagnose::data::{DataFolders, read_ride};
use twinhub_diagnose::study::Study;
use twinhub_diagnose::{Answer, Options, Verdict, diagnose_in};

fn data() -> Option<PathBuf> {
    let folder = std::env::var_os("TWINHUB_DATA").map(PathBuf::from);
    let folder = folder.unwrap_or_else(|| {
        PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data"))
    });
    let found = folder
        .join("davis_instrumented_105/run105_0-40s.csv.gz")
        .is_file();
    if !found {
        println!(
            "SKIPPED: no davis_instrumented_105 in {}; set TWINHUB_DATA",
            folder.display()
        );
    }
    found.then_some(folder)
}

fn run(overrides: &[&str]) -> Option<Comparison> {
    let folder = data()?;
    let overrides: Vec<String> = overrides.iter().map(|s| (*s).to_owned()).collect();
    let study = Study::read("davis_instrumented_105", &overrides).unwrap();
    let folders = DataFolders::new(&study, Some(&folder));
    let rides: Vec<_> = study
        .rides
        .iter()
        .map(|r| read_ride(r, &folders).unwrap())
        .collect();
    Some(compare(&study, &rides, |_| {}).unwrap())
}

fn rmse(found: &Comparison, channel: &str) -> f64 {
    found.channels[channel].rmse.unwrap()
}

/// What the benchmark model makes of the ride. Figures found, in brackets what they must stay in:
/// over 0.5 s VAF of steer 0.83, yaw rate 0.88, roll rate -0.32, roll -0.15.
#[test]
fn davis_ride_as_measured() {
    let Some(found) = run(&[]) else { return };
    for statement in &found.statements {
        println!("{statement}");
    }
    assert!(found.noise.converged);
    assert!(
        (found.noise.consistency - 1.0).abs() < 0.05,
        "{}",
        found.noise.consistency
    );
    for (name, vaf) in [
        ("steer_rad", 0.7..0.95),
        ("yaw_rate_rad_s", 0.7..0.95),
        ("roll_rate_rad_s", -1.0..0.2),
        ("roll_rad", -1.0..0.2),
    ] {
        let channel = &found.channels[name];
        assert!(
            vaf.contains(&channel.vaf.unwrap()),
            "{name}: {:?}",
            channel.vaf
        );
        assert!(
            channel.change_correlation.unwrap() > 0.5,
            "{name}: {:?}",
            channel.change_correlation
        );
        let short = channel.horizons["0.1"].clone().unwrap();
        assert!(
            short.vaf.unwrap() > 0.9 && short.rmse < short.held_rmse.unwrap(),
            "{name}: {short:?}"
        );
    }
    // Unstable weave: e-fold in less than half a second, so that a free run over 2 s says nothing.
    assert!(
        (1.5..3.5).contains(&found.growth_rate_1_s),
        "{}",
        found.growth_rate_1_s
    );
    assert!(
        found.channels["steer_rad"].horizons["2"]
            .clone()
            .unwrap()
            .vaf
            .unwrap()
            < -1.0
    );
    // The pulls begin at 8.6, 15.3, 22.7, 28.3 and 34.9 s; the worst two seconds hold one of them.
    let worst = found.worst.unwrap();
    assert!((worst.end_s - worst.start_s - 2.0).abs() < 1e-9);
    assert!(
        [8.6, 15.3, 22.7, 28.3, 34.9]
            .iter()
            .any(|t| (worst.start_s..worst.end_s).contains(t)),
        "{worst:?}"
    );
    let longest = found.traces[0].channels[0].free_run.last().unwrap()[0]
        - found.traces[0].channels[0].free_run[0][0];
    assert!(longest < 3.0 / found.growth_rate_1_s + 0.01, "{longest}");
    // The speed's spikes are seen, 1.37 m/s at 15.31 s the largest.
    assert!(
        found
            .findings
            .iter()
            .any(|f| f.column == "forward_speed_mps" && f.text.contains("15.310 s")),
        "{:?}",
        found.findings
    );
    for relation in &found.relations {
        assert!(
            relation.r > 0.9 && (0.9..1.1).contains(&relation.slope),
            "{relation:?}"
        );
    }
}

/// Each input must help with its sign, and harm with the other: else the ride's axes are not those
/// of the model.
#[test]
fn davis_signs_by_physics() {
    for (input, channels) in [
        (1, &["roll_rad", "roll_rate_rad_s"][..]),
        (
            2,
            &["roll_rad", "roll_rate_rad_s", "steer_rad", "yaw_rate_rad_s"],
        ),
    ] {
        let scaled = |scale: &str| run(&[&format!("ride.0.channel.{input}.scale={scale}")]);
        let (Some(with), Some(without), Some(reversed)) =
            (scaled("1.0"), scaled("1e-9"), scaled("-1.0"))
        else {
            return;
        };
        for channel in channels {
            let found = [&with, &without, &reversed].map(|c| rmse(c, channel));
            println!(
                "input {input}, {channel}: {:.4} with it, {:.4} without, {:.4} reversed",
                found[0], found[1], found[2]
            );
            assert!(
                found[0] < found[1] && found[1] < found[2],
                "input {input}, {channel}: {found:?}"
            );
        }
    }
}

/// A sensor with the wrong sign is told by its own channel and by kinematics.
#[test]
fn davis_reversed_steer_sensor_is_told() {
    let Some(found) = run(&["ride.0.channel.4.scale=-1"]) else {
        return;
    };
    let told = found
        .statements
        .iter()
        .any(|s| s.contains("yaw_rate_rad_s has the wrong sign against speed_m_s and steer_rad"));
    assert!(told, "{:?}", found.statements);
}

/// The answer about a study that ships, with keys changed.
fn diagnosed(name: &str, overrides: &[String]) -> Option<Answer> {
    let folder = data()?;
    let study = Study::read(name, overrides).unwrap();
    let folders = DataFolders::new(&study, Some(&folder));
    Some(diagnose_in(&study, &folders, &Options::default(), &mut |_| {}).unwrap())
}

/// One key of one channel in each of the first rides.
fn planted(rides: usize, channels: &[usize], key: &str, value: f64) -> Vec<String> {
    let of = |r: usize| {
        channels
            .iter()
            .map(move |c| format!("ride.{r}.channel.{c}.{key}={value}"))
    };
    (0..rides).flat_map(of).collect()
}

/// Effects that are planted in measured rides are named, with their size, though the rides hold more
/// that has no name: a pull force of half its size, a steer sensor of 1.4 times, a gyro that is late.
#[test]
fn planted_effects_are_found_in_a_measured_ride() {
    let name = "davis_instrumented_105";
    let Some(bare) = diagnosed(name, &[]) else {
        return;
    };
    for (overrides, mechanism, parameter, range) in [
        (
            planted(1, &[1], "scale", 0.5),
            "lateral_force_gain",
            "gain",
            [1.7, 2.5],
        ),
        (
            planted(1, &[4], "scale", 1.4),
            "steer_sensor_scale",
            "gain",
            [1.25, 1.5],
        ),
        (
            // All channels but the gyro are told to be early.
            planted(1, &[0, 1, 2, 3, 4, 6], "delay_s", 0.05),
            "roll_rate_sensor_delay",
            "s",
            [0.035, 0.075],
        ),
    ] {
        let Some(found) = diagnosed(name, &overrides) else {
            return;
        };
        assert!(
            bare.causes.iter().all(|c| c.mechanism != mechanism),
            "{mechanism} without planting"
        );
        let cause = found.causes.iter().find(|c| c.mechanism == mechanism);
        let cause = cause.unwrap_or_else(|| panic!("{mechanism}: {:?}", found.statements));
        let value = cause.parameters[parameter].value;
        assert!(
            (range[0]..range[1]).contains(&value),
            "{mechanism}: {value}, {:?}",
            found.statements
        );
    }
}

/// Speed and steer angle act as a product on a bicycle without a rider who is pulled: a scaled speed
/// is named with what it cannot be told apart from.
#[test]
fn a_planted_speed_scale_is_found_in_a_second_data_set() {
    let Some(found) = diagnosed("davis_robot_bicycle", &planted(8, &[0], "scale", 1.4)) else {
        return;
    };
    let scales = ["speed_scale", "steer_sensor_scale"].map(str::to_owned);
    let first = found.causes.first().map(|c| &c.set);
    assert!(
        first.is_some_and(|set| scales.iter().all(|s| set.contains(s))),
        "{:?}",
        found.statements
    );
}

/// A model that predicts worse than the mean does not end in "no effect".
#[test]
fn a_failing_model_is_not_silent() {
    let overrides = planted(5, &[0], "scale", 1.3);
    let Some(found) = diagnosed("delft_steer_by_wire", &overrides) else {
        return;
    };
    assert_ne!(found.verdict, Verdict::NoEffect, "{:?}", found.statements);
}
