//! What: modes over speed, and the speeds at which weave and capsize change stability.
//!
//! Equation: eigenvalues of the linearised model at each speed; branches followed by least change
//! of value and shape (`twinhub_linear::follow`); a critical speed is a root of the real part of a
//! followed branch (regula falsi, Illinois variant).
//!
//! Source: Bulsink (2017), section 3.2.3 (definitions of weave and capsize speed); naming by shape
//! in `twinhub_linear::name`.
//!
//! Assumes and ignores: modes change little from one speed of the sweep to the next.
//!
//! Valid for: 0.5 to 12 m/s.
//!
//! Checked by: the benchmark's weave and capsize speed (1e-8) in `multibody/tests`.

use super::error::MultibodyError;
use super::linearise::Linear;
use super::model::Multibody;
use super::steady::{Course, Steady};
use twinhub_linear::{Eigenpair, ModeName, follow};

/// Modes of the model at one speed.
#[derive(Clone, Debug)]
pub struct ModesAt {
    /// Speed, m/s.
    pub speed_m_s: f64,
    /// Eigenvalues and shapes, in the order of `Sweep::names`.
    pub modes: Vec<Eigenpair>,
}

/// Modes over speed: branch `b` has name `names[b]` and is entry `b` at each speed.
#[derive(Clone, Debug)]
pub struct Sweep {
    /// One entry per speed, ascending.
    pub points: Vec<ModesAt>,
    /// Name of each branch.
    pub names: Vec<ModeName>,
    /// Names of the states in the shapes.
    pub states: Vec<&'static str>,
}

/// A change of stability of one mode.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Change {
    /// Speed, m/s.
    pub speed_m_s: f64,
    /// True: unstable below, stable above.
    pub becomes_stable: bool,
}

impl Multibody {
    /// Modes at `speeds_m_s` (ascending) for courses like `course`, branches followed from the
    /// speed at which their shapes are clearest: the highest one with an oscillation.
    pub fn sweep(&self, course: &Course, speeds_m_s: &[f64]) -> Result<Sweep, MultibodyError> {
        let (sweep, _, missing) = self.sweep_where_steady(course, speeds_m_s)?;
        match missing.into_iter().next() {
            Some((_, error)) => Err(error),
            None => Ok(sweep),
        }
    }

    /// The same at those of the speeds that have a steady state, with these states, and with what
    /// is wrong at the other speeds.
    #[allow(clippy::type_complexity)]
    pub(super) fn sweep_where_steady(
        &self,
        course: &Course,
        speeds_m_s: &[f64],
    ) -> Result<(Sweep, Vec<Steady>, Vec<(f64, MultibodyError)>), MultibodyError> {
        let mut points = Vec::with_capacity(speeds_m_s.len());
        let (mut steady, mut missing) = (Vec::<Steady>::new(), Vec::new());
        let mut states: Vec<&'static str> = Vec::new();
        for &speed_m_s in speeds_m_s.iter().rev() {
            let course = Course {
                speed_m_s,
                ..*course
            };
            match self.steady_near(&course, steady.last()) {
                Err(error) => missing.push((speed_m_s, error)),
                Ok(found) => {
                    let at = self.lateral_if_straight(&found);
                    let modes = pairs_of(&at)?;
                    points.push(ModesAt { speed_m_s, modes });
                    steady.push(found);
                    states = at.names;
                }
            }
        }
        steady.reverse();
        missing.reverse();
        points.reverse();
        if points.is_empty() {
            let names = Vec::new();
            return Ok((
                Sweep {
                    points,
                    names,
                    states,
                },
                steady,
                missing,
            ));
        }
        let family: Vec<Vec<Eigenpair>> = points.iter().map(|p| p.modes.clone()).collect();
        // Below its weave speed the bicycle has one unstable slow oscillation: that is weave, whatever
        // other modes it meets on its way, and whether or not capsize can be told there. Without one,
        // shapes decide at the highest speed where they can.
        let has = |pairs: &[Eigenpair], mode| name_lateral(pairs, &states).contains(&mode);
        let swings = |pairs: &[Eigenpair]| pairs.iter().any(unstable_swing);
        let find = |keep: &dyn Fn(&[Eigenpair]) -> bool| {
            (0..family.len()).rev().find(|&k| keep(&family[k]))
        };
        let start = find(&|p| swings(p) && has(p, ModeName::Capsize))
            .or_else(|| find(&swings))
            .or_else(|| find(&|p| has(p, ModeName::Weave) && has(p, ModeName::Capsize)))
            .unwrap_or(family.len() - 1);
        let names = name_lateral(&family[start], &states);
        for (point, order) in points.iter_mut().zip(follow(&family, start)) {
            point.modes = order.iter().map(|&i| point.modes[i].clone()).collect();
        }
        let sweep = Sweep {
            points,
            names,
            states,
        };
        Ok((sweep, steady, missing))
    }

    /// The linearised model; of straight running the lateral part alone.
    pub(super) fn lateral_if_straight(&self, steady: &Steady) -> Linear {
        if steady.course.roll_rad == 0.0 {
            self.lateral(steady)
        } else {
            self.linearise(steady)
        }
    }

    /// A steady state from a guess nearby, or from scratch if that fails.
    pub(super) fn steady_near(
        &self,
        course: &Course,
        guess: Option<&Steady>,
    ) -> Result<Steady, MultibodyError> {
        match guess {
            Some(guess) => self
                .steady(course, Some(guess))
                .or_else(|_| self.steady(course, None)),
            None => self.steady(course, None),
        }
    }

    /// Every change of stability of a mode of a sweep, to `1e-10` m/s.
    pub fn changes(
        &self,
        course: &Course,
        sweep: &Sweep,
        mode: ModeName,
    ) -> Result<Vec<Change>, MultibodyError> {
        let branches = (0..sweep.names.len()).filter(|&b| sweep.names[b] == mode);
        // Of a conjugate pair one branch says all; where weave has split in two real ones, both count.
        let counted = if mode == ModeName::Weave { 2 } else { 1 };
        let mut found: Vec<Change> = Vec::new();
        for b in branches.take(counted) {
            for (change, _) in self.branch_changes(course, sweep, b)? {
                let known = |c: &Change| (c.speed_m_s - change.speed_m_s).abs() <= 1.0e-6;
                if !found.iter().any(known) {
                    found.push(change);
                }
            }
        }
        found.sort_by(|a, b| a.speed_m_s.total_cmp(&b.speed_m_s));
        Ok(found)
    }

    /// Every change of stability of one branch, and whether it oscillates there.
    pub(super) fn branch_changes(
        &self,
        course: &Course,
        sweep: &Sweep,
        b: usize,
    ) -> Result<Vec<(Change, bool)>, MultibodyError> {
        let mut found = Vec::new();
        for window in sweep.points.windows(2) {
            let (low, high) = (&window[0], &window[1]);
            let (from, to) = (low.modes[b].value, high.modes[b].value);
            if (from.re > 0.0) == (to.re > 0.0) {
                continue;
            }
            let speed_m_s = self.crossing(
                course,
                (low.speed_m_s, &low.modes[b]),
                (high.speed_m_s, &high.modes[b]),
            )?;
            let change = Change {
                speed_m_s,
                becomes_stable: from.re > 0.0,
            };
            found.push((change, from.im != 0.0 && to.im != 0.0));
        }
        Ok(found)
    }

    /// Root of the real part between two speeds.
    fn crossing(
        &self,
        course: &Course,
        low: (f64, &Eigenpair),
        high: (f64, &Eigenpair),
    ) -> Result<f64, MultibodyError> {
        let (mut a, mut b) = (low.0, high.0);
        let (mut fa, mut fb) = (low.1.value.re, high.1.value.re);
        let mut near = high.1.clone();
        let mut guess: Option<Steady> = None;
        let mut side = 0;
        for _ in 0..100 {
            if (b - a).abs() < 1.0e-11 {
                break;
            }
            let v = (fa * b - fb * a) / (fa - fb);
            let steady = self.steady_near(
                &Course {
                    speed_m_s: v,
                    ..*course
                },
                guess.as_ref(),
            )?;
            let pairs = pairs_of(&self.lateral_if_straight(&steady))?;
            guess = Some(steady);
            // The continuation of this one mode.
            let mode = pairs[nearest(&near, &pairs)].clone();
            let f = mode.value.re;
            if f == 0.0 || f.abs() < 1.0e-13 {
                return Ok(v);
            }
            near = mode;
            if (f > 0.0) == (fb > 0.0) {
                (b, fb) = (v, f);
                if side == -1 {
                    fa *= 0.5;
                }
                side = -1;
            } else {
                (a, fa) = (v, f);
                if side == 1 {
                    fb *= 0.5;
                }
                side = 1;
            }
        }
        Ok(0.5 * (a + b))
    }

    /// Lowest speed above which weave stays stable within the sweep, and highest speed at which
    /// capsize is still stable; `None` where there is no crossing.
    pub fn critical_speeds_m_s(
        &self,
        course: &Course,
        sweep: &Sweep,
    ) -> Result<(Option<f64>, Option<f64>), MultibodyError> {
        let weave = self.changes(course, sweep, ModeName::Weave)?;
        let capsize = self.changes(course, sweep, ModeName::Capsize)?;
        Ok((
            weave
                .iter()
                .rev()
                .find(|c| c.becomes_stable)
                .map(|c| c.speed_m_s),
            capsize
                .iter()
                .find(|c| !c.becomes_stable)
                .map(|c| c.speed_m_s),
        ))
    }
}

fn pairs_of(linear: &Linear) -> Result<Vec<Eigenpair>, MultibodyError> {
    linear
        .eigenpairs()
        .map_err(|e| MultibodyError::Eigenvalues {
            message: e.to_string(),
        })
}

/// Above this frequency an oscillation of the front assembly is wobble, not weave, rad/s.
const WEAVE_LIMIT_RAD_S: f64 = 15.0;

/// An unstable oscillation slow enough for weave.
fn unstable_swing(p: &Eigenpair) -> bool {
    p.value.re > 0.0 && p.value.im > 0.0 && p.value.im < WEAVE_LIMIT_RAD_S
}

/// Names of lateral modes. Weave: the slow oscillation with most roll and steer in it. Capsize: the
/// slowest real mode with more roll than steer. Caster: of the other real modes the one with most
/// steer.
fn name_lateral(pairs: &[Eigenpair], states: &[&'static str]) -> Vec<ModeName> {
    let index = |name: &str| states.iter().position(|s| *s == name);
    let size = |p: &Eigenpair, i: Option<usize>| i.map_or(0.0, |i| p.shape[i].norm_sqr());
    let (roll_at, steer_at) = (index("roll_rad"), index("steer_rad"));
    let angles: Vec<usize> = (0..states.len())
        .filter(|&i| {
            (states[i].ends_with("_rad") || states[i] == "height_m")
                && Some(i) != roll_at
                && Some(i) != steer_at
        })
        .collect();
    let parts = |p: &Eigenpair| {
        let others: f64 = angles.iter().map(|&i| p.shape[i].norm_sqr()).sum();
        let total: f64 = p.shape.iter().map(|z| z.norm_sqr()).sum();
        (size(p, roll_at), size(p, steer_at), others, total)
    };
    let mut names = vec![ModeName::Other; pairs.len()];
    let best = |score: &dyn Fn(usize) -> f64| {
        (0..pairs.len())
            .filter(|&k| score(k) > 0.0)
            .max_by(|&a, &b| score(a).total_cmp(&score(b)))
    };
    let weave = best(&|k| {
        let (roll, steer, others, _) = parts(&pairs[k]);
        let slow = pairs[k].value.im > 0.0 && pairs[k].value.im < WEAVE_LIMIT_RAD_S;
        if unstable_swing(&pairs[k]) {
            // Before any damped one.
            2.0 + pairs[k].value.re
        } else if slow {
            libm::sqrt(roll * steer) / (roll + steer + others).max(f64::MIN_POSITIVE)
        } else {
            0.0
        }
    });
    if let Some(k) = weave {
        for (name, pair) in names.iter_mut().zip(pairs) {
            if pair.value == pairs[k].value || pair.value == pairs[k].value.conj() {
                *name = ModeName::Weave;
            }
        }
    }
    let capsize = best(&|k| {
        let (roll, steer, others, total) = parts(&pairs[k]);
        let real = pairs[k].value.im == 0.0;
        // Much roll in the configuration, and a configuration that counts beside the rates.
        if real && roll > steer && roll > 1.0e-6 * total && roll > others {
            1.0 / (1.0e-9 + pairs[k].value.re.abs())
        } else {
            0.0
        }
    });
    if let Some(k) = capsize {
        names[k] = ModeName::Capsize;
    }
    let caster = best(&|k| {
        let (roll, steer, others, _) = parts(&pairs[k]);
        let taken =
            names[k] != ModeName::Other || pairs[k].value.im != 0.0 || pairs[k].value.re >= 0.0;
        if taken {
            0.0
        } else {
            steer / (roll + steer + others).max(f64::MIN_POSITIVE)
        }
    });
    if let Some(k) = caster {
        names[k] = ModeName::Caster;
    }
    names
}

/// Index of the mode that continues `mode`.
fn nearest(mode: &Eigenpair, pairs: &[Eigenpair]) -> usize {
    (0..pairs.len())
        .min_by(|&a, &b| {
            let cost = |k: usize| {
                let d = mode.value - pairs[k].value;
                let inner: nalgebra::Complex<f64> = mode
                    .shape
                    .iter()
                    .zip(&pairs[k].shape)
                    .map(|(x, y)| x.conj() * y)
                    .sum();
                libm::hypot(d.re, d.im) / (1.0 + libm::hypot(mode.value.re, mode.value.im))
                    + 0.3 * (1.0 - inner.norm_sqr().min(1.0))
            };
            cost(a).total_cmp(&cost(b))
        })
        .unwrap_or(0)
}
