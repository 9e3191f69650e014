//! Roll from sensors as bought, over a list of manoeuvres: how wrong it is, and whether it says so.
//!
//! Each manoeuvre is ridden with a hundred sets of sensors that differ in offsets, scale,
//! misalignment and noise. Slalom and turns are motions that are laid down, of a bicycle that
//! balances (`h phi'' = g sin(phi) - v psi' cos(phi)`); the rest is ridden on tyres.

use crate::lay_road;
use std::f64::consts::TAU;
use twinhub_control::{Config, Controller};
use twinhub_plant::noise::stream;
use twinhub_plant::road::Road;
use twinhub_plant::sensor::{SensorSuite, SensorTruth, sets};
use twinhub_sim::{Ride, Stepper};
use twinhub_types::{Instant, RiderIntent};

const G: f64 = 9.81;
/// Height at which a mass alone would roll like bicycle and rider, and height of the inertial unit, m.
const ROLL_HEIGHT_M: f64 = 1.05;
const IMU_M: f64 = 0.6;
const SETS: std::ops::RangeInclusive<u64> = 1..=100;

/// Errors of roll over rides of one manoeuvre.
#[derive(Default, Debug)]
struct Errors {
    /// Sum of squares, rad², over all ticks after the first 5 s, and their number.
    squares: f64,
    ticks: f64,
    /// Largest, rad.
    worst_rad: f64,
    /// Of each ride: the squared error by the variance that the estimator claims, at a random time.
    normalised: Vec<f64>,
}

impl Errors {
    fn add(&mut self, error_rad: f64) {
        self.squares += error_rad * error_rad;
        self.ticks += 1.0;
        self.worst_rad = self.worst_rad.max(error_rad.abs());
    }

    fn rms_rad(&self) -> f64 {
        (self.squares / self.ticks).sqrt()
    }
}

/// A laid-down motion: roll (rad) and speed (m/s) by time (s).
struct Motion {
    end_s: f64,
    roll: fn(f64) -> f64,
    speed: fn(f64) -> f64,
}

fn lay_down(motion: &Motion, seed: u64, errors: &mut Errors) {
    let bicycle = Config::NO_TORQUE.bicycle;
    let radius_m = f64::from(bicycle.rear_wheel_radius_m);
    let suite = sets::named("as_bought")
        .expect("ships")
        .with_rear_radius_m(radius_m);
    let mut sensors = SensorSuite::new(&suite, seed).expect("builds");
    let mut controller = Controller::new(&Config::NO_TORQUE);
    let read_s = read_at(seed, motion.end_s);
    let d = 1e-3;
    // Side forces of road and air: 10 N on 105 kg, correlated over 0.3 s.
    let (mut noise, mut side_m_s2) = (stream(seed, "roll_estimate.side_force"), 0.0);
    let (memory, kick) = (1e-3 / 0.3, 0.095 * (2.0 * 1e-3 / 0.3f64).sqrt());
    let tilt_cos = f64::from(bicycle.steer_tilt_rad).cos();
    for tick in 0..(motion.end_s * 1e3) as u64 {
        let t = tick as f64 * 1e-3;
        let [before, roll, after] = [t - d, t, t + d].map(motion.roll);
        let (rate, accel) = (
            (after - before) / (2.0 * d),
            (after - 2.0 * roll + before) / (d * d),
        );
        let v = (motion.speed)(t);
        let v_dot = ((motion.speed)(t + d) - (motion.speed)(t - d)) / (2.0 * d);
        side_m_s2 += kick * noise.normal() - memory * side_m_s2;
        let yaw = (G * roll.sin() + side_m_s2 - ROLL_HEIGHT_M * accel) / (v * roll.cos());
        let steer = (yaw * f64::from(bicycle.wheelbase_m) / v).atan() / tilt_cos;
        let truth = SensorTruth {
            roll_rad: roll,
            roll_rate_rad_s: rate,
            body_rates_rad_s: [rate, yaw * roll.sin(), yaw * roll.cos()],
            specific_force_m_s2: [
                v_dot,
                v * yaw * roll.cos() - G * roll.sin() + IMU_M * accel,
                -v * yaw * roll.sin() - G * roll.cos() + IMU_M * rate * rate,
            ],
            steer_rad: steer,
            front_wheel_rate_rad_s: v / f64::from(bicycle.front_wheel_radius_m),
            rear_wheel_rate_rad_s: v / radius_m,
            speed_m_s: v,
            ..SensorTruth::default()
        };
        let now = Instant::from_nanos(tick * 1_000_000);
        let measurement = sensors.sample(now, &truth);
        let x = controller
            .step(now, &measurement, &RiderIntent::default())
            .estimate;
        if t >= 5.0 {
            errors.add(f64::from(x.roll_rad) - roll);
        }
        if tick == (read_s * 1e3) as u64 {
            let z = (f64::from(x.roll_rad) - roll) / f64::from(x.roll_sd_rad);
            errors.normalised.push(z * z);
        }
    }
}

/// When a ride's normalised error is read, s: one number of each ride, as its errors hang together.
fn read_at(seed: u64, end_s: f64) -> f64 {
    5.0 + (end_s - 5.1) * stream(seed, "roll_estimate.read").uniform()
}

/// A ride on tyres, over a road, at speeds that the course asks for.
fn on_tyres(road: &Road, speed: &str, end_s: f64, seed: u64, errors: &mut Errors) {
    let set = [
        "law=\"scheduled\"".to_owned(),
        "rider=\"young\"".to_owned(),
        "sensors=\"as_bought\"".to_owned(),
        format!("duration_s={end_s:?}"),
        format!("seed={seed}"),
        format!("speed={speed}"),
    ];
    let mut ride = Ride::load("three_to_eight", &set).expect("a ride");
    lay_road(&mut ride, road.clone());
    let mut stepper = Stepper::new(&ride).expect("starts");
    let read_s = read_at(seed, end_s);
    while let Some(step) = stepper.step(None) {
        let (truth, x) = (&step.truth, &step.output.estimate);
        let error_rad = f64::from(x.roll_rad) - truth.roll_rad;
        if stepper.time_s() >= 5.0 {
            errors.add(error_rad);
        }
        if (stepper.time_s() - read_s).abs() < 0.5e-3 {
            errors
                .normalised
                .push((error_rad / f64::from(x.roll_sd_rad)).powi(2));
        }
    }
    assert!(!stepper.fell(), "seed {seed} fell: {speed}");
}

/// Smooth step from 0 to 1 within a second, and slope 0 at both ends.
fn ease(t: f64) -> f64 {
    let s = t.clamp(0.0, 1.0);
    s * s * s * (10.0 + s * (6.0 * s - 15.0))
}

#[test]
fn roll_is_within_a_degree_and_its_uncertainty_is_honest() {
    let laid_down = [
        (
            "slalom",
            Motion {
                end_s: 30.0,
                roll: |t| 0.25 * (TAU * 0.3 * t).sin(),
                speed: |_| 5.0,
            },
        ),
        (
            "hard turns",
            Motion {
                end_s: 30.0,
                roll: |t| {
                    0.45 * (ease(t - 4.0) - ease(t - 12.0))
                        - 0.45 * (ease(t - 15.0) - ease(t - 25.0))
                },
                speed: |_| 6.0,
            },
        ),
        (
            "braking in a turn",
            Motion {
                end_s: 20.0,
                roll: |t| 0.25 * (ease(t - 6.0) - ease(t - 14.0)),
                speed: |t| 7.0 - 4.0 * ease((t - 8.0) / 2.0),
            },
        ),
    ];
    let mut bank = Road::level(1.0);
    bank.bank_rad = 5f64.to_radians();
    let straight = "[{t_s=0.0,speed_m_s=6.0}]";
    let braking = "[{t_s=0.0,speed_m_s=7.0},{t_s=8.0,speed_m_s=7.0},{t_s=10.0,speed_m_s=4.0}]";
    let kerb: Road = toml::from_str(
        "friction_ratio = 1.0\nbumps = [{ step = { start_m = 50.0, height_m = 0.015, length_m = 0.2 } }]",
    )
    .expect("a road");
    let ridden = [
        ("bank of 5 degrees", &bank, straight),
        ("braking", &Road::level(1.0), braking),
        ("kerb", &kerb, straight),
    ];
    let mut rows = Vec::new();
    for (name, motion) in &laid_down {
        let mut errors = Errors::default();
        SETS.for_each(|seed| lay_down(motion, seed, &mut errors));
        rows.push((*name, errors));
    }
    for (name, road, speed) in ridden {
        let mut errors = Errors::default();
        SETS.for_each(|seed| on_tyres(road, speed, 15.0, seed, &mut errors));
        rows.push((name, errors));
    }
    let mut normalised = Vec::new();
    for (name, errors) in &rows {
        let (rms, worst) = (errors.rms_rad().to_degrees(), errors.worst_rad.to_degrees());
        let ratio = mean(&errors.normalised);
        println!("{name}: rms {rms:.2} degrees, worst {worst:.2}, normalised {ratio:.2}");
        assert!(
            rms < 1.0 && worst < 3.0,
            "{name}: rms {rms} degrees, worst {worst}"
        );
        assert_eq!(
            errors.normalised.len() as u64,
            SETS.end() - SETS.start() + 1,
            "{name}: all rides"
        );
        normalised.extend(&errors.normalised);
    }
    // Chi squared of 600 degrees of freedom by their number, within its 95 % band.
    let ratio = mean(&normalised);
    assert!(
        (0.887..1.119).contains(&ratio),
        "normalised squared error {ratio}"
    );
}

fn mean(x: &[f64]) -> f64 {
    x.iter().sum::<f64>() / x.len() as f64
}
