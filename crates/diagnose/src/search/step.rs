//! Gauss-Newton steps with bounds.

use super::fitting::Columns;
use super::rides::Column;
use crate::engine::small::{dot, solve};

/// Gauss-Newton step of parameters with a box: minimises |e + C d|² + prior, entries at the box
/// stay there. The columns are those of the calibration, then some more.
pub fn bounded_step(
    residual: &Column,
    calibration: &Columns,
    more: &[&Column],
    precision: &[f64],
    at: &[f64],
    origin: &[f64],
    least: &[f64],
    most: &[f64],
) -> Vec<f64> {
    let columns: Vec<&Column> = (calibration.list.iter().map(|(_, c)| c))
        .chain(more.iter().copied())
        .collect();
    let m = columns.len();
    let mut normal = calibration.with(more);
    let mut right = vec![0.0; m];
    for i in 0..m {
        right[i] = -dot(columns[i], residual) - precision[i] * (at[i] - origin[i]);
        normal[i * m + i] += precision[i] + 1e-9;
    }
    let mut held: Vec<Option<f64>> = vec![None; m];
    for _ in 0..=m {
        let free: Vec<usize> = (0..m).filter(|i| held[*i].is_none()).collect();
        if free.is_empty() {
            break;
        }
        let f = free.len();
        let mut a = vec![0.0; f * f];
        let mut b = vec![0.0; f];
        for (i, p) in free.iter().enumerate() {
            b[i] = right[*p];
            for (q, h) in held.iter().enumerate() {
                if let Some(h) = h {
                    b[i] -= normal[p * m + q] * h;
                }
            }
            for (j, q) in free.iter().enumerate() {
                a[i * f + j] = normal[p * m + q];
            }
        }
        let Some(step) = solve(&a, &[b]) else {
            return vec![0.0; m];
        };
        let mut worst: Option<(usize, f64, f64)> = None;
        for (i, p) in free.iter().enumerate() {
            let there = at[*p] + step[0][i];
            let inside = there.clamp(least[*p], most[*p]);
            let scale = (1.0 / normal[p * m + p]).sqrt().max(1e-300);
            let over = (there - inside).abs() / scale;
            if over > 1e-9 && worst.is_none_or(|w| over > w.1) {
                worst = Some((*p, over, inside - at[*p]));
            }
        }
        match worst {
            Some((p, _, step)) => held[p] = Some(step),
            None => {
                let mut all: Vec<f64> = held.iter().map(|h| h.unwrap_or(0.0)).collect();
                for (i, p) in free.iter().enumerate() {
                    all[*p] = step[0][i];
                }
                return all;
            }
        }
    }
    held.iter().map(|h| h.unwrap_or(0.0)).collect()
}
