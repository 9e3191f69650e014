//! Conformance suite: what every sensor, suite and fault must do.

use super::*;
use twinhub_types::{NEVER_NS, WheelSample, Wire};

pub(super) fn at(ms: u64) -> Instant {
    Instant::from_nanos(ms * 1_000_000)
}

/// A lively but smooth ride.
pub(super) fn truth(ms: u64) -> SensorTruth {
    let t = ms as f64 * 1e-3;
    SensorTruth {
        roll_rad: 0.1 * libm::sin(2.0 * t),
        roll_rate_rad_s: 0.2 * libm::cos(2.0 * t),
        body_rates_rad_s: [0.2 * libm::cos(2.0 * t), 0.01, 0.3 * libm::sin(t)],
        specific_force_m_s2: [0.1, 0.5 * libm::sin(t), -9.81],
        steer_rad: 0.05 * libm::sin(3.0 * t),
        steer_rate_rad_s: 0.15 * libm::cos(3.0 * t),
        front_wheel_rate_rad_s: 14.0 + libm::sin(t),
        rear_wheel_rate_rad_s: 14.1 + libm::sin(t),
        speed_m_s: 0.35 * (14.1 + libm::sin(t)),
        front_brake_nm: 20.0,
        rear_traction_nm: 21.0,
        bus_v: 48.0,
        bus_a: 3.0,
        winding_celsius: 40.0,
    }
}

pub(super) fn bytes(m: &Measurement) -> Vec<u8> {
    let mut out = vec![0; Measurement::SIZE];
    m.put(&mut out).unwrap();
    out
}

pub(super) fn record(suite: &SuiteParameters, seed: u64, ticks: u64) -> Vec<Measurement> {
    let mut suite = SensorSuite::new(suite, seed).unwrap();
    (0..ticks)
        .map(|ms| suite.sample(at(ms), &truth(ms)))
        .collect()
}

pub(super) fn faulty(target: FaultTarget, kind: FaultKind) -> SuiteParameters {
    let fault = Fault {
        target,
        start_s: 0.1,
        end_s: Some(0.2),
        kind,
    };
    SuiteParameters {
        fault: vec![fault],
        ..sets::named("ideal").unwrap()
    }
}

#[test]
fn every_suite_and_sensor_is_explained_valid_and_survives_toml() {
    for (name, about) in sets::SUITES {
        assert!(!about.is_empty());
        let suite = sets::named(name).unwrap();
        for sensor in &suite.sensor {
            assert_eq!(sensor.name(), sensor.explain().name);
            assert!(sensor.explain().is_complete());
        }
        let text = toml::to_string(&suite).unwrap();
        assert_eq!(
            toml::from_str::<SuiteParameters>(&text).unwrap(),
            suite,
            "{name}"
        );
        let typo = text.replacen("delay_s", "delays_s", 1);
        assert!(
            toml::from_str::<SuiteParameters>(&typo).is_err(),
            "{name}: a typo passes"
        );
        SensorSuite::new(&suite, 1).unwrap();
    }
    let all = sets::named("ideal").unwrap();
    let listed: Vec<_> = all.sensor.iter().map(SensorParameters::name).collect();
    assert_eq!(
        listed,
        SensorParameters::NAMES,
        "the ideal suite has every sensor"
    );
    assert_eq!(SensorParameters::NAMES, Sensor::NAMES);
}

#[test]
fn a_wrong_suite_is_refused_with_words() {
    let mut suite = sets::named("as_bought").unwrap();
    suite.sensor.push(suite.sensor[0]);
    let error = SensorSuite::new(&suite, 1).unwrap_err().to_string();
    assert_eq!(error, "sensor imu is listed 2 times; accepted is once");
    let SensorParameters::Imu(imu) = &mut suite.sensor[0] else {
        unreachable!()
    };
    imu.timing.rate_hz = 5000.0;
    let error = SensorSuite::new(&suite, 1).unwrap_err().to_string();
    assert_eq!(
        error,
        "sensor imu: rate_hz is 5000; accepted is 0.1 to 1000"
    );
    let late = faulty(FaultTarget::Imu, FaultKind::Late { delay_s: 2.0 });
    let error = SensorSuite::new(&late, 1).unwrap_err().to_string();
    assert_eq!(error, "fault 1: delay_s is 2; accepted is 0 to 0.5");
}

#[test]
fn ideal_sensors_tell_the_truth_at_once() {
    let mut suite = SensorSuite::new(&sets::named("ideal").unwrap(), 9).unwrap();
    for ms in 0..50 {
        let t = truth(ms);
        let m = suite.sample(at(ms), &t);
        for stamp in [
            m.imu.stamp_ns,
            m.roll.stamp_ns,
            m.steer.stamp_ns,
            m.wheels.stamp_ns,
            m.motors.stamp_ns,
        ] {
            assert_eq!(stamp, ms * 1_000_000);
        }
        assert_eq!(m.imu.gyro_rad_s, t.body_rates_rad_s.map(|v| v as f32));
        assert_eq!(m.imu.accel_m_s2, t.specific_force_m_s2.map(|v| v as f32));
        assert_eq!(
            (m.roll.roll_rad, m.roll.roll_rate_rad_s),
            (t.roll_rad as f32, t.roll_rate_rad_s as f32)
        );
        assert_eq!(
            (m.steer.steer_rad, m.steer.steer_rate_rad_s),
            (t.steer_rad as f32, t.steer_rate_rad_s as f32)
        );
        assert_eq!(m.wheels.front_rad_s, t.front_wheel_rate_rad_s as f32);
        assert_eq!(
            (m.wheels.rear_rad_s, m.wheels.speed_m_s),
            (t.rear_wheel_rate_rad_s as f32, t.speed_m_s as f32)
        );
        assert_eq!(
            (m.motors.front_brake_nm, m.motors.rear_traction_nm),
            (20.0, 21.0)
        );
        assert_eq!(
            (m.motors.bus_v, m.motors.bus_a, m.motors.winding_celsius),
            (48.0, 3.0, 40.0)
        );
    }
}

#[test]
fn a_seed_repeats_bit_for_bit_and_another_differs() {
    let suite = sets::named("as_bought").unwrap();
    let all = |seed| {
        record(&suite, seed, 500)
            .iter()
            .flat_map(bytes)
            .collect::<Vec<u8>>()
    };
    assert_eq!(all(4), all(4));
    assert_ne!(all(4), all(5));
}

#[test]
fn adding_a_sensor_or_a_fault_leaves_every_other_stream_alone() {
    let plain = sets::named("as_bought").unwrap();
    let mut more = plain.clone();
    more.sensor
        .insert(0, sets::named("laboratory").unwrap().sensor[1]);
    more.fault.push(Fault {
        target: FaultTarget::Motors,
        start_s: 0.0,
        end_s: None,
        kind: FaultKind::Spike {
            amount: 1.0,
            share_ratio: 0.5,
        },
    });
    let (a, b) = (record(&plain, 8, 500), record(&more, 8, 500));
    assert!(b.iter().any(|m| m.roll.stamp_ns != NEVER_NS));
    for (mut a, mut b) in a.into_iter().zip(b) {
        b.roll = a.roll;
        (a.motors, b.motors) = Default::default();
        assert_eq!(bytes(&a), bytes(&b));
    }
}

#[test]
fn as_bought_has_no_roll_and_no_steer_rate_and_arrives_late() {
    let log = record(&sets::named("as_bought").unwrap(), 2, 1000);
    let m = log.last().unwrap();
    assert_eq!(m.roll.stamp_ns, NEVER_NS);
    assert!(m.steer.steer_rate_rad_s.is_nan());
    assert_eq!(m.imu.stamp_ns, 997 * 1_000_000, "2 ms late");
    assert_eq!(log[1].imu.stamp_ns, NEVER_NS, "nothing has arrived yet");
    assert_eq!(log[2].imu.stamp_ns, 0);
}

#[test]
fn steer_rate_by_difference_follows_the_truth_behind_its_lag() {
    let log = record(&sets::named("laboratory").unwrap(), 2, 4000);
    let mut square = 0.0;
    for (ms, m) in log.iter().enumerate().skip(100) {
        let expected = truth(ms as u64).steer_rate_rad_s;
        let e = f64::from(m.steer.steer_rate_rad_s) - expected;
        square += e * e;
    }
    let rms = libm::sqrt(square / 3900.0);
    assert!(rms < 0.05, "rms {rms} of 0.15");
}

/// Halls of `edges` at constant `rate` for one second, then what they say.
fn hall(edges: u32, placement: f64, rate: impl Fn(u64) -> f64, ticks: u64) -> Vec<WheelSample> {
    let halls = WheelHallParameters {
        edges_per_turn: edges,
        edge_placement_sd_rad: placement,
        edges_averaged: 1,
        timer_s: 1e-6,
        standstill_s: 0.3,
        rear_radius_m: 0.35,
        radius_error_ratio: 0.0,
        timing: Timing::IDEAL,
    };
    let suite = SuiteParameters {
        sensor: vec![SensorParameters::WheelHall(halls)],
        fault: vec![],
    };
    let mut suite = SensorSuite::new(&suite, 6).unwrap();
    (0..ticks)
        .map(|ms| {
            let truth = SensorTruth {
                front_wheel_rate_rad_s: rate(ms),
                rear_wheel_rate_rad_s: rate(ms),
                ..SensorTruth::default()
            };
            suite.sample(at(ms), &truth).wheels
        })
        .collect()
}

#[test]
fn pulses_give_the_rate_in_both_directions_and_go_stale_when_slow() {
    for rate in [1.0, 5.0, 14.0, 40.0, 200.0, -3.0, -20.0] {
        let last = *hall(138, 0.0, |_| rate, 1000).last().unwrap();
        // a timer step of 1 µs on the time between edges
        let between_s = 2.0 * core::f64::consts::PI / 138.0 / rate.abs();
        let tolerance = rate.abs() * 3e-6 / between_s.min(1e-3) + 1e-4;
        assert!(
            (f64::from(last.front_rad_s) - rate).abs() < tolerance,
            "{rate}: {}",
            last.front_rad_s
        );
        assert!((f64::from(last.speed_m_s) - 0.35 * rate).abs() < tolerance);
        let age_s = 0.999 - last.stamp_ns as f64 * 1e-9;
        assert!(
            age_s <= between_s + 1e-3,
            "{rate}: {age_s} s old, edges {between_s} s apart"
        );
    }
    // one pulse a turn at 1 m/s: up to 2.2 s between pulses, and the wheel counts as standing
    let slow = hall(1, 0.0, |_| 2.86, 5000);
    assert!(
        slow.iter().any(|s| s.front_rad_s == 0.0),
        "0.3 s without an edge"
    );
    let ages: Vec<u64> = slow
        .iter()
        .enumerate()
        .map(|(ms, s)| ms as u64 * 1_000_000 - s.stamp_ns)
        .collect();
    assert!(ages.iter().all(|a| *a <= 300_000_000));
}

#[test]
fn a_stopping_wheel_is_never_reported_faster_than_its_silence_allows() {
    let log = hall(138, 0.0, |ms| if ms < 500 { 10.0 } else { 0.0 }, 1000);
    for (ms, s) in log.iter().enumerate().skip(510) {
        let silence_s = (ms as f64 - 500.0) * 1e-3;
        let bound = 2.0 * core::f64::consts::PI / 138.0 / silence_s;
        assert!(
            f64::from(s.front_rad_s) <= bound * 1.001,
            "{ms}: {}",
            s.front_rad_s
        );
    }
    assert_eq!(log[999].front_rad_s, 0.0);
    assert_eq!(log[999].stamp_ns, 999_000_000, "standing is news");
}

#[test]
fn uneven_edges_ripple_once_a_turn_and_average_out() {
    let log = hall(46, 0.01, |_| 12.0, 10_000);
    let values: Vec<f64> = log
        .iter()
        .skip(200)
        .map(|s| f64::from(s.front_rad_s))
        .collect();
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let worst = values.iter().map(|v| (v - 12.0).abs()).fold(0.0, f64::max);
    assert!(worst > 0.2, "placement errors show: {worst}");
    assert!((mean - 12.0).abs() < 0.3, "mean {mean}");
    // the same edge errs in the same way one turn later (2π/12 s = 523.6 ms)
    let turn = (2.0 * core::f64::consts::PI / 12.0 * 1000.0).round() as usize;
    let (mut same, mut other) = (0.0, 0.0);
    for i in 0..values.len() - turn {
        same += (values[i] - mean) * (values[i + turn] - mean);
        other += (values[i] - mean) * (values[i] - mean);
    }
    assert!(
        same / other > 0.8,
        "correlation after a turn {}",
        same / other
    );
}

#[test]
fn a_plant_gone_mad_does_not_stop_the_sensors() {
    for wild in [f64::NAN, f64::INFINITY, -f64::INFINITY, 1e300, -1e300] {
        let mut suite = SensorSuite::new(&sets::named("as_bought").unwrap(), 1).unwrap();
        for ms in 0..100 {
            let mut t = truth(ms);
            if ms > 50 {
                t.front_wheel_rate_rad_s = wild;
                t.rear_wheel_rate_rad_s = wild;
                t.body_rates_rad_s = [wild; 3];
                t.steer_rad = wild;
            }
            let m = suite.sample(at(ms), &t);
            assert!(
                m.wheels.front_rad_s.is_finite(),
                "pulses are counted, not believed"
            );
        }
    }
}
