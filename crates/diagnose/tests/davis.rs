//! The measured ride of the Davis instrumented bicycle. Skipped, loudly, where the data is absent.

use std::path::PathBuf;
use twinhub_diagnose::compare::{Comparison, compare};
use twinhub_diagnose::data::{DataFolders, read_ride};
use twinhub_diagnose::study::Study;

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
