//! What: how the innovations change when the plant changes, with the filter's gain kept.
//!
//! Equation: dx+ = Phi dx + held dT0 + ramp (dT1 - dT0); at a reading de = -(c dx + dh),
//! dx = dx + gain de. dT is the torque by which the changed plant's accelerations differ from the
//! base's at the predicted state, dh the difference of what the sensor reads; the speed's equation
//! alike.
//!
//! Source: the derivative of the predictor in innovations form, L. Ljung, System Identification
//! (1999), section 10.3; a finite change is put in as it is, so that friction and play keep their
//! form.
//!
//! Assumes and ignores: the gain does not change with the plant. Under the base model the
//! innovations are white whatever they are multiplied with, so tests stay exact; fits are repeated
//! with the gain of the changed plant.
//!
//! Valid for: small changes.
//!
//! Checked by: `tests` of the engine: against differences of whole passes.

use super::course::Course;
use super::layout::{HEADING, Layout};
use super::pass::{Pass, Record};
use super::ride::Ride;
use super::setup::{Model, Plant, Setup};
use super::small::dot;
use super::speed;
use super::state::{self, Balance, Pace, Which};
use nalgebra::Vector2;

/// Accelerations and readings of one plant along the recorded path.
struct Side<'a> {
    ride: &'a Ride,
    setup: &'a Setup,
    course: &'a Course,
    layout: &'a Layout,
    memory: Vec<f64>,
}

/// What happens at one end of a step.
#[derive(Clone, Copy, Debug, Default)]
struct There {
    accel: Vector2<f64>,
    yaw_rate: f64,
    slip: f64,
}

impl<'a> Side<'a> {
    fn new(ride: &'a Ride, setup: &'a Setup, course: &'a Course, layout: &'a Layout) -> Self {
        Self {
            ride,
            setup,
            course,
            layout,
            memory: vec![0.0; setup.memory],
        }
    }

    /// At one end of a step; `advance` moves the memory on from there.
    fn at(
        &mut self,
        index: usize,
        start: bool,
        x: &[f64],
        pace: &Pace,
        advance: Option<bool>,
    ) -> There {
        let step = &self.course.steps[index];
        let (ends, t_s) = if start {
            (&step.from, step.t_s - step.dt_s)
        } else {
            (&step.to, step.t_s)
        };
        let pace = &if start { *pace } else { pace.at_end() };
        let balance = Balance::new(self.setup, ends, pace);
        let mut torque = balance.net(x);
        for (index, latent) in self.layout.latent.iter().flatten() {
            torque += Vector2::from(latent.arm) * x[*index];
        }
        for (bias, arm) in self.layout.drive_bias.iter().zip(&self.setup.arms) {
            if let Some(bias) = bias {
                torque.x -= arm[0] * x[*bias];
                torque.y -= arm[1] * x[*bias];
            }
        }
        let body = &self.setup.plant.body;
        let free = body.mass_inverse * torque;
        let moment = state::moment(self.setup, self.ride, ends, pace, x, free, t_s, step.dt_s);
        let yaw_rate = moment.yaw_rate_rad_s();
        if !state::is_pushed(self.setup, self.ride) {
            return There {
                accel: free,
                yaw_rate,
                slip: 0.0,
            };
        }
        if advance == Some(true) {
            state::remember(self.setup, &moment, &mut self.memory, true);
        }
        let w = state::wrench(self.setup, self.ride, &moment, &self.memory, Which::All);
        if advance.is_some() {
            state::remember(self.setup, &moment, &mut self.memory, false);
        }
        There {
            accel: free + body.mass_inverse * Vector2::new(w.roll_nm, w.steer_nm),
            yaw_rate: yaw_rate + w.yaw_rate_rad_s,
            slip: w.yaw_rate_rad_s,
        }
    }
}

/// What one plant does along the recorded path: at both ends of each step, and what the sensors would
/// read.
#[derive(Clone, Debug, Default)]
pub struct Along {
    ends: Vec<[There; 2]>,
    told: Vec<f64>,
}

/// Goes along the recorded path of `base` with one plant; `moved` gives its pace at an end of a step.
fn along(
    side: &mut Side<'_>,
    base: &Setup,
    record: &Record,
    moved: impl Fn(usize, usize, &Pace) -> Pace,
) -> Along {
    let (ride, setup, layout, course) = (side.ride, side.setup, side.layout, side.course);
    let n = record.n;
    let mut found = Along {
        ends: Vec::with_capacity(course.steps.len()),
        told: vec![0.0; course.readings.len()],
    };
    let mut pace = Pace::default();
    for (index, step) in course.steps.iter().enumerate() {
        if step.fresh {
            pace = record.pace[index];
            side.memory.fill(0.0);
        }
        let after = record.pace[index];
        let x1 = &record.x1[index * n..(index + 1) * n];
        let mut ends = [There::default(); 2];
        if step.dt_s > 0.0 {
            let x0 = &record.x0[index * n..(index + 1) * n];
            let begin = Some(step.fresh);
            ends = [
                side.at(index, true, x0, &moved(index, 0, &pace), begin),
                side.at(index, false, x1, &moved(index, 1, &after), None),
            ];
        } else if step.fresh {
            let x2 = &record.x2[index * n..(index + 1) * n];
            // The first moment: memories start from what the readings say.
            side.at(index, false, x2, &moved(index, 1, &after), Some(true));
        }
        for r in step.readings.clone() {
            let reading = &course.readings[r];
            let sensor = &ride.sensors[reading.sensor];
            if sensor.is_longitudinal() {
                continue;
            }
            let model = &setup.sensors[reading.sensor];
            if let Some(filter) = layout.filters[reading.sensor] {
                // Behind a recorder's filter only gain and offset are seen.
                let gain = model.gain / base.sensors[reading.sensor].gain;
                found.told[r] = gain * x1[filter] + model.offset;
                continue;
            }
            let pace = &moved(index, 1, &after);
            let met = course.met(index);
            let accel = setup.plant.body.mass_inverse * Balance::new(setup, met, pace).net(x1);
            let at = state::moment(setup, ride, met, pace, x1, accel, step.t_s, step.dt_s);
            let heading = if layout.heading { x1[HEADING] } else { 0.0 };
            found.told[r] = state::reading(setup, sensor, model, &at, heading, ends[1].slip)
                - model.delay_s * state::reading_rate(sensor, &at);
        }
        found.ends.push(ends);
        pace = after;
    }
    found
}

/// Change of every innovation when the plant becomes `changed`.
pub fn change(
    ride: &Ride,
    course: &Course,
    base: &Plant,
    changed: &Plant,
    model: &Model,
    record: &Record,
) -> Vec<f64> {
    let layout = Layout::new(ride, model);
    let (s0, s1) = (Setup::new(base, ride), Setup::new(changed, ride));
    let refilled = (!s0.same_inputs(&s1)).then(|| course.refilled(ride, &s1));
    let other = refilled.as_ref().unwrap_or(course);
    let speed_change = speed_changes(ride, course, other, &s0, &s1, record);
    let (n, nd) = (record.n, record.nd);
    let side = |setup, course| Side::new(ride, setup, course, &layout);
    // The same for every change of this pass.
    let here = record
        .along
        .get_or_init(|| along(&mut side(&s0, course), &s0, record, |_, _, pace| *pace));
    let there = along(&mut side(&s1, other), &s0, record, |index, k, pace| {
        if ride.speed.is_some() {
            let step = &other.steps[index];
            let ends = if k == 0 { &step.from } else { &step.to };
            Pace {
                speed_m_s: ends.speed_m_s,
                accel_m_s2: ends.accel_m_s2,
                ending_m_s2: ends.accel_m_s2,
                ..*pace
            }
        } else {
            let [v, acc] = speed_change.at(index, k);
            Pace {
                speed_m_s: pace.speed_m_s + v,
                accel_m_s2: pace.accel_m_s2 + acc,
                ending_m_s2: pace.ending_m_s2 + acc,
                ..*pace
            }
        }
    });
    let mass = s0.plant.body.terms.mass;
    let mut change = vec![0.0; course.readings.len()];
    let mut dx = vec![0.0; n];
    let mut next = vec![0.0; nd];
    for (index, step) in course.steps.iter().enumerate() {
        if step.fresh {
            dx[..nd].fill(0.0);
        }
        if step.dt_s > 0.0 {
            let ([p0, p1], [q0, q1]) = (&here.ends[index], &there.ends[index]);
            let t0 = mass * (q0.accel - p0.accel);
            let t1 = mass * (q1.accel - p1.accel);
            let top = &record.top[index * nd * n..(index + 1) * nd * n];
            let held = &record.held[index * 2 * nd..(index + 1) * 2 * nd];
            let ramp = &record.ramp[index * 2 * nd..(index + 1) * 2 * nd];
            for i in 0..nd {
                next[i] = dot(&top[i * n..(i + 1) * n], &dx)
                    + held[i] * t0.x
                    + held[nd + i] * t0.y
                    + ramp[i] * (t1.x - t0.x)
                    + ramp[nd + i] * (t1.y - t0.y);
            }
            if layout.heading {
                next[HEADING] +=
                    0.5 * step.dt_s * (q0.yaw_rate - p0.yaw_rate + q1.yaw_rate - p1.yaw_rate);
            }
            dx[..nd].copy_from_slice(&next);
        }
        for r in step.readings.clone() {
            let reading = &course.readings[r];
            if ride.sensors[reading.sensor].is_longitudinal() {
                continue;
            }
            let row = &record.row[r * n..(r + 1) * n];
            let gain = &record.gain[r * n..(r + 1) * n];
            let de = -(dot(row, &dx) + there.told[r] - here.told[r]);
            change[r] = de;
            for (x, k) in dx.iter_mut().zip(gain) {
                *x += k * de;
            }
        }
    }
    for (r, de) in speed_change.readings {
        change[r] = de;
    }
    change
}

/// Changes of speed and acceleration at both ends of each step, and of the longitudinal readings.
struct SpeedChange {
    ends: Vec<[[f64; 2]; 2]>,
    readings: Vec<(usize, f64)>,
}

impl SpeedChange {
    fn at(&self, step: usize, end: usize) -> [f64; 2] {
        self.ends.get(step).map_or([0.0; 2], |e| e[end])
    }
}

fn speed_changes(
    ride: &Ride,
    course: &Course,
    other: &Course,
    s0: &Setup,
    s1: &Setup,
    record: &Record,
) -> SpeedChange {
    let mut change = SpeedChange {
        ends: vec![],
        readings: vec![],
    };
    if ride.speed.is_some() {
        return change;
    }
    let n = record.slow;
    let biases = speed::bias_states(ride);
    let mut dx = vec![0.0; n];
    let (m0, m1) = (vec![0.0; s0.memory], vec![0.0; s1.memory]);
    let mut v = 0.0;
    for (index, step) in course.steps.iter().enumerate() {
        let pace = record.pace[index];
        if step.fresh {
            dx[0] = 0.0;
            v = pace.speed_m_s;
        }
        let start = dx[0];
        let (h, t) = (step.dt_s, step.t_s);
        let (f0, f1) = (&step.from, &other.steps[index].from);
        let (e0, e1) = (&step.to, &other.steps[index].to);
        let a0 = speed::acceleration(s1, ride, f1, v, t - h, &m1)[0]
            - speed::acceleration(s0, ride, f0, v, t - h, &m0)[0];
        let predicted = pace.speed_m_s;
        let base = speed::acceleration(s0, ride, e0, predicted, t, &m0);
        let there = speed::acceleration(s1, ride, e1, predicted, t, &m1);
        let a1 = there[0] - base[0];
        let (felt0, felt1) = (course.felt(index), other.felt(index));
        let base = speed::acceleration(s0, ride, &felt0, predicted, t, &m0);
        let there = speed::acceleration(s1, ride, &felt1, predicted, t, &m1);
        if h > 0.0 {
            dx[0] = record.phi_speed[index] * dx[0] + 0.5 * h * (a0 + a1);
        }
        for r in step.readings.clone() {
            let reading = &course.readings[r];
            let spec = &ride.sensors[reading.sensor];
            if !spec.is_longitudinal() {
                continue;
            }
            let read = |setup: &Setup, a: [f64; 2]| {
                speed::reading(setup, reading.sensor, spec, predicted, a[0] - a[1])[0]
                    - setup.sensors[reading.sensor].delay_s * a[0]
            };
            let shift = read(s1, there) - read(s0, base);
            let row = &record.slow_row[r * n..(r + 1) * n];
            let gain = &record.slow_gain[r * n..(r + 1) * n];
            let de = -(dot(row, &dx) + shift);
            change.readings.push((r, de));
            for (x, k) in dx.iter_mut().zip(gain) {
                *x += k * de;
            }
        }
        change.ends.push([[start, a0], [dx[0], a1]]);
        v = pace.speed_m_s;
    }
    debug_assert_eq!(biases.len(), ride.sensors.len());
    change
}

/// As [`change`], with the pass that was recorded.
pub fn of_pass(
    ride: &Ride,
    course: &Course,
    base: &Plant,
    changed: &Plant,
    model: &Model,
    pass: &Pass,
) -> Vec<f64> {
    match &pass.record {
        Some(record) => change(ride, course, base, changed, model, record),
        None => vec![0.0; course.readings.len()],
    }
}
