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

    /// Largest real part of the modes that oscillate (weave, or wobble where that is worse), 1/s.
    pub fn oscillating_growth_rad_s(&self) -> Option<f64> {
        self.largest(|z| z.im != 0.0)
    }

    /// Largest real part of the modes that do not oscillate (capsize), 1/s.
    pub fn slow_growth_rad_s(&self) -> Option<f64> {
        self.largest(|z| z.im == 0.0)
    }

    fn largest(&self, which: impl Fn(&Complex<f64>) -> bool) -> Option<f64> {
        let chosen = self.eigenvalues.iter().filter(|z| which(z));
        chosen.map(|z| z.re).reduce(f64::max)
    }
}

/// Ranges of speed in which a row of a map is stable, m/s; ends between two speeds by the straight
/// line between their growths.
pub fn stable_ranges_m_s(row: &[MapPoint]) -> Vec<[f64; 2]> {
    let mut ranges: Vec<[f64; 2]> = Vec::new();
    let mut before: Option<(f64, f64)> = None;
    for point in row {
        let speed = point.speed_m_s;
        let Some(growth) = point.growth_rad_s() else {
            before = None;
            continue;
        };
        let crossing = |v: f64, g: f64| v + (speed - v) * g / (g - growth);
        match before {
            Some((v, g)) if g >= 0.0 && growth < 0.0 => ranges.push([crossing(v, g), speed]),
            None if growth < 0.0 => ranges.push([speed, speed]),
            Some((v, g)) if g < 0.0 => {
                if let Some(range) = ranges.last_mut() {
                    range[1] = if growth < 0.0 { speed } else { crossing(v, g) };
                }
            }
            _ => {}
        }
        before = Some((speed, growth));
    }
    ranges
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
/// each row how many are done, and says whether to go on: if not, rows are missing.
///
/// # Panics
/// If a row does: that is a mistake of the model's.
pub fn map(
    model: &Multibody,
    torques_nm: &[f64],
    speeds_m_s: &[f64],
    threads: usize,
    progress: &(dyn Fn(usize) -> bool + Sync),
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
            if !progress(done.fetch_add(1, Ordering::Relaxed) + 1) {
                return rows;
            }
        }
    };
    let mut rows: Vec<(usize, Vec<MapPoint>)> = std::thread::scope(|scope| {
        let handles: Vec<_> = (0..threads.max(1)).map(|_| scope.spawn(work)).collect();
        handles
            .into_iter()
            .flat_map(|h| match h.join() {
                Ok(rows) => rows,
                Err(panic) => std::panic::resume_unwind(panic),
            })
            .collect()
    });
    rows.sort_by_key(|(k, _)| *k);
    rows.into_iter().map(|(_, row)| row).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_end_where_growth_passes_zero() {
        let point = |(k, growth): (usize, &Option<f64>)| MapPoint {
            speed_m_s: k as f64,
            torque_nm: 0.0,
            eigenvalues: growth.iter().map(|g| Complex::new(*g, 0.0)).collect(),
        };
        let ranges = |growth: &[Option<f64>]| {
            let row: Vec<MapPoint> = growth.iter().enumerate().map(point).collect();
            stable_ranges_m_s(&row)
        };
        assert_eq!(
            ranges(&[Some(1.0), Some(-1.0), Some(-3.0), Some(1.0)]),
            [[0.5, 2.75]]
        );
        assert_eq!(
            ranges(&[Some(-1.0), Some(1.0), Some(-1.0)]),
            [[0.0, 0.5], [1.5, 2.0]]
        );
        assert_eq!(
            ranges(&[Some(-1.0), None, Some(-1.0), Some(-2.0)]),
            [[0.0, 0.0], [2.0, 3.0]]
        );
        assert!(ranges(&[Some(1.0), None]).is_empty());
    }
}
