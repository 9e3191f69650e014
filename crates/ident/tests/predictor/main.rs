//! The predictor against a simulation of its own: RK4 at half a millisecond, noise by seed.

mod simulation;

use simulation::*;
use twinhub_ident::forecast::growth;
use twinhub_ident::noise::{self, PROCESS_RANGE};
use twinhub_ident::*;
use twinhub_linear::MotorPair;

#[test]
fn noise_levels_come_back_and_innovations_are_consistent() {
    let (equations, ride) = simulate(PLAIN);
    let track = Track::new(&equations, &ride).unwrap();
    // Starts a factor of three to five off.
    let range = |start| Range {
        start,
        least: start * 1e-3,
        most: start * 1e3,
    };
    let ranges = [
        PROCESS_RANGE,
        PROCESS_RANGE,
        range(8e-3),
        range(3e-4),
        range(3e-3),
        range(6e-2),
    ];
    let estimate = noise::estimate(
        std::slice::from_ref(&ride),
        std::slice::from_ref(&track),
        &ranges,
        |_| {},
    )
    .unwrap();
    assert!(estimate.converged);
    assert!(!estimate.at_limit.iter().any(|x| *x));
    for (i, truth) in PLAIN.process.iter().chain(&PLAIN.noise).enumerate() {
        let off = (estimate.levels[i] / truth).ln() / estimate.log_standard_error[i];
        println!(
            "level {i}: {} for {truth}, {off:.1} standard errors",
            estimate.levels[i]
        );
        assert!(
            off.abs() < 4.0,
            "level {i}: {} for {truth}, {off:.1} standard errors",
            estimate.levels[i]
        );
        assert!(
            estimate.log_standard_error[i] < 0.15,
            "level {i} is hardly known: {}",
            estimate.log_standard_error[i]
        );
    }
    // One standard deviation of the mean of n squares is sqrt(2/n).
    let allowed = 4.0 * (2.0 / track.readings.len() as f64).sqrt();
    assert!(
        (estimate.consistency - 1.0).abs() < allowed,
        "{} within {allowed}",
        estimate.consistency
    );
    let levels = Levels::new(&ride, &estimate.levels);
    for (channel, score) in scores(&track, &levels, 0.5).iter().enumerate() {
        assert!(
            score.vaf().unwrap() > 0.9,
            "channel {channel}: {:?}",
            score.vaf()
        );
    }
}

/// Without disturbance the free run is the truth: the error is that of the sensors.
#[test]
fn free_run_is_exact() {
    let (equations, ride) = simulate(Simulation {
        process: [0.0; 2],
        noise: [1e-7; 4],
        ..PLAIN
    });
    let track = Track::new(&equations, &ride).unwrap();
    let levels = Levels {
        process_nm_sqrt_s: [1e-5; 2],
        sensor: vec![1e-7; 4],
    };
    for horizon in [0.1, 0.5, 2.0] {
        for (channel, score) in scores(&track, &levels, horizon).iter().enumerate() {
            assert!(
                score.rmse().unwrap() < 2e-5,
                "channel {channel}, {horizon} s: {:?}",
                score.rmse()
            );
        }
    }
}

#[test]
fn laws_with_limit_and_delay() {
    for (law, allowed) in [
        ((1.2, f64::INFINITY, 0.0), 2e-5),
        ((1.2, 0.3, 0.0), 4e-3),
        ((1.2, f64::INFINITY, 0.03), 4e-3),
        ((1.2, 0.5, 0.03), 4e-3),
    ] {
        let (equations, ride) = simulate(Simulation {
            process: [0.0; 2],
            noise: [1e-6; 4],
            law: Some(law),
            ..PLAIN
        });
        let track = Track::new(&equations, &ride).unwrap();
        let levels = Levels {
            process_nm_sqrt_s: [1e-3; 2],
            sensor: vec![1e-5; 4],
        };
        let with = scores(&track, &levels, 0.5);
        let without = Track::new(
            &equations,
            &Ride {
                laws: vec![],
                ..ride.clone()
            },
        )
        .unwrap();
        let without = scores(&without, &levels, 0.5);
        for channel in 0..4 {
            let (with, without) = (
                with[channel].rmse().unwrap(),
                without[channel].rmse().unwrap(),
            );
            println!("{law:?} channel {channel}: {with:.2e} with, {without:.2e} without the law");
            assert!(
                with < allowed && with < 0.2 * without,
                "{law:?} channel {channel}: {with} with, {without} without the law"
            );
        }
    }
}

#[test]
fn bias_is_found_and_kept_over_windows() {
    let (equations, mut ride) = simulate(Simulation {
        roll_bias: 0.04,
        ..PLAIN
    });
    ride.windows = vec![
        Window {
            start_s: 0.0,
            end_s: 30.0,
        },
        Window {
            start_s: 31.0,
            end_s: 34.0,
        },
    ];
    let track = Track::new(&equations, &ride).unwrap();
    let levels = Levels {
        process_nm_sqrt_s: PLAIN.process,
        sensor: PLAIN.noise.to_vec(),
    };
    let first = track.stretches[1].steps.start;
    let estimates = forecast::origins(&track, &levels, &[first]);
    let found = estimates[0].estimate.x[track.layout.dynamic];
    let n = track.layout.states;
    let sd = estimates[0].estimate.p[track.layout.dynamic * n + track.layout.dynamic].sqrt();
    assert!(
        (found - 0.04).abs() < 4.0 * sd && sd < 0.01,
        "{found} +- {sd}"
    );
    // The bicycle's own state is free again.
    assert!(estimates[0].estimate.p[2 * n + 2] > 1e-6);
    let scored = scores(&track, &levels, 0.5);
    assert!(scored[0].rmse().unwrap() < 0.02, "{:?}", scored[0].rmse());
}

struct Record(Vec<(f64, f64, f64)>, Vec<f64>);

impl Listener for Record {
    fn innovation(&mut self, reading: usize, error: f64, variance: f64) {
        self.0.push((self.1[reading], error, variance));
    }
}

/// Changing what is read or done after 20 s changes nothing up to then, to the last bit.
#[test]
fn only_the_past_counts() {
    let (equations, ride) = simulate(PLAIN);
    let levels = Levels {
        process_nm_sqrt_s: PLAIN.process,
        sensor: PLAIN.noise.to_vec(),
    };
    let run = |ride: &Ride| {
        let track = Track::new(&equations, ride).unwrap();
        let mut record = Record(vec![], track.readings.iter().map(|r| r.t_s).collect());
        Filter::new(&track, &levels).run(&mut record);
        let origin = track.steps.partition_point(|s| s.t_s < 19.9);
        let state = forecast::origins(&track, &levels, &[origin])[0]
            .estimate
            .x
            .clone();
        (record.0, state)
    };
    let (plain, state) = run(&ride);
    let mut tampered = ride.clone();
    for sensor in &mut tampered.sensors {
        let first = sensor.samples.partition_point(|s| s.0 < 20.0);
        sensor.samples[first].1 += 0.5;
    }
    let changed: Vec<(f64, f64)> = ride.drives[0]
        .signal
        .times_s()
        .iter()
        .zip(ride.drives[0].signal.values())
        .map(|(t, v)| (*t, if *t > 20.0 { 9.0 } else { *v }))
        .collect();
    tampered.drives[0].signal = Signal::new(changed, Hold::Linear).unwrap();
    let (after, same_state) = run(&tampered);
    assert_eq!(state, same_state);
    let before = plain.iter().filter(|p| p.0 < 20.0).count();
    assert!(before > 3000);
    assert_eq!(plain[..before], after[..before]);
    assert_ne!(plain[before..], after[before..]);
}

/// Delayed, filtered and averaged sensors: declared, they predict as well as plain ones.
#[test]
fn sensors_with_delay_and_filters() {
    let (equations, mut ride) = simulate(Simulation {
        process: [0.0; 2],
        noise: [1e-7; 4],
        ..PLAIN
    });
    let tau = 0.05;
    // The recorder's filters, on the dense truth: straight lines between readings 10 ms apart.
    let dense = Signal::new(ride.sensors[2].samples.iter().copied(), Hold::Linear).unwrap();
    let mut filtered = vec![];
    let mut averaged = vec![];
    let mut state = dense.at(0.0).0;
    let mut history: Vec<f64> = vec![];
    for k in 0..79_000 {
        let t = k as f64 * DT;
        history.push(dense.at(t).0);
        state += DT / tau * (dense.at(t + 0.5 * DT).0 - state);
        if k % 20 == 0 && k > 2000 {
            filtered.push((t + DT, state));
            let mean = history[k - 400..=k]
                .windows(2)
                .map(|p| 0.5 * (p[0] + p[1]))
                .sum::<f64>()
                / 400.0;
            averaged.push((t, mean));
        }
    }
    ride.sensors[2].samples = filtered;
    ride.sensors[2].lag_s = tau;
    ride.sensors[3] = Sensor {
        output: Output::RollRate,
        samples: averaged,
        lag_s: 0.0,
        moving_average_s: 0.2,
        ..ride.sensors[3].clone()
    };
    for (t, _) in &mut ride.sensors[1].samples {
        *t += 0.03;
    }
    ride.sensors[1].delay_s = 0.03;
    ride.windows = vec![Window {
        start_s: 2.0,
        end_s: 39.0,
    }];
    let levels = Levels {
        process_nm_sqrt_s: [1e-2; 2],
        sensor: vec![1e-4; 4],
    };
    let rmse = |ride: &Ride| -> Vec<f64> {
        let track = Track::new(&equations, ride).unwrap();
        scores(&track, &levels, 0.5)
            .iter()
            .map(|s| s.rmse().unwrap())
            .collect()
    };
    let declared = rmse(&ride);
    for sensor in &mut ride.sensors {
        (sensor.delay_s, sensor.lag_s, sensor.moving_average_s) = (0.0, 0.0, 0.0);
    }
    let ignored = rmse(&ride);
    println!("declared {declared:?} ignored {ignored:?}");
    for channel in 0..4 {
        assert!(
            declared[channel] < 0.1 * ignored[channel],
            "channel {channel}: {declared:?} against {ignored:?}"
        );
    }
}

#[test]
fn growth_rates_of_the_benchmark() {
    let (equations, ride) = simulate(Simulation {
        seconds: 1.0,
        ..PLAIN
    });
    let at = |v: f64| growth(&equations.closed_loop(&ride, v, MotorPair::OFF));
    // Meijaard et al. 2007: stable from 4.292 (weave) to 6.024 m/s (capsize).
    assert!(at(4.2).rate_1_s > 0.0 && at(4.2).omega_rad_s > 1.0);
    assert!(at(5.0).rate_1_s < 0.0);
    assert!(at(6.2).rate_1_s > 0.0 && at(6.2).omega_rad_s == 0.0);
}
