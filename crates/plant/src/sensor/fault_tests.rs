//! What every fault must do.

use super::tests::{bytes, faulty, record};
use super::*;

#[test]
fn each_fault_does_what_it_says_between_its_times_and_nothing_else() {
    let clean = record(&sets::named("ideal").unwrap(), 1, 300);
    let run = |kind| record(&faulty(FaultTarget::SteerAngle, kind), 1, 300);
    let kinds = [
        FaultKind::Stuck {},
        FaultKind::Offset { amount: 0.5 },
        FaultKind::Drift { amount_per_s: 2.0 },
        FaultKind::Scale { factor: 3.0 },
        FaultKind::SignSwap {},
        FaultKind::Nan {},
    ];
    for kind in kinds {
        for (ms, (mut bad, good)) in run(kind).into_iter().zip(&clean).enumerate() {
            let (value, truth) = (bad.steer.steer_rad, good.steer.steer_rad);
            if (100..200).contains(&ms) {
                match kind {
                    FaultKind::Stuck {} => assert_eq!(value, clean[100].steer.steer_rad),
                    FaultKind::Offset { .. } => assert!((value - truth - 0.5).abs() < 1e-6),
                    FaultKind::Drift { .. } => {
                        let expected = 2.0 * (ms as f32 - 100.0) * 1e-3;
                        assert!((value - truth - expected).abs() < 1e-5);
                    }
                    FaultKind::Scale { .. } => assert_eq!(value, 3.0 * truth),
                    FaultKind::SignSwap {} => assert_eq!(value, -truth),
                    _ => assert!(value.is_nan()),
                }
            } else {
                assert_eq!(value, truth, "{kind:?} outside its time, {ms} ms");
            }
            bad.steer.steer_rad = truth;
            assert_eq!(bytes(&bad), bytes(good), "{kind:?} touches something else");
        }
    }
}

#[test]
fn late_samples_are_late_by_the_tick_and_dead_sensors_age() {
    let late = record(
        &faulty(FaultTarget::Imu, FaultKind::Late { delay_s: 0.03 }),
        1,
        300,
    );
    assert_eq!(late[99].imu.stamp_ns, 99_000_000);
    for (ms, m) in (0..).zip(&late).skip(100).take(100) {
        assert_eq!(m.imu.stamp_ns, (ms - 30) * 1_000_000);
        assert_eq!(m.steer.stamp_ns, ms * 1_000_000);
    }
    assert_eq!(late[200].imu.stamp_ns, 200_000_000);
    let dead = record(
        &faulty(FaultTarget::Wheels, FaultKind::Dropout { share_ratio: 1.0 }),
        1,
        300,
    );
    assert!((100..200).all(|ms| dead[ms].wheels == dead[99].wheels));
    assert_eq!(dead[200].wheels.stamp_ns, 200_000_000);
}

#[test]
fn spikes_and_losses_have_their_share() {
    let long = |kind| {
        let fault = Fault {
            target: FaultTarget::GyroX,
            start_s: 0.0,
            end_s: None,
            kind,
        };
        SuiteParameters {
            fault: vec![fault],
            ..sets::named("ideal").unwrap()
        }
    };
    let n = 20_000;
    let spread = 5.0 * libm::sqrt(0.09 / n as f64);
    let log = record(
        &long(FaultKind::Spike {
            amount: 5.0,
            share_ratio: 0.1,
        }),
        1,
        n,
    );
    let clean = record(&sets::named("ideal").unwrap(), 1, n);
    let hits = log
        .iter()
        .zip(&clean)
        .filter(|(a, b)| (a.imu.gyro_rad_s[0] - b.imu.gyro_rad_s[0]).abs() > 4.9)
        .count();
    assert!(
        (hits as f64 / n as f64 - 0.1).abs() < spread,
        "{hits} of {n}"
    );
    let log = record(&long(FaultKind::Dropout { share_ratio: 0.1 }), 1, n);
    let lost = log
        .iter()
        .enumerate()
        .filter(|(ms, m)| m.imu.stamp_ns != *ms as u64 * 1_000_000)
        .count();
    assert!(
        (lost as f64 / n as f64 - 0.1).abs() < spread,
        "{lost} of {n}"
    );
}

#[test]
fn every_target_changes_its_own_channels_only() {
    let clean = record(&sets::named("ideal").unwrap(), 1, 150);
    let mut seen = std::collections::BTreeSet::new();
    for target in FaultTarget::ALL {
        let bad = record(&faulty(target, FaultKind::Offset { amount: 7.0 }), 1, 150);
        let (a, b) = (bytes(&bad[120]), bytes(&clean[120]));
        let words: Vec<usize> = (0..a.len() / 4)
            .filter(|i| a[4 * i..4 * i + 4] != b[4 * i..4 * i + 4])
            .collect();
        assert!(!words.is_empty(), "{target:?}");
        assert!(seen.insert(words), "{target:?} is the same as another");
    }
    let text = toml::to_string(&faulty(FaultTarget::GyroX, FaultKind::Stuck {})).unwrap();
    let back: SuiteParameters = toml::from_str(&text).unwrap();
    assert_eq!(back.fault[0].target, FaultTarget::GyroX);
}
