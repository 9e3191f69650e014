//! The measured ride of the Davis instrumented bicycle. Skipped, loudly, where the data is absent.

use std::path::PathBuf;
use twinhub_diagnose::compare::{Comparison, compare};
use twinhub_diagnose::data::{DataFolders, read_ride};
use twinhub_diagnose::study::Study;

fn data() -> Option<PathBuf> {
    let folder = std::env::var_os("TWINHUB_DATA").map(PathBuf::from);
    let folder = folder.unwrap_or_else(|| PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data")));
    let found = folder.join("davis_instrumented_105/run105_0-40s.csv.gz").is_file();
    if !found {
        println!("SKIPPED: no davis_instrumented_105 in {}; set TWINHUB_DATA", folder.display());
    }
    found.then_some(folder)
}

fn run(overrides: &[&str]) -> Option<Comparison> {
    let folder = data()?;
    let overrides: Vec<String> = overrides.iter().map(|s| (*s).to_owned()).collect();
    let study = Study::read("davis_instrumented_105", &overrides).unwrap();
    let folders = DataFolders::new(&study, Some(&folder));
    let rides: Vec<_> = study.rides.iter().map(|r| read_ride(r, &folders).unwrap()).collect();
    Some(compare(&study, &rides, |_| {}).unwrap())
}

#[test]
fn davis_ride_as_measured() {
    let Some(found) = run(&[]) else { return };
    println!("{}", serde_json::to_string_pretty(&found).unwrap());
    assert!(found.noise.converged);
    for (name, channel) in &found.channels {
        let short = channel.horizons["0.1"].clone().unwrap();
        assert!(short.vaf.unwrap() > 0.5, "{name}: a tenth of a second must be predictable, {short:?}");
        assert!(channel.change_correlation.unwrap() > 0.0, "{name} moves against its prediction");
    }
}

/// The other sign of an input must fit worse: else the ride's axes are not those of the model.
#[test]
fn davis_signs_by_physics() {
    let (Some(right), Some(pull), Some(torque)) =
        (run(&[]), run(&["ride.0.channel.1.scale=-1"]), run(&["ride.0.channel.2.scale=-1"]))
    else {
        return;
    };
    let rmse = |c: &Comparison, channel: &str| c.channels[channel].rmse.unwrap();
    for (name, wrong) in [("pull", &pull), ("steer torque", &torque)] {
        for channel in ["roll_rate_rad_s", "steer_rad", "yaw_rate_rad_s"] {
            println!("{name} reversed, {channel}: {:.4} instead of {:.4}", rmse(wrong, channel), rmse(&right, channel));
        }
        let channel = if name == "pull" { "roll_rate_rad_s" } else { "steer_rad" };
        assert!(rmse(wrong, channel) > 1.2 * rmse(&right, channel), "{name}: {channel}");
    }
    for relation in &right.relations {
        assert!(relation.r > 0.9 && (0.9..1.1).contains(&relation.slope), "{relation:?}");
    }
}
