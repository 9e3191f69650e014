//! What: riders designed for a bicycle: gains over speed that keep it up, both without and with
//! the motor pair, with one and the same rider.
//!
//! Equation: at each speed the gains minimise the largest growth rate of the closed loop over the
//! given motor pairs (Nelder and Mead's simplex from fixed starts, the neighbour's gains among
//! them). The growth rate is the exact one of `closed_loop`.
//!
//! Source: Nelder and Mead (1965), The Computer Journal 7(4), 308-313; the criterion is ours: the
//! margin that the delay leaves.
//!
//! Assumes and ignores: small motions; the rider knows neither when the pair acts nor how much.
//!
//! Valid for: as `closed_loop`. Where no gain keeps the bicycle up, the best growth is positive and
//! is said so.
//!
//! Checked by: `rider/tests`: shipped riders are what this design gives, and stay up.

use super::closed_loop::{ClosedLoop, StabilityAt};
use super::{
    AngleGains, AngleParameters, ChannelKind, LateralBicycle, LinearChannel, SteerAngleParameters,
    SteerTorqueParameters, TorqueGains,
};
use crate::multibody::{Multibody, MultibodyError};

/// How the rider takes the handlebar.
#[derive(Clone, Debug, PartialEq)]
pub enum Hands {
    /// Torque: roll, roll rate; and steer and steer rate if asked for.
    Torque {
        /// The channel; its gains are replaced.
        channel: SteerTorqueParameters,
        /// The rider feels steer angle and rate too.
        feels_steer: bool,
    },
    /// Angle, held by arms of given stiffness.
    Angle {
        /// The channel; its gains are replaced.
        channel: SteerAngleParameters,
    },
}

/// What the rider has to do.
#[derive(Clone, Debug, PartialEq)]
pub struct Goal {
    /// How the rider takes the handlebar.
    pub hands: Hands,
    /// The rows of the gain table, speeds rising.
    pub at: Vec<Situation>,
}

/// What a row of the gain table has to cope with.
#[derive(Clone, Debug, PartialEq)]
pub struct Situation {
    /// Speed, m/s.
    pub speed_m_s: f64,
    /// Pairs that the rider has to ride with, Nm.
    pub pairs_nm: Vec<f64>,
    /// A device on the handlebar that acts beside the rider.
    pub device: Option<LinearChannel>,
}

impl Goal {
    /// The same pairs at every speed, no device.
    pub fn everywhere(hands: Hands, speeds_m_s: &[f64], pairs_nm: &[f64]) -> Self {
        let situation = |speed_m_s: &f64| Situation {
            speed_m_s: *speed_m_s,
            pairs_nm: pairs_nm.to_vec(),
            device: None,
        };
        Self {
            hands,
            at: speeds_m_s.iter().map(situation).collect(),
        }
    }
}

impl Situation {
    /// The rider's channel, and the device.
    fn channels(&self, rider: LinearChannel) -> Vec<LinearChannel> {
        core::iter::once(rider).chain(self.device).collect()
    }
}

/// A designed rider.
#[derive(Clone, Debug, PartialEq)]
pub struct Designed {
    /// The hands with their gains.
    pub hands: Hands,
    /// Growth at each speed of the table under each pair.
    pub stability: Vec<StabilityAt>,
}

/// Rounds of the simplex at most.
const ROUNDS: usize = 400;

impl Hands {
    /// Number of gains at one speed.
    fn gains(&self) -> usize {
        match self {
            Self::Torque { feels_steer, .. } => {
                if *feels_steer {
                    4
                } else {
                    2
                }
            }
            Self::Angle { .. } => 2,
        }
    }

    /// Starts of the search and the size of the first simplex.
    fn starts(&self) -> (Vec<Vec<f64>>, Vec<f64>) {
        match self {
            Self::Torque {
                feels_steer: false, ..
            } => (
                vec![vec![18.0, 0.0], vec![8.0, 1.0], vec![-2.0, 0.0]],
                vec![4.0, 1.0],
            ),
            Self::Torque { .. } => (
                vec![
                    vec![18.0, 0.0, 0.0, 0.0],
                    vec![-10.0, -2.0, 10.0, 1.0],
                    vec![-20.0, -5.0, 5.0, 1.0],
                ],
                vec![4.0, 1.0, 4.0, 0.5],
            ),
            Self::Angle { .. } => (
                vec![vec![-1.0, -0.2], vec![-2.5, -0.5], vec![-4.0, -0.8]],
                vec![0.5, 0.1],
            ),
        }
    }

    fn row(speed_m_s: f64, k: &[f64]) -> TorqueGains {
        TorqueGains {
            speed_m_s,
            roll_nm_rad: k[0],
            roll_rate_nms_rad: k[1],
            heading_nm_rad: 0.0,
            steer_nm_rad: k.get(2).copied().unwrap_or(0.0),
            steer_rate_nms_rad: k.get(3).copied().unwrap_or(0.0),
        }
    }

    /// The same hands with these gains at these speeds.
    fn with(&self, table: &[(f64, Vec<f64>)]) -> Self {
        match self {
            Self::Torque {
                channel,
                feels_steer,
            } => Self::Torque {
                channel: SteerTorqueParameters {
                    gains: table.iter().map(|(v, k)| Self::row(*v, k)).collect(),
                    ..channel.clone()
                },
                feels_steer: *feels_steer,
            },
            Self::Angle { channel } => Self::Angle {
                channel: SteerAngleParameters(AngleParameters {
                    gains: table
                        .iter()
                        .map(|(speed_m_s, k)| AngleGains {
                            speed_m_s: *speed_m_s,
                            roll_ratio: k[0],
                            roll_rate_s: k[1],
                            heading_ratio: 0.0,
                        })
                        .collect(),
                    ..channel.0.clone()
                }),
            },
        }
    }

    /// The channel about zero at one speed.
    pub fn linear(&self, speed_m_s: f64) -> LinearChannel {
        match self {
            Self::Torque { channel, .. } => channel.linear(speed_m_s),
            Self::Angle { channel } => channel.linear(speed_m_s),
        }
    }
}

/// Gains that keep the bicycle up, as far as the delay lets them.
///
/// # Errors
/// If there is no steady state at a speed and pair.
pub fn design(model: &Multibody, goal: &Goal) -> Result<Designed, MultibodyError> {
    let mut table: Vec<(f64, Vec<f64>)> = Vec::new();
    let mut bicycles = Vec::new();
    for situation in &goal.at {
        let at: Result<Vec<LateralBicycle>, _> = situation
            .pairs_nm
            .iter()
            .map(|&pair_nm| LateralBicycle::new(model, situation.speed_m_s, pair_nm))
            .collect();
        bicycles.push(at?);
    }
    // From the highest speed down, where bicycles are easiest to ride.
    for (i, situation) in goal.at.iter().enumerate().rev() {
        let speed_m_s = situation.speed_m_s;
        let growth = |k: &[f64]| {
            let channel = goal
                .hands
                .with(&[(speed_m_s, k.to_vec())])
                .linear(speed_m_s);
            bicycles[i]
                .iter()
                .map(|b| ClosedLoop::new(b, &situation.channels(channel)).growth_of_finite_per_s())
                .fold(f64::NEG_INFINITY, f64::max)
        };
        let (mut starts, size) = goal.hands.starts();
        starts.extend(table.last().map(|(_, k)| k.clone()));
        let best = starts
            .iter()
            .map(|start| simplex(&growth, start, &size))
            .min_by(|a, b| a.1.total_cmp(&b.1))
            .map_or_else(|| vec![0.0; goal.hands.gains()], |(k, _)| k);
        // Readable numbers: what a rider file shows is what was checked.
        let rounded = best.iter().map(|k| libm::round(k * 1e3) / 1e3).collect();
        table.push((speed_m_s, rounded));
    }
    table.reverse();
    let hands = goal.hands.with(&table);
    let mut stability = Vec::new();
    for (i, situation) in goal.at.iter().enumerate() {
        let speed_m_s = situation.speed_m_s;
        let channels = situation.channels(hands.linear(speed_m_s));
        for (bicycle, &pair_nm) in bicycles[i].iter().zip(&situation.pairs_nm) {
            let roots = ClosedLoop::new(bicycle, &channels).eigenvalues()?;
            let first = roots.first().copied().unwrap_or_default();
            stability.push(StabilityAt {
                speed_m_s,
                pair_nm,
                growth_per_s: first.re,
                frequency_rad_s: first.im,
            });
        }
    }
    Ok(Designed { hands, stability })
}

/// Nelder and Mead's simplex: where `f` is small, and how small; the first simplex is `start` with
/// each coordinate moved by `size` in turn.
pub fn simplex(f: &dyn Fn(&[f64]) -> f64, start: &[f64], size: &[f64]) -> (Vec<f64>, f64) {
    let n = start.len();
    let mut points: Vec<(Vec<f64>, f64)> = (0..=n)
        .map(|i| {
            let mut x = start.to_vec();
            if i > 0 {
                x[i - 1] += size[i - 1];
            }
            let value = f(&x);
            (x, value)
        })
        .collect();
    for _ in 0..ROUNDS {
        points.sort_by(|a, b| a.1.total_cmp(&b.1));
        if points[n].1 - points[0].1 < 1e-7 {
            break;
        }
        let centre: Vec<f64> = (0..n)
            .map(|k| points[..n].iter().map(|p| p.0[k]).sum::<f64>() / n as f64)
            .collect();
        let along = |points: &[(Vec<f64>, f64)], t: f64| {
            let x: Vec<f64> = (0..n)
                .map(|k| centre[k] + t * (points[n].0[k] - centre[k]))
                .collect();
            let value = f(&x);
            (x, value)
        };
        let reflected = along(&points, -1.0);
        if reflected.1 < points[0].1 {
            let further = along(&points, -2.0);
            points[n] = if further.1 < reflected.1 {
                further
            } else {
                reflected
            };
        } else if reflected.1 < points[n - 1].1 {
            points[n] = reflected;
        } else {
            let t = if reflected.1 < points[n].1 { -0.5 } else { 0.5 };
            let nearer = along(&points, t);
            if nearer.1 < points[n].1.min(reflected.1) {
                points[n] = nearer;
            } else {
                let best = points[0].0.clone();
                for p in &mut points[1..] {
                    for k in 0..n {
                        p.0[k] = best[k] + 0.5 * (p.0[k] - best[k]);
                    }
                    p.1 = f(&p.0);
                }
            }
        }
    }
    points.sort_by(|a, b| a.1.total_cmp(&b.1));
    points.swap_remove(0)
}
