//! Every bicycle of the BicycleParameters project, where the data is at hand.

use std::path::{Path, PathBuf};
use twinhub_linear::{Bicycle, BicycleError, Canonical, Modes, MotorPair};

fn files(of: &str) -> Option<Vec<PathBuf>> {
    let data = std::env::var_os("TWINHUB_DATA").map_or_else(
        || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data"),
        PathBuf::from,
    );
    let folder = data.join("bicycle_parameters").join(of);
    if !folder.is_dir() {
        println!("SKIPPED: no {} (set TWINHUB_DATA)", folder.display());
        return None;
    }
    let mut found = Vec::new();
    for entry in std::fs::read_dir(&folder).unwrap() {
        let parameters = entry.unwrap().path().join("Parameters");
        let Ok(inner) = std::fs::read_dir(parameters) else {
            continue;
        };
        found.extend(
            inner
                .map(|e| e.unwrap().path())
                .filter(|p| p.to_string_lossy().ends_with("Benchmark.txt")),
        );
    }
    found.sort();
    Some(found)
}

fn check(spec: &str) {
    let bicycle = Bicycle::load(spec).unwrap_or_else(|e| panic!("{e}"));
    let equations = Canonical::new(&bicycle).unwrap_or_else(|e| panic!("{spec}: {e}"));
    let speeds: Vec<f64> = (0..=40).map(|k| 0.25 * k as f64).collect();
    for torque in [0.0, 40.0] {
        let modes = Modes::over(&equations, MotorPair::balanced(torque, &bicycle), &speeds);
        for point in &modes.points {
            assert_eq!(point.modes.len(), 4);
            assert!(
                point
                    .modes
                    .iter()
                    .all(|m| m.pair.value.re.is_finite() && m.pair.value.im.is_finite()),
                "{point:?}"
            );
        }
        println!(
            "{} {torque} Nm: weave {:?} {:?}, capsize {:?} {:?}; {}",
            bicycle.name,
            modes.weave,
            modes.weave_speed_m_s(),
            modes.capsize,
            modes.capsize_speed_m_s(),
            bicycle.remarks.join("; ")
        );
    }
    // What is written is what was read.
    let again = Bicycle::from_toml(&bicycle.to_toml(), Path::new("again.toml")).unwrap();
    assert_eq!(again.parameters, bicycle.parameters);
    assert_eq!(again.standard_deviations, bicycle.standard_deviations);
}

#[test]
fn every_bicycle_has_finite_modes() {
    let Some(bicycles) = files("bicycles") else {
        return;
    };
    assert!(bicycles.len() >= 12, "{bicycles:?}");
    for path in bicycles {
        check(&path.to_string_lossy());
    }
}

#[test]
fn riders_join_bicycles_and_do_not_ride_alone() {
    let (Some(bicycles), Some(riders)) = (files("bicycles"), files("riders")) else {
        return;
    };
    assert!(riders.len() >= 3);
    for rider in &riders {
        let alone = Bicycle::load(&rider.to_string_lossy()).unwrap_err();
        let message = alone.to_string();
        assert!(matches!(alone, BicycleError::Missing { .. }), "{message}");
        for part in [
            "w, c, lam",
            "IFyy",
            "BICYCLE+RIDER",
            &rider.file_name().unwrap().to_string_lossy(),
        ] {
            assert!(message.contains(part), "{message} lacks {part}");
        }
        for bicycle in &bicycles {
            check(&format!("{}+{}", bicycle.display(), rider.display()));
        }
        check(&format!("meijaard2007_benchmark+{}", rider.display()));
        for whole in [
            bicycles[1].display().to_string(),
            "bulsink2017_bicycle1".to_owned(),
        ] {
            let error = Bicycle::load(&format!("{}+{whole}", bicycles[0].display())).unwrap_err();
            assert!(matches!(error, BicycleError::NotARider { .. }), "{error}");
        }
    }
}

#[test]
fn deviations_are_kept_and_combined() {
    let (Some(bicycles), Some(riders)) = (files("bicycles"), files("riders")) else {
        return;
    };
    let named = |all: &[PathBuf], part: &str| {
        all.iter()
            .find(|p| p.ends_with(part))
            .unwrap()
            .display()
            .to_string()
    };
    let browser = named(&bicycles, "BrowserBenchmark.txt");
    let bicycle = Bicycle::load(&browser).unwrap();
    assert_eq!(bicycle.standard_deviations["w"], 0.002);
    assert_eq!(bicycle.standard_deviations["mB"], 0.02);
    let both = Bicycle::load(&format!(
        "{browser}+{}",
        named(&riders, "JasonBrowserBenchmark.txt")
    ))
    .unwrap();
    assert!((both.parameters.mB - (9.86 + 72.0)).abs() < 1e-12);
    // 2 kg of the rider and 0.02 kg of the frame.
    assert!((both.standard_deviations["mB"] - (4.0_f64 + 0.0004).sqrt()).abs() < 1e-9);
}
