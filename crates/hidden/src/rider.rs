//! What: the rider, or the machine in its place, who keeps the bicycle up: delayed feedback of
//! angles, rates and heading, plus what it asks for besides.
//!
//! Equation: u_k = -K [x_k, T, T', u_(k-1) .. u_(k-d)], every 20 ms, in effect d steps later; K from
//! the discrete Riccati equation for the declared bicycle, iterated until it stands.
//!
//! Source: linear quadratic regulator (for instance Anderson and Moore, "Optimal control", 1990). That
//! a rider is like this is a guess; only that the torque is measured matters here.
//!
//! Assumes and ignores: the rider knows the declared bicycle, not the true one.
//!
//! Valid for: 2 to 9 m/s.
//!
//! Checked by: `tests`, the closed loop is stable at every speed of the table.

use crate::bicycle::Bicycle;
use crate::motion::Motion;
use crate::state::*;
use crate::truth::Truth;
use nalgebra::{DMatrix, DVector};
use std::sync::OnceLock;

/// Period of the rider's decisions.
pub const PERIOD_S: f64 = 0.02;
/// Longest delay, in periods.
pub const MOST_DELAY: usize = 4;
const SEEN: [usize; 7] = [ROLL, STEER, ROLL_RATE, STEER_RATE, YAW, TORQUE, TORQUE_RATE];
const SLOWEST_M_S: f64 = 2.0;
const SPEED_STEP_M_S: f64 = 0.5;
const SPEEDS: usize = 15;
/// What the rider finds as bad as each other: angles and rates, and torque.
const TOLERATED: [f64; 5] = [0.1, 0.15, 0.4, 1.0, 0.35];
const TOLERATED_NM: f64 = 2.5;

/// A rider with a delay of so many periods.
#[derive(Clone, Debug)]
pub struct Rider {
    delay: usize,
    /// Asked, not yet done; the oldest first.
    queue: Vec<f64>,
}

impl Rider {
    /// A rider whose delay is `delay` periods, 1 to `MOST_DELAY`.
    pub fn new(delay: usize) -> Self {
        let delay = delay.clamp(1, MOST_DELAY);
        Self {
            delay,
            queue: vec![0.0; delay],
        }
    }

    /// Looks at the state and gives the torque that is asked for during the coming period, on top
    /// of `wish_nm`, which the rider wants besides.
    pub fn decide(&mut self, x: &State, wish_nm: f64) -> f64 {
        let gains = gains(self.delay, x[SPEED]);
        let seen = SEEN.iter().map(|i| x[*i]).chain(self.queue.iter().copied());
        let feedback: f64 = gains.iter().zip(seen).map(|(k, x)| -k * x).sum();
        self.queue.push(feedback.clamp(-25.0, 25.0));
        self.queue.remove(0) + wish_nm
    }
}

/// Gains at a speed, between those of the table.
fn gains(delay: usize, speed_m_s: f64) -> Vec<f64> {
    static TABLES: OnceLock<Vec<Vec<DVector<f64>>>> = OnceLock::new();
    let tables = TABLES.get_or_init(|| {
        let of = |delay: usize| (0..SPEEDS).map(|k| design(delay, speed(k))).collect();
        (1..=MOST_DELAY).map(of).collect()
    });
    let at = ((speed_m_s - SLOWEST_M_S) / SPEED_STEP_M_S).clamp(0.0, SPEEDS as f64 - 1.001);
    let (k, part) = (at as usize, at.fract());
    let table = &tables[delay - 1];
    let pairs = table[k].iter().zip(table[k + 1].iter());
    pairs.map(|(a, b)| a + part * (b - a)).collect()
}

fn speed(index: usize) -> f64 {
    SLOWEST_M_S + SPEED_STEP_M_S * index as f64
}

/// State after a period and effect of the torque asked in it, delayed torques appended.
fn discrete(delay: usize, speed_m_s: f64) -> (DMatrix<f64>, DVector<f64>) {
    let motion = Motion::new(&Truth::clean(Bicycle::benchmark()));
    let drive = |asked_nm: f64| Drive {
        asked_nm,
        direction: 1.0,
        development_m: 5.0,
        ..Drive::default()
    };
    let after = |x: &State, asked_nm: f64| -> Vec<f64> {
        let mut x = *x;
        for _ in 0..10 {
            x = motion.step(&x, &drive(asked_nm), PERIOD_S / 10.0);
        }
        SEEN.iter().map(|i| x[*i]).collect()
    };
    let mut start = [0.0; STATES];
    start[SPEED] = speed_m_s;
    let n = SEEN.len() + delay;
    let mut a = DMatrix::zeros(n, n);
    for (j, index) in SEEN.iter().enumerate() {
        // The lateral equations are linear: a unit step gives the column.
        let mut x = start;
        x[*index] = 1.0;
        for (i, value) in after(&x, 0.0).iter().enumerate() {
            a[(i, j)] = *value;
        }
    }
    for (i, value) in after(&start, 1.0).iter().enumerate() {
        a[(i, SEEN.len())] = *value;
    }
    for k in 1..delay {
        a[(SEEN.len() + k - 1, SEEN.len() + k)] = 1.0;
    }
    let mut b = DVector::zeros(n);
    b[n - 1] = 1.0;
    (a, b)
}

fn design(delay: usize, speed_m_s: f64) -> DVector<f64> {
    let (a, b) = discrete(delay, speed_m_s);
    let n = a.nrows();
    let mut q = DMatrix::zeros(n, n);
    for (i, tolerated) in TOLERATED.iter().enumerate() {
        q[(i, i)] = 1.0 / (tolerated * tolerated);
    }
    let r = 1.0 / (TOLERATED_NM * TOLERATED_NM);
    let mut p = q.clone();
    let mut gain = DVector::zeros(n);
    for _ in 0..4000 {
        let pb = &p * &b;
        let next_gain = (a.transpose() * &pb) / (r + b.dot(&pb));
        let closed = &a - &b * next_gain.transpose();
        p = &q + a.transpose() * &p * closed;
        p = 0.5 * (&p + p.transpose());
        let change = (&next_gain - &gain).norm();
        gain = next_gain;
        if change < 1e-10 * gain.norm() {
            break;
        }
    }
    gain
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_closed_loop_is_stable_with_every_delay() {
        for delay in 1..=MOST_DELAY {
            for k in [0, 3, 7, 14] {
                let (a, b) = discrete(delay, speed(k));
                let closed = &a - &b * design(delay, speed(k)).transpose();
                let largest = closed
                    .complex_eigenvalues()
                    .iter()
                    .map(|l| l.norm())
                    .fold(0.0, f64::max);
                assert!(
                    largest < 0.999,
                    "{delay} periods, {} m/s: {largest}",
                    speed(k)
                );
            }
        }
    }
}
