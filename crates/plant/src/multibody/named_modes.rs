//! What: everything that is said about stability over speed: modes at each speed, changes of
//! stability, verdicts, stable ranges.
//!
//! Equation: as in `modes`, followed on a grid of at most 0.05 m/s; between changes of stability
//! nothing changes, so each range is judged at its middle.
//!
//! Source: Bulsink (2017), section 3.2.3; the form of the answer is that of `twinhub_linear::Modes`.
//!
//! Assumes and ignores: in a turn the slow mode of speed counts as a mode like any other.
//!
//! Valid for: 0.05 to 60 m/s; speeds without a steady state are told apart, not refused.
//!
//! Checked by: the tests of this file: benchmark without slip (1e-8), cases of the source.

use super::error::MultibodyError;
use super::model::Multibody;
use super::modes::{Change, Sweep};
use super::steady::{Course, Steady};
use twinhub_linear::{Critical, Crossing, Eigenpair, Mode, ModeName, Modes, Point, Verdict};

/// Largest step in speed when following, m/s.
const FOLLOW_STEP_M_S: f64 = 0.05;
/// Names are given at least up to this speed, where the pattern is clear, m/s.
const NAMING_SPEED_M_S: f64 = 10.0;
/// Grid speeds at most.
const MOST_GRID: f64 = 2000.0;

/// Modes over speed of a multibody bicycle.
#[derive(Clone, Debug)]
pub struct NamedModes {
    /// Points, changes, ranges and verdicts. Points without a steady state have no modes.
    pub modes: Modes,
    /// Steady states of the points; none where there is none.
    pub steady: Vec<Option<Steady>>,
    /// Names of the states in the shapes.
    pub states: Vec<&'static str>,
    /// Speeds without a steady state, and why.
    pub missing: Vec<(f64, MultibodyError)>,
}

impl Multibody {
    /// Modes at `speeds_m_s` for courses like `course`. Changes and ranges lie between the least
    /// and the greatest of the speeds that have a steady state.
    ///
    /// # Errors
    /// If no speed has a steady state, or eigenvalues are not found.
    pub fn named_modes(
        &self,
        course: &Course,
        speeds_m_s: &[f64],
    ) -> Result<NamedModes, MultibodyError> {
        let low = speeds_m_s.iter().copied().fold(f64::INFINITY, f64::min);
        let high = speeds_m_s.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let grid = grid(low, high, speeds_m_s);
        let (sweep, steady, mut missing) = self.sweep_where_steady(course, &grid)?;
        if !speeds_m_s
            .iter()
            .any(|v| sweep.points.iter().any(|p| p.speed_m_s == *v))
        {
            return Err(missing
                .into_iter()
                .find(|(v, _)| speeds_m_s.contains(v))
                .map_or(
                    MultibodyError::Speed {
                        found: low,
                        accepted: "0.05 to 60",
                    },
                    |(_, error)| error,
                ));
        }
        missing.retain(|(v, _)| speeds_m_s.contains(v));
        let at = |v: f64| sweep.points.iter().position(|p| p.speed_m_s == v);
        let points = speeds_m_s
            .iter()
            .map(|&speed_m_s| Point {
                speed_m_s,
                modes: at(speed_m_s).map_or_else(Vec::new, |k| {
                    let pairs = sweep.points[k].modes.iter().cloned();
                    sorted(&sweep.names, pairs)
                }),
            })
            .collect();
        let low = sweep
            .points
            .iter()
            .map(|p| p.speed_m_s)
            .find(|v| *v >= low)
            .unwrap_or(low);
        let criticals = self.criticals(course, &sweep, low, high)?;
        let stable_ranges_m_s = self.stable_ranges(course, &criticals, low, high)?;
        let verdict = |mode: ModeName| verdict(mode, &criticals, &sweep, low, high);
        Ok(NamedModes {
            modes: Modes {
                points,
                stable_ranges_m_s,
                weave: verdict(ModeName::Weave),
                capsize: verdict(ModeName::Capsize),
                criticals,
            },
            steady: speeds_m_s
                .iter()
                .map(|v| at(*v).map(|k| steady[k].clone()))
                .collect(),
            states: sweep.states,
            missing,
        })
    }

    /// Changes of stability of all modes, ascending.
    fn criticals(
        &self,
        course: &Course,
        sweep: &Sweep,
        low: f64,
        high: f64,
    ) -> Result<Vec<Critical>, MultibodyError> {
        let mut found: Vec<Critical> = Vec::new();
        for (b, &mode) in sweep.names.iter().enumerate() {
            for (change, oscillates) in self.branch_changes(course, sweep, b)? {
                let Change {
                    speed_m_s,
                    becomes_stable,
                } = change;
                let known =
                    |c: &Critical| c.mode == mode && (c.speed_m_s - speed_m_s).abs() < 1.0e-6;
                if speed_m_s < low || speed_m_s > high || found.iter().any(known) {
                    continue;
                }
                found.push(Critical {
                    speed_m_s,
                    mode,
                    crossing: if oscillates {
                        Crossing::Oscillation
                    } else {
                        Crossing::Divergence
                    },
                    stable_above: becomes_stable,
                });
            }
        }
        found.sort_by(|a, b| a.speed_m_s.total_cmp(&b.speed_m_s));
        Ok(found)
    }

    fn stable_ranges(
        &self,
        course: &Course,
        criticals: &[Critical],
        low: f64,
        high: f64,
    ) -> Result<Vec<[f64; 2]>, MultibodyError> {
        let mut edges = vec![low];
        edges.extend(criticals.iter().map(|c| c.speed_m_s));
        edges.push(high);
        let mut stable: Vec<[f64; 2]> = Vec::new();
        for ends in edges.windows(2).filter(|ends| ends[1] > ends[0]) {
            let middle = Course {
                speed_m_s: 0.5 * (ends[0] + ends[1]),
                ..*course
            };
            let Ok(steady) = self.steady(&middle, None) else {
                continue;
            };
            let a = self.lateral_if_straight(&steady).a;
            if a.complex_eigenvalues().iter().all(|z| z.re < 0.0) {
                match stable.last_mut() {
                    Some(last) if last[1] == ends[0] => last[1] = ends[1],
                    _ => stable.push([ends[0], ends[1]]),
                }
            }
        }
        Ok(stable)
    }
}

/// The speeds asked for among others close enough to follow modes from one to the next, ascending.
fn grid(low: f64, high: f64, speeds_m_s: &[f64]) -> Vec<f64> {
    let top = high.max(NAMING_SPEED_M_S).min(60.0);
    let steps = libm::ceil((top - low) / FOLLOW_STEP_M_S).clamp(1.0, MOST_GRID);
    let mut grid: Vec<f64> = (0..=steps as usize)
        .map(|i| low + (top - low) * i as f64 / steps)
        // Beside a speed that is asked for, none is needed.
        .filter(|g| !speeds_m_s.iter().any(|v| (v - g).abs() < 1.0e-9))
        .chain(speeds_m_s.iter().copied())
        .collect();
    grid.sort_by(f64::total_cmp);
    grid.dedup();
    grid
}

/// Modes with their names, largest real part first as `twinhub_linear` has them.
fn sorted(names: &[ModeName], pairs: impl Iterator<Item = Eigenpair>) -> Vec<Mode> {
    let mut modes: Vec<Mode> = names
        .iter()
        .zip(pairs)
        .map(|(&name, pair)| Mode { name, pair })
        .collect();
    modes.sort_by(|a, b| {
        let (a, b) = (a.pair.value, b.pair.value);
        b.re.total_cmp(&a.re).then(b.im.total_cmp(&a.im))
    });
    modes
}

fn verdict(mode: ModeName, criticals: &[Critical], sweep: &Sweep, low: f64, high: f64) -> Verdict {
    if criticals.iter().any(|c| c.mode == mode) {
        return Verdict::Crosses;
    }
    let middle = 0.5 * (low + high);
    let nearest = sweep.points.iter().min_by(|a, b| {
        let far = |v: f64| (v - middle).abs();
        far(a.speed_m_s).total_cmp(&far(b.speed_m_s))
    });
    let unstable = nearest.is_some_and(|point| {
        let modes = sweep.names.iter().zip(&point.modes);
        modes
            .filter(|(name, _)| **name == mode)
            .any(|(_, pair)| pair.value.re >= 0.0)
    });
    if unstable {
        Verdict::AlwaysUnstable
    } else {
        Verdict::AlwaysStable
    }
}

/// What a shape is made of: the configuration coordinate (or, without one, the state) that is
/// largest in it.
pub fn dominant_state(pair: &Eigenpair, states: &[&'static str]) -> &'static str {
    let largest = |keep: &dyn Fn(&str) -> bool| {
        (0..states.len().min(pair.shape.len()))
            .filter(|&i| keep(states[i]))
            .max_by(|&a, &b| {
                let size = |i: usize| pair.shape[i].norm_sqr();
                size(a).total_cmp(&size(b))
            })
    };
    let size = |i: usize| pair.shape[i].norm_sqr();
    let total: f64 = (0..pair.shape.len()).map(size).sum();
    let configuration = |s: &str| s.ends_with("_rad") || s == "height_m";
    largest(&configuration)
        .filter(|&i| size(i) > 1.0e-6 * total)
        .or_else(|| largest(&|_| true))
        .map_or("", |i| states[i])
}

#[cfg(test)]
mod tests {
    use super::super::{BulsinkBicycle, Case, Parameters, Reading};
    use super::*;
    use twinhub_linear::{Bicycle, Canonical, MotorPair};

    fn speeds(from: f64, to: f64, step: f64) -> Vec<f64> {
        let count = ((to - from) / step).round() as usize;
        (0..=count).map(|i| from + i as f64 * step).collect()
    }

    #[test]
    fn without_slip_the_answer_is_that_of_the_linear_bicycle() {
        let bicycle = Bicycle::load("meijaard2007_benchmark").unwrap();
        let model = Multibody::new(&Parameters::from_whipple(&bicycle)).unwrap();
        let at = speeds(0.5, 10.0, 0.5);
        let ours = model.named_modes(&Course::straight(5.0), &at).unwrap();
        let theirs = Modes::over(&Canonical::new(&bicycle).unwrap(), MotorPair::OFF, &at);
        let near = |a: Option<f64>, b: Option<f64>| (a.unwrap() - b.unwrap()).abs() < 1.0e-8;
        assert!(near(ours.modes.weave_speed_m_s(), theirs.weave_speed_m_s()));
        assert!(near(
            ours.modes.capsize_speed_m_s(),
            theirs.capsize_speed_m_s()
        ));
        assert_eq!(ours.modes.weave, Verdict::Crosses);
        let (a, b) = (&ours.modes.stable_ranges_m_s, &theirs.stable_ranges_m_s);
        assert_eq!(a.len(), b.len());
        assert!((a[0][0] - b[0][0]).abs() < 1.0e-8 && (a[0][1] - b[0][1]).abs() < 1.0e-8);
        for (p, q) in ours.modes.points.iter().zip(&theirs.points) {
            for mode in &p.modes {
                let twin = q.modes.iter().find(|m| {
                    let d = m.pair.value - mode.pair.value;
                    libm::hypot(d.re, d.im) < 1.0e-7
                });
                assert!(
                    twin.is_some_and(|t| t.name == mode.name || q.speed_m_s < 1.0),
                    "{} {:?}",
                    q.speed_m_s,
                    mode
                );
            }
        }
    }

    #[test]
    fn speeds_without_a_steady_state_are_told_apart() {
        let p = Parameters::bulsink2017(BulsinkBicycle::One, Case::TyresRigid, &Reading::default());
        let model = Multibody::new(&p).unwrap();
        let answer = model
            .named_modes(&Course::straight(5.0), &speeds(0.0, 12.0, 1.0))
            .unwrap();
        assert_eq!(answer.modes.points.len(), 13);
        assert!(answer.modes.points[0].modes.is_empty() && answer.steady[0].is_none());
        assert_eq!(answer.missing.len(), 1);
        let weave = answer.modes.weave_speed_m_s().unwrap();
        assert!((8.0..10.5).contains(&weave), "{weave}");
        assert_eq!(answer.modes.capsize, Verdict::AlwaysStable);
        assert!(model.named_modes(&Course::straight(0.0), &[0.0]).is_err());
    }

    #[test]
    fn weave_keeps_its_name_however_far_the_speeds_go() {
        let p = Parameters::bulsink2017(BulsinkBicycle::One, Case::Full, &Reading::default());
        let model = Multibody::new(&p).unwrap();
        for torque_nm in [0.0, 100.0] {
            let weave = |top: f64| {
                let at = speeds(0.5, top, 0.5);
                let answer = model
                    .named_modes(&Course::pair(5.0, torque_nm), &at)
                    .unwrap();
                assert_eq!(answer.modes.weave, Verdict::Crosses, "to {top} m/s");
                answer.modes.weave_speed_m_s().unwrap()
            };
            assert!((weave(10.0) - weave(12.0)).abs() < 1.0e-6, "{torque_nm} Nm");
        }
    }
}
