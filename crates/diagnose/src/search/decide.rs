//! Decisions on rides that were not used for fitting: gains by block.

use super::phases;
use super::rides::{Passes, Rides};
use super::thresholds::THRESHOLDS;
use crate::engine::Model;
use std::collections::BTreeMap;

/// Minus log likelihood by ride and block.
#[derive(Clone, Debug)]
pub struct Blocks(BTreeMap<(usize, i64), f64>);

impl Blocks {
    /// Number of the block of each reading, from its ride and time.
    pub fn numbers(stamps: &[(usize, f64)]) -> Vec<usize> {
        let mut ids: BTreeMap<(usize, i64), usize> = BTreeMap::new();
        stamps
            .iter()
            .map(|(ride, t)| {
                let key = (*ride, libm::floor(t / THRESHOLDS.block_s) as i64);
                let next = ids.len();
                *ids.entry(key).or_insert(next)
            })
            .collect()
    }

    /// Predicts rides with a model, which finds the phases of each.
    pub fn new(rides: &Rides, model: &Model) -> Option<Self> {
        let passes = Passes::run(rides, &phases::found(rides, model)?, false)?;
        let stamps = passes.stamps(rides);
        let mut sums = BTreeMap::new();
        let terms = passes
            .passes
            .iter()
            .flat_map(|p| p.error.iter().zip(&p.variance));
        for ((ride, t), (e, s)) in stamps.iter().zip(terms) {
            let key = (*ride, libm::floor(t / THRESHOLDS.block_s) as i64);
            *sums.entry(key).or_insert(0.0) += 0.5 * (e * e / s + libm::log(*s));
        }
        sums.values()
            .all(|x: &f64| x.is_finite())
            .then_some(Self(sums))
    }
}

/// What one model gains over another.
#[derive(Clone, Copy, Debug, Default)]
pub struct Gain {
    pub nats: f64,
    /// Mean over blocks in standard errors.
    pub z: f64,
    pub every_ride_gains: bool,
    /// Standard error of the sum.
    pub error_nats: f64,
    /// Share of the blocks that gain.
    pub share_of_blocks: f64,
}

impl Gain {
    /// Of `to` over `from`.
    pub fn new(from: &Blocks, to: &Blocks) -> Self {
        let mut by_ride: BTreeMap<usize, f64> = BTreeMap::new();
        let gains: Vec<f64> = from
            .0
            .iter()
            .filter_map(|(key, value)| {
                let gain = value - to.0.get(key)?;
                *by_ride.entry(key.0).or_insert(0.0) += gain;
                Some(gain)
            })
            .collect();
        let count = gains.len() as f64;
        let nats: f64 = gains.iter().sum();
        if gains.len() < 3 {
            return Self {
                nats,
                ..Self::default()
            };
        }
        let mean = nats / count;
        let spread = gains.iter().map(|g| (g - mean) * (g - mean)).sum::<f64>() / (count - 1.0);
        let error = (spread / count).sqrt();
        Self {
            nats,
            z: if error > 0.0 { mean / error } else { 0.0 },
            every_ride_gains: by_ride.values().all(|g| *g > 0.0),
            error_nats: error * count,
            share_of_blocks: gains.iter().filter(|g| **g > 0.0).count() as f64 / count,
        }
    }

    /// Of `to` over `from`, if there are held-out rides.
    pub fn between(from: Option<&Blocks>, to: Option<&Blocks>) -> Option<Self> {
        Some(Self::new(from?, to?))
    }

    /// Whether the held-out rides decide for it.
    pub fn is_decisive(&self) -> bool {
        let t = &*THRESHOLDS;
        (self.nats > t.held_out_nats && self.z > t.held_out_z)
            || (self.nats > t.sparse_nats && self.every_ride_gains)
    }
}
