//! The simulation that the predictor is held against, and rides from it.

use twinhub_ident::forecast::{Score, forecast};
use twinhub_ident::*;
use twinhub_linear::{Bicycle, Canonical, MotorPair};

pub const DT: f64 = 5e-4;

/// SplitMix64 with Box and Muller.
pub struct Random(pub u64);

impl Random {
    pub fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        (((z ^ (z >> 31)) >> 11) as f64 + 0.5) / (1u64 << 53) as f64
    }

    pub fn normal(&mut self) -> f64 {
        let radius = libm::sqrt(-2.0 * libm::log(self.uniform()));
        radius * libm::cos(2.0 * std::f64::consts::PI * self.uniform())
    }
}

#[derive(Clone, Copy)]
pub struct Simulation {
    pub seconds: f64,
    pub process: [f64; 2],
    /// roll, steer, roll rate, yaw rate
    pub noise: [f64; 4],
    pub roll_bias: f64,
    pub law: Option<(f64, f64, f64)>,
    pub seed: u64,
}

pub const PLAIN: Simulation = Simulation {
    seconds: 40.0,
    process: [0.8, 0.15],
    noise: [2e-3, 1e-3, 1e-2, 2e-2],
    roll_bias: 0.0,
    law: None,
    seed: 1,
};

pub fn speed_at(t: f64) -> f64 {
    5.0 + 0.6 * libm::sin(0.4 * t)
}

pub fn steer_torque_at(t: f64) -> f64 {
    1.5 * libm::sin(1.9 * t) + 0.8 * libm::sin(5.3 * t + 1.0) + 0.4 * libm::sin(11.0 * t)
}

pub fn side_force_at(t: f64) -> f64 {
    if t.rem_euclid(7.0) < 0.3 { 60.0 } else { 0.0 }
}

/// Straight line between the samples at multiples of 10 ms, as the recorder will know it.
pub fn sampled(f: impl Fn(f64) -> f64, t: f64) -> f64 {
    let k = libm::floor(t / 0.01 + 1e-9);
    let (a, b) = (f(k * 0.01), f((k + 1.0) * 0.01));
    a + (b - a) * (t / 0.01 - k)
}

pub fn simulate(s: Simulation) -> (Equations, Ride) {
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

pub fn scores(track: &Track, levels: &Levels, horizon: f64) -> Vec<Score> {
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
