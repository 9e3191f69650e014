//! Conformance suite: what every disturbance must do.

use super::*;
use core::f64::consts::PI;

const PLACES: Places = Places {
    frame_centre_m: [0.3, 0.9],
    saddle_m: [0.2, 0.95],
};

fn one(name: &str, start_s: f64, seed: u64) -> Disturbances {
    let timed = Timed {
        start_s,
        what: sets::named(name).unwrap(),
    };
    Disturbances::new(&[timed], &PLACES, seed).unwrap()
}

#[derive(Debug, PartialEq, Serialize, Deserialize)]
struct List {
    disturbance: Vec<Timed>,
}

#[test]
fn every_entry_is_listed_explained_valid_and_survives_toml() {
    let mut kinds: Vec<_> = Disturbance::NAMES.to_vec();
    for (name, about, what) in sets::all() {
        assert!(!about.is_empty(), "{name}");
        assert_eq!(what.explain().name, what.name());
        assert!(what.explain().is_complete(), "{name}");
        what.validate().unwrap();
        kinds.retain(|k| *k != what.name());
        let list = List {
            disturbance: vec![Timed { start_s: 2.0, what }],
        };
        let text = toml::to_string(&list).unwrap();
        assert_eq!(
            toml::from_str::<List>(&text).unwrap(),
            list,
            "{name}: {text}"
        );
        let typo = text.replacen(
            &format!("disturbance.what.{}", what.name()),
            "disturbance.what.tornado",
            1,
        );
        assert_ne!(typo, text);
        assert!(toml::from_str::<List>(&typo).is_err());
    }
    assert!(kinds.is_empty(), "no named example of {kinds:?}");
}

#[test]
fn a_wrong_entry_is_refused_with_words() {
    let push = Disturbance::Push(Push {
        force_n: 1.0,
        duration_s: -1.0,
        place: Place::Saddle {},
    });
    let list = [
        Timed {
            start_s: 0.0,
            what: sets::named("kick").unwrap(),
        },
        Timed {
            start_s: 0.0,
            what: push,
        },
    ];
    let error = Disturbances::new(&list, &PLACES, 1).unwrap_err();
    assert_eq!(
        error.to_string(),
        "disturbance 2 (push): duration_s is -1; accepted is 0.001 to 36000"
    );
}

#[test]
fn everything_is_finite_zero_before_its_start_and_zero_after_its_end() {
    for (name, _, what) in sets::all() {
        let d = one(name, 5.0, 3);
        for t in [-1.0, 0.0, 4.999, 4.9999999] {
            assert_eq!(
                d.at(t),
                Wrench {
                    point_x_m: d.at(t).point_x_m,
                    point_height_m: d.at(t).point_height_m,
                    ..Wrench::default()
                },
                "{name} at {t}"
            );
        }
        for i in 0..2000 {
            let w = d.at(5.0 + f64::from(i) * 0.01);
            let sum = w.lateral_force_n + w.steer_torque_nm + w.rear_road_y_m_s2 + w.point_x_m;
            assert!(sum.is_finite(), "{name}");
        }
        if what.name() != "step" {
            let w = d.at(5.0 + 3601.0);
            assert_eq!(
                (w.lateral_force_n, w.steer_torque_nm, w.rear_road_y_m),
                (0.0, 0.0, 0.0),
                "{name}"
            );
        }
    }
}

#[test]
fn a_push_of_a_hundred_ticks_lasts_a_hundred_ticks_wherever_it_starts() {
    for start_ms in [0u32, 1, 3, 7, 100, 333, 1000, 2999, 3001, 59_999, 3_599_999] {
        let d = one("bulsink2017_push", f64::from(start_ms) * 1e-3, 1);
        let ticks = (start_ms.saturating_sub(5)..start_ms + 110)
            .filter(|ms| {
                let t =
                    twinhub_types::Instant::from_nanos(u64::from(*ms) * 1_000_000).as_secs_f64();
                let w = d.at(t);
                assert!(w.lateral_force_n == 0.0 || w.lateral_force_n == 0.1);
                w.lateral_force_n != 0.0
            })
            .collect::<Vec<_>>();
        assert_eq!((ticks.len(), ticks[0]), (100, start_ms));
    }
    let w = one("bulsink2017_push", 0.0, 1).at(0.05);
    assert_eq!([w.point_x_m, w.point_height_m], PLACES.frame_centre_m);
}

#[test]
fn a_kick_has_its_impulse_and_a_gust_its_peak() {
    let d = one("kick", 1.0, 1);
    let n = 50_000;
    let sum: f64 = (0..n)
        .map(|i| {
            d.at(1.0 + 0.05 * (f64::from(i) + 0.5) / f64::from(n))
                .lateral_force_n
        })
        .sum();
    assert!(
        (sum * 0.05 / f64::from(n) - 8.0).abs() < 1e-8,
        "{}",
        sum * 0.05 / f64::from(n)
    );
    let peak = one("side_gust", 0.0, 1).at(0.75).lateral_force_n;
    let expected = 0.5 * 1.2 * 0.8 * 8.0 * libm::sqrt(25.0 + 64.0);
    assert!((peak - expected).abs() < 1e-9, "{peak} {expected}");
    // the other way round it pushes the other way round
    let Some(Disturbance::Gust(gust)) = sets::named("side_gust") else {
        unreachable!()
    };
    let mirrored = Gust {
        wind_m_s: -8.0,
        ..gust
    }
    .build(&PLACES, 1, "x")
    .at(0.75)
    .lateral_force_n;
    assert_eq!(mirrored, -peak);
}

/// Amplitude of `x`, sampled at 100 Hz for 10 s, in each 0.1 Hz bin up to 5 Hz.
fn spectrum(x: impl Fn(f64) -> f64) -> Vec<f64> {
    let n = 1000;
    (0..=50)
        .map(|k| {
            let (mut re, mut im) = (0.0, 0.0);
            for i in 0..n {
                let (s, c) = libm::sincos(2.0 * PI * f64::from(k) * f64::from(i) / f64::from(n));
                let v = x(f64::from(i) * 0.01);
                re += v * c;
                im -= v * s;
            }
            2.0 * libm::sqrt(re * re + im * im) / f64::from(n)
        })
        .collect()
}

#[test]
fn the_rig_has_ten_lines_falling_with_frequency_and_its_published_amplitude() {
    for (name, amplitude) in [
        ("bulsink2017_rig_young", 0.0175),
        ("bulsink2017_rig_older", 0.0125),
    ] {
        let d = one(name, 0.0, 1);
        // two whole periods in the middle, away from the fades
        let spectrum = spectrum(|t| d.at(20.0 + t).rear_road_y_m);
        let bins: Vec<usize> = RIG_LINES_HZ
            .iter()
            .map(|f| (f * 10.0).round() as usize)
            .collect();
        for (k, value) in spectrum.iter().enumerate() {
            if bins.contains(&k) {
                let expected = spectrum[4] * 4.0 / k as f64;
                assert!(
                    (value / expected - 1.0).abs() < 1e-9,
                    "{name}: bin {k}: {value} {expected}"
                );
            } else {
                assert!(*value < 1e-12, "{name}: bin {k} has {value}");
            }
        }
        let largest = (0..10_000)
            .map(|i| d.at(20.0 + f64::from(i) * 1e-3).rear_road_y_m.abs())
            .fold(0.0, f64::max);
        assert!(
            (largest / amplitude - 1.0).abs() < 1e-3,
            "{name}: {largest}"
        );
        for i in 0..500 {
            let t = 20.0 + f64::from(i) * 0.02;
            assert!((d.at(t).rear_road_y_m - d.at(t + 10.0).rear_road_y_m).abs() < 1e-12);
        }
    }
}

#[test]
fn velocity_and_acceleration_of_the_road_are_derivatives_also_in_the_fades() {
    let d = one("bulsink2017_rig_young", 2.0, 1);
    let h = 1e-4;
    for t in [2.2, 2.5, 2.9, 2.9999, 30.0, 101.2, 101.7] {
        let (a, b, c) = (d.at(t - h), d.at(t), d.at(t + h));
        let velocity = (c.rear_road_y_m - a.rear_road_y_m) / (2.0 * h);
        let acceleration = (c.rear_road_y_m_s - a.rear_road_y_m_s) / (2.0 * h);
        assert!(
            (velocity - b.rear_road_y_m_s).abs() < 1e-6,
            "{t}: {velocity} {}",
            b.rear_road_y_m_s
        );
        assert!(
            (acceleration - b.rear_road_y_m_s2).abs() < 1e-4,
            "{t}: {acceleration} {}",
            b.rear_road_y_m_s2
        );
    }
    assert_eq!(d.at(2.0).rear_road_y_m_s2, 0.0, "begins without a jerk");
}

#[test]
fn random_side_force_has_its_rms_and_band_and_follows_its_seed() {
    let d = one("rough_ride", 0.0, 5);
    let n = 200_000;
    let force = |i: i32| d.at(2.0 + f64::from(i) * 0.01).lateral_force_n;
    let square: f64 = (0..n).map(|i| force(i) * force(i)).sum::<f64>() / f64::from(n);
    assert!(
        (libm::sqrt(square) / 20.0 - 1.0).abs() < 0.01,
        "rms {}",
        libm::sqrt(square)
    );
    // zero crossings lie between twice the edges of the band
    let crossings = (0..n)
        .filter(|i| force(*i) < 0.0 && force(i + 1) >= 0.0)
        .count() as f64;
    let rate_hz = crossings / (f64::from(n) * 0.01);
    assert!((0.5..3.0).contains(&rate_hz), "{rate_hz} Hz");
    let at = |seed| one("rough_ride", 0.0, seed).at(7.3).lateral_force_n;
    assert_eq!(at(5).to_bits(), at(5).to_bits());
    assert_ne!(at(5), at(6));
}

#[test]
fn another_disturbance_leaves_the_random_ones_alone() {
    let rough = Timed {
        start_s: 0.0,
        what: sets::named("rough_ride").unwrap(),
    };
    let pull = Timed {
        start_s: 0.0,
        what: sets::named("bar_pull_right").unwrap(),
    };
    let alone = Disturbances::new(&[rough], &PLACES, 5).unwrap();
    let both = Disturbances::new(&[pull, rough], &PLACES, 5).unwrap();
    let twice = Disturbances::new(&[rough, rough], &PLACES, 5).unwrap();
    let f = |d: &Disturbances| d.at(7.3).lateral_force_n;
    assert_eq!(f(&alone), f(&both));
    assert_ne!(2.0 * f(&alone), f(&twice), "two of a kind are independent");
}

#[test]
fn a_sum_of_forces_keeps_force_and_torques() {
    let force = |n, x, h| Wrench {
        lateral_force_n: n,
        point_x_m: x,
        point_height_m: h,
        ..Wrench::default()
    };
    let about_road = |w: Wrench| w.lateral_force_n * w.point_height_m + w.roll_torque_nm;
    let about_vertical = |w: Wrench| w.lateral_force_n * w.point_x_m + w.yaw_torque_nm;
    for (a, b) in [
        (10.0, 5.0),
        (10.0, -4.0),
        (10.0, -10.0),
        (10.0, 0.0),
        (0.0, 3.0),
        (-7.0, 7.0 + 1e-8),
    ] {
        let (one, two) = (force(a, 0.3, 0.9), force(b, 1.1, 0.4));
        let sum = one.plus(two);
        assert_eq!(sum.lateral_force_n, a + b);
        assert!(
            (about_road(sum) - about_road(one) - about_road(two)).abs() < 1e-6,
            "{a} {b}"
        );
        assert!((about_vertical(sum) - about_vertical(one) - about_vertical(two)).abs() < 1e-6);
    }
}
