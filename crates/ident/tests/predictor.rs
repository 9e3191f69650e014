//! The predictor against a simulation of its own: RK4 at half a millisecond, noise by seed.

use twinhub_ident::forecast::{Score, forecast, growth};
use twinhub_ident::noise::{self, PROCESS_RANGE};
use twinhub_ident::*;
use twinhub_linear::{Bicycle, Canonical, MotorPair};

const DT: f64 = 5e-4;

/// SplitMix64 with Box and Muller.
struct Random(u64);

impl Random {
    fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        (((z ^ (z >> 31)) >> 11) as f64 + 0.5) / (1u64 << 53) as f64
    }

    fn normal(&mut self) -> f64 {
        let radius = libm::sqrt(-2.0 * libm::log(self.uniform()));
        radius * libm::cos(2.0 * std::f64::consts::PI * self.uniform())
    }
}

#[derive(Clone, Copy)]
struct Simulation {
    seconds: f64,
    process: [f64; 2],
    /// roll, steer, roll rate, yaw rate
    noise: [f64; 4],
    roll_bias: f64,
    law: Option<(f64, f64, f64)>,
    seed: u64,
}

const PLAIN: Simulation = Simulation {
    seconds: 40.0,
    process: [0.8, 0.15],
    noise: [2e-3, 1e-3, 1e-2, 2e-2],
    roll_bias: 0.0,
    law: None,
    seed: 1,
};

fn speed_at(t: f64) -> f64 {
    5.0 + 0.6 * libm::sin(0.4 * t)
}

fn steer_torque_at(t: f64) -> f64 {
    1.5 * libm::sin(1.9 * t) + 0.8 * libm::sin(5.3 * t + 1.0) + 0.4 * libm::sin(11.0 * t)
}

fn side_force_at(t: f64) -> f64 {
    if t.rem_euclid(7.0) < 0.3 { 60.0 } else { 0.0 }
}

/// Straight line between the samples at multiples of 10 ms, as the recorder will know it.
fn sampled(f: impl Fn(f64) -> f64, t: f64) -> f64 {
    let k = libm::floor(t / 0.01 + 1e-9);
    let (a, b) = (f(k * 0.01), f((k + 1.0) * 0.01));
    a + (b - a) * (t / 0.01 - k)
}

fn simulate(s: Simulation) -> (Equations, Ride) {
    let bicycle = Bicycle::load("meijaard2007_benchmark").unwrap();
    let canonical = Canonical::new(&bicycle).unwrap();
    let mut random = Random(s.seed);
    let mut x = [0.02, -0.01, 0.0, 0.0];
    let steps = (s.seconds / DT) as usize;
    let mut samples = vec![vec![]; 4];
    let mut inputs = vec![vec![]; 3];
    let mut rates: Vec<f64> = vec![];
    let mut next = 0;
    for k in 0..steps {
        let t = k as f64 * DT;
        if k % 20 == 0 {
            for (list, f) in
                inputs
                    .iter_mut()
                    .zip([speed_at as fn(f64) -> f64, steer_torque_at, side_force_at])
            {
                list.push((t, f(t)));
            }
        }
        if k == next {
            // Uneven sampling: 8, 10 or 12 ms; one in ten readings is missing.
            next = k + 16 + 4 * (random.uniform() * 3.0) as usize;
            let yaw = canonical.yaw_rate_rad_s(sampled(speed_at, t), x[1], x[3]);
            for (channel, truth) in [x[0] + s.roll_bias, x[1], x[2], yaw]
                .into_iter()
                .enumerate()
            {
                let reading = truth + s.noise[channel] * random.normal();
                if random.uniform() > 0.1 {
                    samples[channel].push((t, reading));
                }
            }
        }
        rates.push(x[2]);
        let disturbance: [f64; 2] =
            std::array::from_fn(|i| s.process[i] * random.normal() / libm::sqrt(DT));
        let rhs = |t: f64, x: [f64; 4]| -> [f64; 4] {
            let speed = sampled(speed_at, t);
            let mut torque = [
                disturbance[0] + 0.9 * sampled(side_force_at, t),
                disturbance[1] + sampled(steer_torque_at, t),
            ];
            if let Some((gain, limit, delay)) = s.law {
                let rate = if delay > 0.0 {
                    rates[k.saturating_sub((delay / DT) as usize)]
                } else {
                    x[2]
                };
                torque[1] += (gain * (7.0 - speed) * rate).clamp(-limit, limit);
            }
            let acceleration = canonical.acceleration(
                speed,
                MotorPair::OFF,
                [x[0], x[1]].into(),
                [x[2], x[3]].into(),
                torque.into(),
            );
            [x[2], x[3], acceleration[0], acceleration[1]]
        };
        let add = |x: [f64; 4], d: [f64; 4], h: f64| std::array::from_fn(|i| x[i] + h * d[i]);
        let k1 = rhs(t, x);
        let k2 = rhs(t + 0.5 * DT, add(x, k1, 0.5 * DT));
        let k3 = rhs(t + 0.5 * DT, add(x, k2, 0.5 * DT));
        let k4 = rhs(t + DT, add(x, k3, DT));
        for i in 0..4 {
            x[i] += DT / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]);
        }
    }
    let outputs = [
        Output::Roll,
        Output::Steer,
        Output::RollRate,
        Output::YawRate,
    ];
    let signal =
        |samples: &Vec<(f64, f64)>| Signal::new(samples.iter().copied(), Hold::Linear).unwrap();
    let drive = |signal, arm| Drive {
        signal,
        arm,
        lag_s: 0.0,
        bias_sd: 0.0,
        noise_sd: 0.0,
    };
    let ride = Ride {
        speed: signal(&inputs[0]),
        front_brake: None,
        rear_traction: None,
        drives: vec![
            drive(signal(&inputs[1]), [0.0, 1.0]),
            drive(signal(&inputs[2]), [0.9, 0.0]),
        ],
        laws: s.law.map_or(vec![], |(gain, limit_nm, delay_s)| {
            vec![Law {
                of: Output::RollRate,
                arm: [0.0, 1.0],
                gain: Gain::SpeedScheduled {
                    gain,
                    speed0_m_s: 7.0,
                },
                limit_nm,
                delay_s,
            }]
        }),
        sensors: outputs
            .iter()
            .zip(samples)
            .enumerate()
            .map(|(i, (output, samples))| Sensor {
                output: *output,
                samples,
                noise: NoiseLevel::Free(i),
                bias_sd: if s.roll_bias != 0.0 && i == 0 {
                    0.1
                } else {
                    0.0
                },
                delay_s: 0.0,
                quantum: 0.0,
                lag_s: 0.0,
                moving_average_s: 0.0,
            })
            .collect(),
        windows: vec![Window {
            start_s: 0.0,
            end_s: s.seconds,
        }],
        clock_jitter_sd_s: 0.0,
    };
    (Equations::new(&bicycle).unwrap(), ride)
}

fn scores(track: &Track, levels: &Levels, horizon: f64) -> Vec<Score> {
    let runs = &forecast(track, levels, &[horizon], 0.5)[0];
    assert!(runs.runs > 0);
    let score = |sensor| {
        let mine = runs
            .predictions
            .iter()
            .filter(|p| track.readings[p.reading].sensor == sensor);
        let pairs: Vec<(f64, f64)> = mine
            .map(|p| (track.readings[p.reading].value, p.predicted))
            .collect();
        let mut score = Score::default();
        score.add(&pairs);
        score
    };
    (0..4).map(score).collect()
}

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
