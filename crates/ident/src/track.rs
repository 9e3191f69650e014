//! A ride cut into exact steps between its events: everything that does not depend on the noise
//! levels, computed once.

use crate::equations::{Equations, Layout, OutputRow};
use crate::ride::{Ride, Window};
use crate::signal::{Hold, Signal};
use crate::transition::{exponential, noise, response};
use twinhub_linear::MotorPair;

/// No step is longer: the speed may vary within it.
const LONGEST_STEP_S: f64 = 0.02;
/// Events closer together than this are one.
const SAME_TIME_S: f64 = 1e-7;

/// Sources of process noise: white roll torque and white steer torque, Nm √s, whose levels are
/// estimated.
pub const PROCESS_SOURCES: usize = 2;

/// One value that the predictor meets, in its order.
#[derive(Clone, Debug)]
pub struct Reading {
    pub sensor: usize,
    /// Time stamp of the recorder.
    pub t_s: f64,
    pub value: f64,
    pub row: Vec<f64>,
    /// Part of the inputs.
    pub feed: f64,
}

/// From one event to the next.
#[derive(Clone, Debug)]
pub struct Step {
    /// End of the step, true time.
    pub t_s: f64,
    pub dt_s: f64,
    /// Dynamic rows of the transition matrix, with the laws closed.
    pub phi: Vec<f64>,
    /// Response to the measured inputs.
    pub drive: Vec<f64>,
    /// Covariance per squared level of each process source, dynamic block.
    pub noise: [Vec<f64>; PROCESS_SOURCES],
    /// Covariance of the inputs' known noise.
    pub known_noise: Option<Vec<f64>>,
    /// Present when a law has a limit or a delay.
    pub open: Option<OpenStep>,
    /// Readings at the end of the step.
    pub readings: std::ops::Range<usize>,
}

/// The step without the laws, and each law's torque by itself.
#[derive(Clone, Debug)]
pub struct OpenStep {
    pub phi: Vec<f64>,
    pub drive: Vec<f64>,
    pub laws: Vec<LawStep>,
}

#[derive(Clone, Debug)]
pub struct LawStep {
    /// Torque per state: gain times row.
    pub row: Vec<f64>,
    /// Response to a torque of 1 Nm held over the step.
    pub push: Vec<f64>,
    pub limit_nm: f64,
    pub delay_s: f64,
}

/// One window of the ride.
#[derive(Clone, Debug)]
pub struct Stretch {
    pub window: Window,
    pub steps: std::ops::Range<usize>,
}

/// A ride, ready for the predictor.
#[derive(Clone, Debug)]
pub struct Track {
    pub layout: Layout,
    pub prior_variance: Vec<f64>,
    pub steps: Vec<Step>,
    pub readings: Vec<Reading>,
    pub stretches: Vec<Stretch>,
    /// Variance that quantisation adds, by sensor.
    pub quantum_variance: Vec<f64>,
    pub clock_jitter_sd_s: f64,
}

/// Why a ride cannot be predicted.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum TrackError {
    #[error("window [{start_s}, {end_s}) s holds no reading of any output")]
    EmptyWindow { start_s: f64, end_s: f64 },
    #[error("the model has no finite transition at {t_s} s (speed {speed_m_s} m/s)")]
    NotFinite { t_s: f64, speed_m_s: f64 },
}

impl Track {
    pub fn new(equations: &Equations, ride: &Ride) -> Result<Self, TrackError> {
        let layout = Layout::new(ride);
        let mut track = Self {
            prior_variance: layout.prior_variance(ride),
            layout,
            steps: vec![],
            readings: vec![],
            stretches: vec![],
            quantum_variance: ride
                .sensors
                .iter()
                .map(|s| s.quantum * s.quantum / 12.0)
                .collect(),
            clock_jitter_sd_s: ride.clock_jitter_sd_s,
        };
        for window in &ride.windows {
            track.add_window(equations, ride, *window)?;
        }
        Ok(track)
    }

    fn add_window(
        &mut self,
        equations: &Equations,
        ride: &Ride,
        window: Window,
    ) -> Result<(), TrackError> {
        // The window is one of recorded time; a delayed reading tells of earlier truth.
        let inside = |t: f64| t >= window.start_s - SAME_TIME_S && t < window.end_s - SAME_TIME_S;
        let mut pending: Vec<(f64, usize, f64, f64)> = vec![];
        for (index, sensor) in ride.sensors.iter().enumerate() {
            let used = sensor.samples.iter().filter(|(t, _)| inside(*t));
            pending.extend(used.map(|&(t, y)| (t - sensor.delay_s, index, t, y)));
        }
        pending.sort_by(|p, q| p.0.total_cmp(&q.0).then(p.1.cmp(&q.1)));
        let (Some(first), Some(last)) = (pending.first(), pending.last()) else {
            return Err(TrackError::EmptyWindow {
                start_s: window.start_s,
                end_s: window.end_s,
            });
        };
        let times = event_times(ride, first.0, last.0, &pending);
        let from = self.steps.len();
        let mut pending = pending.into_iter().peekable();
        let mut before = times[0];
        for t_s in times {
            let mut step = self.step(equations, ride, before, t_s)?;
            let first_reading = self.readings.len();
            let speed = ride.speed.at(t_s).0;
            let mut matrices = None;
            while let Some((_, sensor, stamp, value)) =
                pending.next_if(|p| p.0 <= t_s + SAME_TIME_S)
            {
                let matrices = matrices.get_or_insert_with(|| {
                    equations.matrices(ride, &self.layout, speed, pair_at(ride, t_s), true)
                });
                let OutputRow { state, input } =
                    equations.reading(ride, &self.layout, matrices, sensor, speed);
                let feed = input
                    .iter()
                    .zip(&ride.drives)
                    .map(|(d, drive)| d * drive_at(&drive.signal, drive.lag_s, t_s).0);
                self.readings.push(Reading {
                    sensor,
                    t_s: stamp,
                    value,
                    row: state,
                    feed: feed.sum(),
                });
            }
            step.readings = first_reading..self.readings.len();
            self.steps.push(step);
            before = t_s;
        }
        self.stretches.push(Stretch {
            window,
            steps: from..self.steps.len(),
        });
        Ok(())
    }

    fn step(
        &self,
        equations: &Equations,
        ride: &Ride,
        from_s: f64,
        to_s: f64,
    ) -> Result<Step, TrackError> {
        let (n, nd) = (self.layout.states, self.layout.dynamic);
        let dt_s = to_s - from_s;
        let middle = 0.5 * (from_s + to_s);
        let speed_m_s = ride.speed.at(middle).0;
        let pair = pair_at(ride, middle);
        let closed = equations.matrices(ride, &self.layout, speed_m_s, pair, true);
        let inputs: Vec<(f64, f64)> = ride
            .drives
            .iter()
            .map(|d| drive_at(&d.signal, d.lag_s, from_s))
            .collect();
        let along = |columns: &[Vec<f64>]| {
            let mut b = [vec![0.0; n], vec![0.0; n]];
            for (column, (value, slope)) in columns.iter().zip(&inputs) {
                for i in 0..n {
                    b[0][i] += column[i] * value;
                    b[1][i] += column[i] * slope;
                }
            }
            b
        };
        let top = |mut full: Vec<f64>| {
            full.truncate(nd * n);
            full
        };
        let block = |full: Vec<f64>| -> Vec<f64> {
            (0..nd)
                .flat_map(|i| full[i * n..i * n + nd].to_vec())
                .collect()
        };
        let b = along(&closed.b);
        let mut drive = response(&closed.a, n, &b[0], &b[1], dt_s);
        drive.truncate(nd);
        let known = ride
            .drives
            .iter()
            .zip(&closed.b)
            .filter(|(d, _)| d.noise_sd > 0.0);
        let known_noise = known.fold(None::<Vec<f64>>, |sum, (d, column)| {
            let intensity = d.noise_sd * d.noise_sd * sample_interval_s(&d.signal);
            let q = block(noise(&closed.a, n, column, dt_s));
            Some(match sum {
                Some(sum) => sum.iter().zip(&q).map(|(s, x)| s + intensity * x).collect(),
                None => q.iter().map(|x| intensity * x).collect(),
            })
        });
        let step = Step {
            t_s: to_s,
            dt_s,
            noise: std::array::from_fn(|axis| {
                block(noise(&closed.a, n, &closed.torque[axis], dt_s))
            }),
            known_noise,
            open: ride
                .laws
                .iter()
                .any(|l| l.delay_s > 0.0 || l.limit_nm.is_finite())
                .then(|| {
                    let open = equations.matrices(ride, &self.layout, speed_m_s, pair, false);
                    let b = along(&open.b);
                    let mut drive = response(&open.a, n, &b[0], &b[1], dt_s);
                    drive.truncate(nd);
                    let zero = vec![0.0; n];
                    let laws = ride.laws.iter().map(|law| {
                        let column: Vec<f64> = open.torque[0]
                            .iter()
                            .zip(&open.torque[1])
                            .map(|(r, s)| law.arm[0] * r + law.arm[1] * s)
                            .collect();
                        let mut push = response(&open.a, n, &column, &zero, dt_s);
                        push.truncate(nd);
                        let gain = law.gain.at(speed_m_s);
                        let row = equations
                            .law_row(&self.layout, law.of, speed_m_s)
                            .iter()
                            .map(|x| gain * x)
                            .collect();
                        LawStep {
                            row,
                            push,
                            limit_nm: law.limit_nm,
                            delay_s: law.delay_s,
                        }
                    });
                    let laws = laws.collect();
                    OpenStep {
                        phi: top(exponential(&open.a, n, dt_s)),
                        drive,
                        laws,
                    }
                }),
            phi: top(exponential(&closed.a, n, dt_s)),
            drive,
            readings: 0..0,
        };
        if step.phi.iter().chain(&step.drive).any(|x| !x.is_finite()) {
            return Err(TrackError::NotFinite {
                t_s: to_s,
                speed_m_s,
            });
        }
        Ok(step)
    }
}

/// All times at which something is read or an input bends, none further apart than the longest step.
fn event_times(
    ride: &Ride,
    from_s: f64,
    to_s: f64,
    pending: &[(f64, usize, f64, f64)],
) -> Vec<f64> {
    let mut times: Vec<f64> = pending.iter().map(|p| p.0).collect();
    let signals = ride.drives.iter().map(|d| &d.signal).chain([&ride.speed]);
    for signal in signals.chain(&ride.front_brake).chain(&ride.rear_traction) {
        times.extend(
            signal
                .times_s()
                .iter()
                .filter(|t| **t > from_s && **t < to_s),
        );
    }
    times.sort_by(f64::total_cmp);
    let mut merged = vec![times[0]];
    for t in times {
        let last = merged[merged.len() - 1];
        if t - last <= SAME_TIME_S {
            continue;
        }
        let parts = libm::ceil((t - last) / LONGEST_STEP_S - 1e-6).max(1.0);
        merged.extend((1..parts as usize).map(|k| last + (t - last) * k as f64 / parts));
        merged.push(t);
    }
    merged
}

/// Value and slope of an input with the recorder's filter undone: u = y + tau y'.
fn drive_at(signal: &Signal, lag_s: f64, t_s: f64) -> (f64, f64) {
    let (value, slope) = signal.at(t_s);
    (value + lag_s * slope, slope)
}

fn pair_at(ride: &Ride, t_s: f64) -> MotorPair {
    let at = |signal: &Option<Signal>| signal.as_ref().map_or(0.0, |s| s.at(t_s).0);
    MotorPair {
        front_brake_nm: at(&ride.front_brake),
        rear_traction_nm: at(&ride.rear_traction),
    }
}

fn sample_interval_s(signal: &Signal) -> f64 {
    let times = signal.times_s();
    match times {
        [first, .., last] => (last - first) / (times.len() - 1) as f64,
        _ => 0.0,
    }
}

/// Whether a signal may have a first-order filter undone.
pub fn can_undo_lag(signal: &Signal) -> bool {
    signal.hold() == Hold::Linear
}
