//! A ride cut into steps between its events, with the inputs at both ends of each step.
//!
//! Readings are never resampled: a sensor that is late moves the event at which it is compared.

use super::acting::Truth;
use super::ride::Ride;
use super::setup::Setup;

/// No step is longer.
const LONGEST_STEP_S: f64 = 0.02;
/// Events closer together than this are one.
pub(super) const SAME_TIME_S: f64 = 1e-7;
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

/// Torques at the end of a step as an accelerometer feels them: where they step and the clock errs, the
/// mean of before and after, and half of the difference.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Felt {
    pub brake_nm: f64,
    pub brake_half_nm: f64,
    pub traction_nm: f64,
    pub traction_half_nm: f64,
}

#[derive(Clone, Debug)]
pub struct Step {
    /// End of the step.
    pub t_s: f64,
    pub dt_s: f64,
    pub from: Ends,
    pub to: Ends,
    pub felt: Felt,
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

    /// Inputs as an accelerometer feels them at the end of a step.
    pub fn felt(&self, index: usize) -> Ends {
        let felt = &self.steps[index].felt;
        Ends {
            brake_nm: felt.brake_nm,
            traction_nm: felt.traction_nm,
            ..*self.met(index)
        }
    }

    /// The same events with other inputs.
    pub fn refilled(&self, ride: &Ride, setup: &Setup) -> Self {
        let truth = Truth::new(ride, setup);
        let mut course = self.clone();
        for step in &mut course.steps {
            (step.from, step.to) = truth.ends(ride, step.t_s - step.dt_s, step.dt_s);
            step.felt = truth.felt(step.t_s, ride.clock_jitter_sd_s);
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
        let torques = [&truth.brake, &truth.traction];
        let torques = torques.into_iter().flatten().map(|acting| &acting.mean);
        for signal in truth.drives.iter().chain(&truth.speed).chain(torques) {
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
                    felt: truth.felt(b, ride.clock_jitter_sd_s),
                    readings: start..self.readings.len(),
                    fresh: before.is_none(),
                });
            }
            before = Some(t);
        }
    }
}
