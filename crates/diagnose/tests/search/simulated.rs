//! Rides of a benchmark bicycle, simulated here with equations and noise of their own: enough for
//! tests of the search's parts. Effects hidden by others are in the crate that makes sealed data.

use std::fmt::Write as _;
use std::path::Path;
use twinhub_linear::{Bicycle, Canonical, MotorPair};

/// What is added to the bicycle.
#[derive(Clone, Copy, Debug, Default)]
pub struct Effect {
    pub damping_nms_rad: f64,
    pub friction_nm: f64,
    pub arm_inertia_kg_m2: f64,
    pub torque_gain: f64,
    pub cross_slope_rad: f64,
    pub gyro_rad: f64,
    pub steer_delay_s: f64,
    /// Outside every library: torque on the steering per cubed roll angle.
    pub steer_per_roll_cubed_nm: f64,
}

/// How the rides are made.
#[derive(Clone, Copy, Debug)]
pub struct Setting {
    /// Factor on every noise and bias.
    pub noise: f64,
    /// Standard deviation of the parameters about the declared ones; 1 % is declared.
    pub spread: f64,
}

impl Default for Setting {
    fn default() -> Self {
        Self {
            noise: 1.0,
            spread: 0.01,
        }
    }
}

/// A small generator of random numbers: the tests need the same ones everywhere.
pub struct Random(u64);

impl Random {
    pub fn new(seed: u64) -> Self {
        Self(
            seed.wrapping_mul(0x9E37_79B9_7F4A_7C15)
                .wrapping_add(0x1234_5678_9ABC_DEF1),
        )
    }

    fn uniform(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    pub fn normal(&mut self) -> f64 {
        let (u, v) = (self.uniform().max(1e-300), self.uniform());
        (-2.0 * u.ln()).sqrt() * (2.0 * std::f64::consts::PI * v).cos()
    }
}

const STEP_S: f64 = 0.001;

/// One ride as CSV: 100 Hz, speed prescribed.
fn ride(
    bicycle: &Bicycle,
    effect: &Effect,
    speed: f64,
    seconds: f64,
    random: &mut Random,
    noise: f64,
) -> String {
    let canonical = Canonical::new(bicycle).unwrap();
    let (mass, k0) = (canonical.mass(), canonical.k0() * bicycle.parameters.g);
    let mut inertia = mass;
    inertia[(1, 1)] += effect.arm_inertia_kg_m2;
    let inverse = inertia.try_inverse().unwrap();
    let tones: Vec<[f64; 3]> = (0..14)
        .map(|k| {
            let f = 0.25 * 1.22f64.powi(k);
            [
                f * 2.0 * std::f64::consts::PI,
                0.3,
                random.uniform() * 6.283,
            ]
        })
        .collect();
    let mut x = [0.02 * noise * random.normal(), 0.0, 0.0, 0.0];
    let mut white_noise = [0.0; 2];
    let mut late = std::collections::VecDeque::new();
    let mut text = String::from("t_s,v,torque,force,roll,steer,roll_rate,yaw_rate\n");
    let ticks = (seconds / STEP_S) as usize;
    let mut torque = 0.0;
    let mut force = 0.0;
    let mut biases = [0.003, 0.003, 0.005, 0.005].map(|sd| noise * sd * random.normal());
    biases[1] *= 0.5;
    for k in 0..ticks {
        let t = k as f64 * STEP_S;
        let v = speed + 0.3 * (0.25 * t).sin();
        if k % 10 == 0 {
            let tones: f64 = tones.iter().map(|[w, a, p]| a * (w * t + p).sin()).sum();
            torque = tones + 5.0 * x[0] + 8.0 * (7.0 - v).max(0.0) * x[2] - x[3];
            let phase = t % 6.0;
            force = if (2.0..2.4).contains(&phase) {
                60.0 * if (t / 6.0) as u32 % 2 == 0 { 1.0 } else { -1.0 }
            } else {
                0.0
            };
            let yaw = canonical.yaw_rate_rad_s(v, x[1], x[3]);
            let gyro = x[2] + effect.gyro_rad * yaw;
            late.push_back((t, x[1]));
            while late.len() > 1 && late[1].0 <= t - effect.steer_delay_s + 1e-9 {
                late.pop_front();
            }
            let steer = if effect.steer_delay_s > 0.0 {
                late[0].1
            } else {
                x[1]
            };
            let said = torque
                / if effect.torque_gain > 0.0 {
                    effect.torque_gain
                } else {
                    1.0
                };
            let _ = writeln!(
                text,
                "{t:.3},{v:.6},{said:.6},{force:.6},{:.7},{:.7},{:.7},{:.7}",
                x[0] + biases[0] + noise * 0.003 * random.normal(),
                steer + biases[1] + noise * 0.002 * random.normal(),
                gyro + biases[2] + noise * 0.01 * random.normal(),
                yaw + biases[3] + noise * 0.01 * random.normal(),
            );
        }
        for white in &mut white_noise {
            *white = noise * random.normal() / STEP_S.sqrt();
        }
        let damping = canonical.damping(v);
        let stiffness = canonical.stiffness(v, MotorPair::OFF);
        let yaw_arm = canonical.yaw_rate_rad_s(0.0, 0.0, 1.0);
        let mut f = nalgebra::Vector2::new(
            force * 0.9 + 0.8 * white_noise[0],
            torque + force * 0.3 * yaw_arm + 0.1 * white_noise[1],
        );
        f -= damping * nalgebra::Vector2::new(x[2], x[3])
            + stiffness * nalgebra::Vector2::new(x[0], x[1]);
        f.x -= k0[(0, 0)] * effect.cross_slope_rad;
        f.y -= k0[(1, 0)] * effect.cross_slope_rad;
        f.y -= effect.damping_nms_rad * x[3];
        f.y += effect.steer_per_roll_cubed_nm * x[0] * x[0] * x[0];
        let mut accel = inverse * f;
        if effect.friction_nm > 0.0 {
            let stop = -(x[3] / STEP_S + accel.y) / inverse[(1, 1)];
            f.y += stop.clamp(-effect.friction_nm, effect.friction_nm);
            accel = inverse * f;
        }
        x[2] += accel.x * STEP_S;
        x[3] += accel.y * STEP_S;
        x[0] += x[2] * STEP_S;
        x[1] += x[3] * STEP_S;
        assert!(x[0].abs() < 0.8, "fell at {t}: {x:?}");
    }
    text
}

/// Writes rides and study into a folder and gives the study's path.
pub fn write(
    folder: &Path,
    effect: &Effect,
    rides: [usize; 2],
    seconds: f64,
    seed: u64,
    setting: Setting,
) -> std::path::PathBuf {
    let mut random = Random::new(seed + 1);
    for _ in 0..20 {
        random.uniform();
    }
    let mut bicycle = Bicycle::load("meijaard2007_benchmark").unwrap();
    for symbol in twinhub_linear::SYMBOLS {
        let value = bicycle.get(symbol).unwrap();
        if *symbol != "g" && value != 0.0 {
            bicycle
                .set(symbol, value * (1.0 + setting.spread * random.normal()))
                .unwrap();
        }
    }
    let mut study = String::from(
        "schema_version = 1\nname = \"simulated\"\n[bicycle]\nmodel = \"benchmark\"\nparameters = \"meijaard2007_benchmark\"\ntolerance_ratio = 0.01\n",
    );
    for index in 0..rides[0] + rides[1] {
        let speed = [3.6, 4.6, 5.6, 4.1, 5.1, 4.9, 3.9][index % 7];
        let name = format!("ride_{index}.csv");
        std::fs::write(
            folder.join(&name),
            ride(&bicycle, effect, speed, seconds, &mut random, setting.noise),
        )
        .unwrap();
        let usage = if index < rides[0] { "fit" } else { "held_out" };
        let _ = write!(
            study,
            "\n[[ride]]\nfile = \"{name}\"\nuse = \"{usage}\"\nrider = \"r\"\nhands = \"on\"\nground = \"road\"\ntime = {{ column = \"t_s\" }}\n"
        );
        for (column, quantity, role, more) in [
            ("v", "speed_m_s", "input", ""),
            ("torque", "steer_torque_nm", "input", "hold = \"zero\"\n"),
            (
                "force",
                "lateral_force_n",
                "input",
                "hold = \"zero\"\npoint_m = [0.3, -0.9]\n",
            ),
            (
                "roll",
                "roll_rad",
                "output",
                "bias_sd = 0.003\nnoise_sd = 0.003\n",
            ),
            (
                "steer",
                "steer_rad",
                "output",
                "bias_sd = 0.003\nnoise_sd = 0.002\n",
            ),
            (
                "roll_rate",
                "roll_rate_rad_s",
                "output",
                "bias_sd = 0.005\nnoise_sd = 0.01\n",
            ),
            ("yaw_rate", "yaw_rate_rad_s", "output", "bias_sd = 0.005\n"),
        ] {
            let _ = write!(
                study,
                "[[ride.channel]]\ncolumn = \"{column}\"\nquantity = \"{quantity}\"\nrole = \"{role}\"\n{more}"
            );
        }
    }
    let path = folder.join("study.toml");
    std::fs::write(&path, study).unwrap();
    path
}
