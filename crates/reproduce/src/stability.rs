//! What: weave and capsize speed, stable ranges and growth of a parameter set on a straight course.
//!
//! Equation: eigenvalues of the linearised model (`twinhub_plant::multibody`); a range is where all
//! lateral modes decay.
//!
//! Source: Bulsink (2017), section 3.2.3 (definitions).
//!
//! Assumes and ignores: as the linearisation.
//!
//! Valid for: 1 to 14 m/s.
//!
//! Checked by: `tests/reproduction.rs`.

use crate::error::ReproduceError;
use twinhub_plant::multibody::{Course, Multibody, Parameters};

/// Speeds at which a mode changes stability; none where it does not.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Critical {
    /// Lowest speed above which weave stays stable, m/s.
    pub weave_m_s: Option<f64>,
    /// Highest speed at which capsize is stable, m/s.
    pub capsize_m_s: Option<f64>,
}

/// Weave and capsize speed for courses like `course`.
///
/// # Errors
/// Where the model has no steady state at a speed from 1 to 14 m/s.
pub fn critical(parameters: &Parameters, course: &Course) -> Result<Critical, ReproduceError> {
    let model = Multibody::new(parameters)?;
    let followed: Vec<f64> = (4..=56).map(|k| 0.25 * f64::from(k)).collect();
    let sweep = model.sweep(course, &followed)?;
    let (_, capsize_m_s) = model.critical_speeds_m_s(course, &sweep)?;
    Ok(Critical {
        weave_m_s: swing_m_s(&model, course)?,
        capsize_m_s,
    })
}

/// An oscillation slower than this is weave, rad/s; a faster one wobble or the rider's joints.
const WEAVE_LIMIT_RAD_S: f64 = 15.0;
/// Speeds between which weave is looked for, and the step, m/s.
const LOOKED_M_S: [f64; 3] = [1.5, 18.0, 0.25];

/// The lowest speed above which every slow lateral oscillation decays: of all slow oscillations
/// weave is the one that grows at low speed, whatever other modes it meets on its way.
fn swing_m_s(model: &Multibody, course: &Course) -> Result<Option<f64>, ReproduceError> {
    let growth = |speed_m_s: f64| {
        let steady = model.steady(
            &Course {
                speed_m_s,
                ..*course
            },
            None,
        )?;
        let values = model.lateral_eigenvalues(&steady);
        let slow = values
            .iter()
            .filter(|z| z.im > 1.0e-6 && z.im < WEAVE_LIMIT_RAD_S);
        Ok::<_, ReproduceError>(slow.map(|z| z.re).fold(f64::MIN, f64::max))
    };
    let [low, high, step] = LOOKED_M_S;
    let (mut above, mut at_above) = (high, growth(high)?);
    if at_above >= 0.0 {
        return Ok(None);
    }
    while above - step >= low {
        let below = above - step;
        let at_below = growth(below)?;
        if at_below >= 0.0 {
            return Ok(Some(crossing(
                &growth,
                (below, at_below),
                (above, at_above),
            )?));
        }
        (above, at_above) = (below, at_below);
    }
    Ok(None)
}

/// Root of `growth` between a speed at which it is positive and one at which it is negative, to
/// 1e-8 m/s (regula falsi, Illinois variant).
fn crossing(
    growth: &dyn Fn(f64) -> Result<f64, ReproduceError>,
    low: (f64, f64),
    high: (f64, f64),
) -> Result<f64, ReproduceError> {
    let ((mut a, mut fa), (mut b, mut fb)) = (low, high);
    let mut side = 0;
    for _ in 0..60 {
        // A branch that begins or ends in between leaves no slope to follow.
        let v = if fb > -1.0e100 {
            (fa * b - fb * a) / (fa - fb)
        } else {
            0.5 * (a + b)
        };
        let f = growth(v)?;
        if b - a < 1.0e-8 || f.abs() < 1.0e-11 {
            return Ok(v);
        }
        if f > 0.0 {
            (a, fa) = (v, f);
            if side == 1 {
                fb *= 0.5;
            }
            side = 1;
        } else {
            (b, fb) = (v, f);
            if side == -1 {
                fa *= 0.5;
            }
            side = -1;
        }
    }
    Ok(0.5 * (a + b))
}

/// Weave speed when coasting straight ahead, m/s.
pub fn weave_m_s(parameters: &Parameters) -> Result<Option<f64>, ReproduceError> {
    weave_on_m_s(parameters, &Course::straight(5.0))
}

/// Weave speed on courses like `course`, m/s.
pub fn weave_on_m_s(
    parameters: &Parameters,
    course: &Course,
) -> Result<Option<f64>, ReproduceError> {
    swing_m_s(&Multibody::new(parameters)?, course)
}

/// Largest real part of the lateral modes at a speed, 1/s.
pub fn growth_per_s(model: &Multibody, course: &Course) -> Result<f64, ReproduceError> {
    let steady = model.steady(course, None)?;
    let values = model.lateral_eigenvalues(&steady);
    Ok(values.iter().map(|z| z.re).fold(f64::MIN, f64::max))
}

/// The first range of speeds between `from_m_s` and `to_m_s` in which every lateral mode decays;
/// edges to 1e-6 m/s, found on a grid of 0.05 m/s.
pub fn stable_range_m_s(
    parameters: &Parameters,
    [from_m_s, to_m_s]: [f64; 2],
) -> Result<Option<[f64; 2]>, ReproduceError> {
    let model = Multibody::new(parameters)?;
    let stable =
        |v: f64| Ok::<_, ReproduceError>(growth_per_s(&model, &Course::straight(v))? < 0.0);
    let edge = |mut a: f64, mut b: f64| {
        let at_a = stable(a)?;
        while b - a > 1.0e-6 {
            let middle = 0.5 * (a + b);
            if stable(middle)? == at_a {
                a = middle
            } else {
                b = middle
            }
        }
        Ok::<_, ReproduceError>(0.5 * (a + b))
    };
    let steps = libm::round((to_m_s - from_m_s) / 0.05) as usize;
    let grid: Vec<f64> = (0..=steps).map(|k| from_m_s + 0.05 * k as f64).collect();
    let mut start = None;
    for pair in grid.windows(2) {
        match (stable(pair[0])?, stable(pair[1])?, start) {
            (false, true, None) => start = Some(edge(pair[0], pair[1])?),
            (true, _, None) => start = Some(pair[0]),
            _ => {}
        }
        if let (Some(start), false) = (start, stable(pair[1])?) {
            return Ok(Some([start, edge(pair[0], pair[1])?]));
        }
    }
    Ok(start.map(|start| [start, to_m_s]))
}

/// Lowest growth over speeds from 1 to 8 m/s: below zero means that some speed is stable.
pub fn best_growth_per_s(parameters: &Parameters) -> Result<f64, ReproduceError> {
    let model = Multibody::new(parameters)?;
    let mut best = f64::INFINITY;
    for k in 0..=140 {
        let v = 1.0 + 0.05 * f64::from(k);
        best = growth_per_s(&model, &Course::straight(v))?.min(best);
    }
    Ok(best)
}

/// The value in a range at which `figure` is `target`: the one nearest to `start`, to a
/// thousandth of the range; `None` if there is none.
pub fn solve(
    [low, high]: [f64; 2],
    start: f64,
    target: f64,
    figure: &dyn Fn(f64) -> Option<f64>,
) -> Option<f64> {
    const PARTS: usize = 8;
    let at = |v: f64| figure(v).map(|f| f - target).filter(|f| f.is_finite());
    let grid: Vec<(f64, Option<f64>)> = (0..=PARTS)
        .map(|k| low + (high - low) * k as f64 / PARTS as f64)
        .map(|v| (v, at(v)))
        .collect();
    let mut roots: Vec<f64> = Vec::new();
    for pair in grid.windows(2) {
        let ((mut a, Some(mut fa)), (mut b, Some(mut fb))) = (pair[0], pair[1]) else {
            continue;
        };
        if (fa > 0.0) == (fb > 0.0) {
            continue;
        }
        let mut v = a;
        for _ in 0..6 {
            v = (fa * b - fb * a) / (fa - fb);
            let Some(f) = at(v) else { break };
            if f.abs() < 1.0e-4 * target.abs() {
                break;
            }
            if (f > 0.0) == (fa > 0.0) {
                (a, fa) = (v, f)
            } else {
                (b, fb) = (v, f)
            }
        }
        roots.push(v);
    }
    roots
        .into_iter()
        .min_by(|a, b| (a - start).abs().total_cmp(&(b - start).abs()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_value_that_meets_is_found_or_none() {
        let parabola = |x: f64| Some(x * x);
        let found = solve([-3.0, 3.0], 1.0, 2.0, &parabola).unwrap();
        assert!((found - 2.0_f64.sqrt()).abs() < 1.0e-3, "{found}");
        let found = solve([-3.0, 3.0], -1.0, 2.0, &parabola).unwrap();
        assert!((found + 2.0_f64.sqrt()).abs() < 1.0e-3, "{found}");
        assert_eq!(solve([-3.0, 3.0], 1.0, 10.0, &parabola), None);
        assert_eq!(solve([-3.0, 3.0], 1.0, 2.0, &|_| None), None);
    }
}
