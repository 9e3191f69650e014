//! What: stability over speed and torque of the motor pair.
//!
//! Equation: at each point the lateral eigenvalues about the straight steady state; growth is their
//! largest real part.
//!
//! Source: Bulsink (2017), figure 7.5, extended to a plane.
//!
//! Assumes and ignores: as in `steady`.
//!
//! Valid for: torques that the tyres carry; elsewhere there is no steady state and the point says
//! so.
//!
//! Checked by: `a_map_agrees_with_single_points` in `multibody/tests`.

use super::error::MultibodyError;
use super::model::Multibody;
use super::steady::{Course, Steady};
use nalgebra::Complex;
use std::sync::atomic::{AtomicUsize, Ordering};

/// One point of a map.
#[derive(Clone, Debug)]
pub struct MapPoint {
    /// Speed, m/s.
    pub speed_m_s: f64,
    /// Torque of the pair: front brake, Nm.
    pub torque_nm: f64,
    /// Lateral eigenvalues, 1/s; empty where there is no steady state.
    pub eigenvalues: Vec<Complex<f64>>,
}

impl MapPoint {
    /// Largest real part, 1/s: negative is stable.
    pub fn growth_rad_s(&self) -> Option<f64> {
        self.eigenvalues.iter().map(|z| z.re).reduce(f64::max)
    }
}

impl Multibody {
    /// Lateral eigenvalues about a straight steady state.
    pub fn lateral_eigenvalues(&self, steady: &Steady) -> Vec<Complex<f64>> {
        self.lateral(steady)
            .a
            .complex_eigenvalues()
            .iter()
            .copied()
            .collect()
    }

    /// One row of a map: all speeds (in order) at one torque.
    fn map_row(&self, torque_nm: f64, speeds_m_s: &[f64]) -> Vec<MapPoint> {
        let mut last: Option<Steady> = None;
        speeds_m_s
            .iter()
            .map(|&speed_m_s| {
                let found: Result<Steady, MultibodyError> =
                    self.steady_near(&Course::pair(speed_m_s, torque_nm), last.as_ref());
                last = found.ok();
                let eigenvalues = last
                    .as_ref()
                    .map_or_else(Vec::new, |s| self.lateral_eigenvalues(s));
                MapPoint {
                    speed_m_s,
                    torque_nm,
                    eigenvalues,
                }
            })
            .collect()
    }
}

/// A map: one row per torque, each with all speeds, on `threads` threads. `progress` is told after
/// each row how many are done.
pub fn map(
    model: &Multibody,
    torques_nm: &[f64],
    speeds_m_s: &[f64],
    threads: usize,
    progress: &(dyn Fn(usize) + Sync),
) -> Vec<Vec<MapPoint>> {
    let (next, done) = (AtomicUsize::new(0), AtomicUsize::new(0));
    let work = || {
        let mut rows = Vec::new();
        loop {
            let k = next.fetch_add(1, Ordering::Relaxed);
            let Some(&torque) = torques_nm.get(k) else {
                return rows;
            };
            rows.push((k, model.map_row(torque, speeds_m_s)));
            progress(done.fetch_add(1, Ordering::Relaxed) + 1);
        }
    };
    let mut rows: Vec<(usize, Vec<MapPoint>)> = std::thread::scope(|scope| {
        let handles: Vec<_> = (0..threads.max(1)).map(|_| scope.spawn(work)).collect();
        handles
            .into_iter()
            .flat_map(|h| h.join().unwrap_or_default())
            .collect()
    });
    rows.sort_by_key(|(k, _)| *k);
    rows.into_iter().map(|(_, row)| row).collect()
}
