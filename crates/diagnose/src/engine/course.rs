//! A ride cut into steps between its events, with the inputs at both ends of each step.
//!
//! Readings are never resampled: a sensor that is late moves the event at which it is compared.

use super::ride::Ride;
use super::setup::Setup;
use twinhub_ident::{Hold, Signal};
use twinhub_mechanism::InputModel;

/// No step is longer.
const LONGEST_STEP_S: f64 = 0.02;
/// Events closer together than this are one.
const SAME_TIME_S: f64 = 1e-7;
/// A prescribed speed is differentiated over twice this.
const SLOPE_S: f64 = 0.25;
/// Drives of one ride at most.
pub const MOST_DRIVES: usize = 4;

/// Inputs at one end of a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ends {
    pub drive: [f64; MOST_DRIVES],
    pub brake_nm: f64,
    pub traction_nm: f64,
    /// Prescribed speed and its slope; not a number where the speed is predicted.
    pub speed_m_s: f64,
    pub accel_m_s2: f64,
    pub crank_rad: f64,
    pub wheel_rad: f64,
    pub trunk_rad: f64,
}

#[derive(Clone, Debug)]
pub struct Step {
    /// End of the step.
    pub t_s: f64,
    pub dt_s: f64,
    pub from: Ends,
    pub to: Ends,
    pub readings: std::ops::Range<usize>,
    /// The first of its window.
    pub fresh: bool,
}

#[derive(Clone, Copy, Debug)]
pub struct Reading {
    pub sensor: usize,
    /// Time stamp of the recorder.
    pub t_s: f64,
    pub value: f64,
}

/// All steps of a ride.
#[derive(Clone, Debug)]
pub struct Course {
    pub steps: Vec<Step>,
    pub readings: Vec<Reading>,
}

/// The inputs as they truly act.
struct Truth {
    drives: Vec<Signal>,
    brake: Option<Signal>,
    traction: Option<Signal>,
    speed: Option<Signal>,
}

impl Truth {
    fn new(ride: &Ride, setup: &Setup) -> Self {
        let both =
            |signal: &Option<Signal>, model: &InputModel| signal.as_ref().map(|s| shaped(s, model));
        Self {
            drives: ride
                .drives
                .iter()
                .zip(&setup.drives)
                .map(|(d, m)| shaped(&d.signal, m))
                .collect(),
            brake: both(&ride.front_brake, &setup.brake),
            traction: both(&ride.rear_traction, &setup.traction),
            speed: both(&ride.speed, &setup.speed),
        }
    }

    fn ends(&self, ride: &Ride, from_s: f64, dt_s: f64) -> (Ends, Ends) {
        // Past the sample that stands there, however its time was rounded.
        let from_s = from_s + 2.0 * SAME_TIME_S;
        let mut pair = [Ends {
            drive: [0.0; MOST_DRIVES],
            brake_nm: 0.0,
            traction_nm: 0.0,
            speed_m_s: f64::NAN,
            accel_m_s2: 0.0,
            crank_rad: f64::NAN,
            wheel_rad: f64::NAN,
            trunk_rad: f64::NAN,
        }; 2];
        let both = |signal: &Signal| {
            let (value, slope) = signal.at(from_s);
            [value, value + slope * dt_s]
        };
        for (i, (signal, drive)) in self.drives.iter().zip(&ride.drives).enumerate() {
            let (value, slope) = signal.at(from_s);
            let value = value + drive.lag_s * slope;
            pair[0].drive[i] = value;
            pair[1].drive[i] = value + slope * dt_s;
        }
        let mut put = |signal: &Option<Signal>, set: fn(&mut Ends, f64)| {
            if let Some(signal) = signal {
                let [a, b] = both(signal);
                set(&mut pair[0], a);
                set(&mut pair[1], b);
            }
        };
        put(&self.brake, |e, x| e.brake_nm = x);
        put(&self.traction, |e, x| e.traction_nm = x);
        put(&self.speed, |e, x| e.speed_m_s = x);
        put(&ride.crank, |e, x| e.crank_rad = x);
        put(&ride.wheel, |e, x| e.wheel_rad = x);
        put(&ride.trunk, |e, x| e.trunk_rad = x);
        if let Some(speed) = &self.speed {
            let middle = from_s + 0.5 * dt_s;
            let times = speed.times_s();
            let (first, last) = (times[0], times[times.len() - 1]);
            let (a, b) = ((middle - SLOPE_S).max(first), (middle + SLOPE_S).min(last));
            if b > a {
                let slope = (speed.at(b).0 - speed.at(a).0) / (b - a);
                pair[0].accel_m_s2 = slope;
                pair[1].accel_m_s2 = slope;
            }
        }
        (pair[0], pair[1])
    }
}

/// An input as it truly acts.
fn shaped(signal: &Signal, model: &InputModel) -> Signal {
    if *model == InputModel::IDEAL {
        return signal.clone();
    }
    let limit = model.limit;
    let values: Vec<(f64, f64)> = signal
        .times_s()
        .iter()
        .map(|&t| {
            let raw = signal.at(t).0;
            let value = if raw == 0.0 {
                model.idle_drag
            } else {
                model.gain * raw
            };
            (
                t + model.delay_s,
                (value + model.offset).clamp(-limit, limit),
            )
        })
        .collect();
    let lagged = if model.lag_s > 0.0 {
        lagged(&values, model.lag_s, signal.hold())
    } else {
        values
    };
    Signal::new(lagged, signal.hold()).unwrap_or_else(|_| signal.clone())
}

/// First-order lag, exact for the hold between the samples. A held signal becomes the mean of the
/// lagged one over each interval.
fn lagged(values: &[(f64, f64)], tau: f64, hold: Hold) -> Vec<(f64, f64)> {
    let mut y = values[0].1;
    let mut out = Vec::with_capacity(values.len());
    match hold {
        Hold::Linear => {
            out.push((values[0].0, y));
            for pair in values.windows(2) {
                let (h, u0, u1) = (pair[1].0 - pair[0].0, pair[0].1, pair[1].1);
                let slope = (u1 - u0) / h;
                y = u1 - tau * slope + (y - u0 + tau * slope) * libm::exp(-h / tau);
                out.push((pair[1].0, y));
            }
        }
        Hold::Zero => {
            let mut length = 0.0;
            for (k, (t, u)) in values.iter().enumerate() {
                length = values.get(k + 1).map_or(length, |next| next.0 - t);
                if length <= 0.0 {
                    out.push((*t, *u));
                    continue;
                }
                let decay = libm::exp(-length / tau);
                out.push((*t, u + (y - u) * tau / length * (1.0 - decay)));
                y = u + (y - u) * decay;
            }
        }
    }
    out
}

impl Course {
    pub fn new(ride: &Ride, setup: &Setup) -> Self {
        let truth = Truth::new(ride, setup);
        let mut course = Self {
            steps: vec![],
            readings: vec![],
        };
        for window in &ride.windows {
            course.add_window(ride, setup, &truth, *window);
        }
        course
    }

    /// Inputs as a sensor meets them at the end of a step: one that is held has its new value there.
    pub fn met(&self, index: usize) -> &Ends {
        match self.steps.get(index + 1) {
            Some(next) if !next.fresh => &next.from,
            _ => &self.steps[index].to,
        }
    }

    /// The same events with other inputs.
    pub fn refilled(&self, ride: &Ride, setup: &Setup) -> Self {
        let truth = Truth::new(ride, setup);
        let mut course = self.clone();
        for step in &mut course.steps {
            (step.from, step.to) = truth.ends(ride, step.t_s - step.dt_s, step.dt_s);
        }
        course
    }

    fn add_window(&mut self, ride: &Ride, setup: &Setup, truth: &Truth, window: [f64; 2]) {
        let inside = |t: f64| t >= window[0] - SAME_TIME_S && t < window[1] - SAME_TIME_S;
        let mut pending: Vec<(f64, usize, f64, f64)> = vec![];
        for (index, sensor) in ride.sensors.iter().enumerate() {
            let late = sensor.delay_s + setup.sensors[index].delay_s;
            let used = sensor.samples.iter().filter(|(t, _)| inside(*t));
            pending.extend(used.map(|&(t, y)| (t - late, index, t, y)));
        }
        pending.sort_by(|p, q| p.0.total_cmp(&q.0).then(p.1.cmp(&q.1)));
        let (Some(first), Some(last)) = (pending.first(), pending.last()) else {
            return;
        };
        let (first_s, last_s) = (first.0, last.0);
        let mut times: Vec<f64> = pending.iter().map(|p| p.0).collect();
        let signals = truth.drives.iter().chain(&truth.speed);
        for signal in signals.chain(&truth.brake).chain(&truth.traction) {
            let all = signal.times_s();
            let from = all.partition_point(|t| *t <= first_s);
            let to = all.partition_point(|t| *t < last_s);
            times.extend(&all[from..to.max(from)]);
        }
        times.sort_by(f64::total_cmp);
        let mut pending = pending.into_iter().peekable();
        let mut before: Option<f64> = None;
        for t in times {
            let from = before.unwrap_or(t);
            if before.is_some() && t - from <= SAME_TIME_S {
                continue;
            }
            let parts = libm::ceil((t - from) / LONGEST_STEP_S - 1e-6).max(1.0);
            for k in 1..=parts as usize {
                let (a, b) = (
                    from + (t - from) * (k - 1) as f64 / parts,
                    from + (t - from) * k as f64 / parts,
                );
                let start = self.readings.len();
                while let Some((_, sensor, stamp, value)) =
                    pending.next_if(|p| p.0 <= b + SAME_TIME_S)
                {
                    self.readings.push(Reading {
                        sensor,
                        t_s: stamp,
                        value,
                    });
                }
                let (ends_from, ends_to) = truth.ends(ride, a, b - a);
                self.steps.push(Step {
                    t_s: b,
                    dt_s: b - a,
                    from: ends_from,
                    to: ends_to,
                    readings: start..self.readings.len(),
                    fresh: before.is_none(),
                });
            }
            before = Some(t);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A lag that vanishes changes nothing, whatever the hold; a step answers exponentially.
    #[test]
    fn lag() {
        let values: Vec<(f64, f64)> = (0..200)
            .map(|k| (k as f64 * 0.01, if k < 50 { 0.0 } else { 2.0 }))
            .collect();
        for hold in [Hold::Zero, Hold::Linear] {
            let same = lagged(&values, 1e-9, hold);
            for (a, b) in same.iter().zip(&values) {
                assert!((a.1 - b.1).abs() < 1e-5, "{a:?} {b:?}");
            }
            let out = lagged(&values, 0.1, hold);
            let expected = 2.0 * (1.0 - libm::exp(-5.0));
            assert!(
                (out[100].1 - expected).abs() < 0.01,
                "{hold:?} {}",
                out[100].1
            );
        }
    }
}
