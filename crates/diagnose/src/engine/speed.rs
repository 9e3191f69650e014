//! What: the predictor of the speed, where it is an output.
//!
//! Equation: m_eff v' = T_rear/rR - T_front/rF + wrench; speed, acceleration and wheel rates are
//! read. Where the speed is prescribed it is taken as it is.
//!
//! Source: twinhub_linear::MotorPair for the effective mass; Harvey (1989), chapter 3.
//!
//! Assumes and ignores: no slip of the wheels, small lateral motion.
//!
//! Valid for: speeds that stay positive.
//!
//! Checked by: `tests` of the engine.

use super::course::{Course, Ends, Felt};
use super::pass::Pass;
use super::ride::{Ride, Sensor};
use super::setup::{Model, Setup};
use super::state::{self, Pace, Which};
use crate::quantity::Quantity;
use nalgebra::Vector2;

/// Speed, then one bias for each longitudinal sensor that has one.
pub fn bias_states(ride: &Ride) -> Vec<Option<usize>> {
    let mut next = 1;
    ride.sensors
        .iter()
        .map(|s| {
            (s.is_longitudinal() && s.bias_sd > 0.0).then(|| {
                next += 1;
                next - 1
            })
        })
        .collect()
}

/// Force per torque of a wheel; a bicycle without wheels has none.
fn per(torque: f64, radius: f64) -> f64 {
    if radius > 0.0 { torque / radius } else { 0.0 }
}

/// Forward acceleration, and the part of it that an accelerometer does not feel.
pub fn acceleration(
    setup: &Setup,
    ride: &Ride,
    ends: &Ends,
    speed_m_s: f64,
    t_s: f64,
    memory: &[f64],
) -> [f64; 2] {
    let body = &setup.plant.body;
    let p = &body.parameters;
    let mut force = per(ends.traction_nm, p.rR) - per(ends.brake_nm, p.rF);
    let mut gravity = 0.0;
    if !setup.pushing.is_empty() {
        let pace = Pace {
            speed_m_s,
            ..Pace::default()
        };
        let at = state::moment(
            setup,
            ride,
            ends,
            &pace,
            &[0.0; 4],
            Vector2::zeros(),
            t_s,
            0.01,
        );
        let w = state::wrench(setup, ride, &at, memory, Which::All);
        force += w.force_n;
        gravity = w.gravity_n;
    }
    [
        force / body.effective_mass_kg,
        gravity / body.effective_mass_kg,
    ]
}

/// Acceleration by which a torque that steps at a reading may be missed or met.
fn unsure(setup: &Setup, felt: &Felt) -> f64 {
    let body = &setup.plant.body;
    let p = &body.parameters;
    (per(felt.traction_half_nm, p.rR) - per(felt.brake_half_nm, p.rF)) / body.effective_mass_kg
}

/// What a longitudinal sensor reads, and its derivatives by speed and by acceleration.
pub fn reading(setup: &Setup, sensor: usize, spec: &Sensor, speed: f64, felt: f64) -> [f64; 3] {
    let model = &setup.sensors[sensor];
    let p = &setup.plant.body.parameters;
    let [by_speed, by_accel] = match spec.quantity {
        Quantity::Speed => [1.0, 0.0],
        Quantity::FrontWheelRate => [per(1.0, p.rF), 0.0],
        Quantity::RearWheelRate => [per(1.0, p.rR), 0.0],
        _ => [0.0, 1.0],
    };
    [
        model.gain * (by_speed * speed + by_accel * felt) + model.offset,
        model.gain * by_speed,
        model.gain * by_accel,
    ]
}

/// Runs the predictor of the speed and gives the pace at the end of each step.
pub fn run(
    ride: &Ride,
    course: &Course,
    setup: &Setup,
    model: &Model,
    pass: &mut Pass,
) -> Vec<Pace> {
    let mut paces = Vec::with_capacity(course.steps.len());
    let mut pace = Pace::default();
    if ride.speed.is_some() {
        for step in &course.steps {
            if step.fresh {
                pace.travel_m = 0.0;
            }
            pace.speed_m_s = step.to.speed_m_s;
            pace.accel_m_s2 = step.to.accel_m_s2;
            pace.ending_m_s2 = step.to.accel_m_s2;
            pace.travel_m += pace.speed_m_s * step.dt_s;
            paces.push(pace);
            pass.record_pace(0.0, &pace);
        }
        return paces;
    }
    let biases = bias_states(ride);
    let n = 1 + biases.iter().flatten().count();
    let mut x = vec![0.0; n];
    let mut p = vec![0.0; n * n];
    let mut gain = vec![0.0; n];
    let mut row = vec![0.0; n];
    for (sensor, bias) in ride.sensors.iter().zip(&biases) {
        if let Some(b) = bias {
            p[b * n + b] = sensor.bias_sd * sensor.bias_sd;
        }
    }
    let level = model.levels.process[2] / setup.plant.body.effective_mass_kg;
    let memory = vec![0.0; setup.memory];
    for (index, step) in course.steps.iter().enumerate() {
        if step.fresh {
            x[0] = 5.0;
            for j in 0..n {
                p[j] = 0.0;
                p[j * n] = 0.0;
            }
            p[0] = 100.0;
            pace.travel_m = 0.0;
        }
        let h = step.dt_s;
        let at = |ends: &Ends, v: f64, t: f64| acceleration(setup, ride, ends, v, t, &memory);
        let mut phi = 1.0;
        if h > 0.0 {
            let a0 = at(&step.from, x[0], step.t_s - h)[0];
            let d = 1e-3;
            let slope = if setup.pushing.is_empty() {
                0.0
            } else {
                (at(&step.from, x[0] + d, step.t_s - h)[0] - a0) / d
            };
            let a1 = at(&step.to, x[0] + a0 * h, step.t_s)[0];
            x[0] += 0.5 * h * (a0 + a1);
            phi = libm::exp(slope * h);
            p[0] = phi * phi * p[0] + level * level * h;
            for j in 1..n {
                p[j] *= phi;
                p[j * n] = p[j];
            }
        }
        let [a, _] = at(course.met(index), x[0], step.t_s);
        let [felt, gravity] = at(&course.felt(index), x[0], step.t_s);
        for r in step.readings.clone() {
            let reading = &course.readings[r];
            let spec = &ride.sensors[reading.sensor];
            if !spec.is_longitudinal() {
                continue;
            }
            let [mut predicted, by_speed, _] =
                self::reading(setup, reading.sensor, spec, x[0], felt - gravity);
            row.fill(0.0);
            row[0] = by_speed;
            if let Some(b) = biases[reading.sensor] {
                row[b] = 1.0;
                predicted += x[b];
            }
            super::small::mul_vec(&mut gain, &p, &row, n);
            let sd = model.noise_sd(spec);
            let quantum = spec.quantum.max(setup.sensors[reading.sensor].quantum);
            let mut noise = sd * sd + quantum * quantum / 12.0;
            let jitter = ride.clock_jitter_sd_s * by_speed * a;
            noise += jitter * jitter;
            if spec.quantity == Quantity::LongitudinalAccel {
                // The accelerometer feels the white force as well, over its sampling interval.
                noise += level * level / h.max(1e-3);
                let half = setup.sensors[reading.sensor].gain * unsure(setup, &step.felt);
                noise += half * half;
            }
            let variance = super::small::dot(&row, &gain) + noise;
            let error = reading.value - predicted;
            for i in 0..n {
                x[i] += gain[i] * error / variance;
                for j in 0..=i {
                    let value = p[i * n + j] - gain[i] * gain[j] / variance;
                    p[i * n + j] = value;
                    p[j * n + i] = value;
                }
            }
            pass.reading(r, error, variance);
            pass.record_slow(r, &row, &gain, variance);
        }
        pace.speed_m_s = x[0];
        pace.accel_m_s2 = a;
        pace.ending_m_s2 = at(&step.to, x[0], step.t_s)[0];
        pace.travel_m += x[0] * h;
        paces.push(pace);
        pass.record_pace(phi, &pace);
    }
    paces
}

/// The speed from `from_m_s` on, free, over steps: calls `visit` with each longitudinal reading and
/// what it should be.
pub fn free_run(
    ride: &Ride,
    course: &Course,
    setup: &Setup,
    from_m_s: f64,
    steps: std::ops::Range<usize>,
    mut visit: impl FnMut(usize, f64),
) {
    let memory = vec![0.0; setup.memory];
    let mut v = from_m_s;
    for index in steps {
        let step = &course.steps[index];
        let (h, t) = (step.dt_s, step.t_s);
        let a0 = acceleration(setup, ride, &step.from, v, t - h, &memory)[0];
        let a1 = acceleration(setup, ride, &step.to, v + a0 * h, t, &memory)[0];
        v += 0.5 * h * (a0 + a1);
        let [felt, gravity] = acceleration(setup, ride, &course.felt(index), v, t, &memory);
        for r in step.readings.clone() {
            let sensor = course.readings[r].sensor;
            let spec = &ride.sensors[sensor];
            if spec.is_longitudinal() {
                visit(r, reading(setup, sensor, spec, v, felt - gravity)[0]);
            }
        }
    }
}
