//! The benchmark bicycle's modes over a range of speeds: named, followed, and judged.

use crate::canonical::Canonical;
use crate::critical::Crossing;
use crate::eigen::Eigenpair;
use crate::follow::follow;
use crate::motor_pair::MotorPair;
use crate::names::{self, Layout, ModeName};

/// One mode at one speed.
#[derive(Debug, Clone, PartialEq)]
pub struct Mode {
    /// Its name, followed over speed.
    pub name: ModeName,
    /// Eigenvalue and shape.
    pub pair: Eigenpair,
}

impl Mode {
    /// Time to grow e-fold, s; negative for decay, infinite on the edge.
    pub fn growth_time_s(&self) -> f64 {
        1.0 / self.pair.value.re
    }
}

/// All modes at one speed, in the order of `Canonical::eigenvalues`.
#[derive(Debug, Clone, PartialEq)]
pub struct Point {
    /// Forward speed.
    pub speed_m_s: f64,
    /// The modes.
    pub modes: Vec<Mode>,
}

/// How a mode fares over the range of speeds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// It gains or loses stability within the range.
    Crosses,
    /// Stable throughout.
    AlwaysStable,
    /// Unstable throughout.
    AlwaysUnstable,
}

impl Verdict {
    /// As in the JSON answer.
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::Crosses => "crosses",
            Self::AlwaysStable => "always_stable",
            Self::AlwaysUnstable => "always_unstable",
        }
    }
}

/// A speed at which a named mode gains or loses stability.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Critical {
    /// The speed.
    pub speed_m_s: f64,
    /// The mode.
    pub mode: ModeName,
    /// Through zero or as an oscillation.
    pub crossing: Crossing,
    /// Whether the mode is stable just above.
    pub stable_above: bool,
}

/// Modes over a range of speeds.
#[derive(Debug, Clone, PartialEq)]
pub struct Modes {
    /// At each requested speed.
    pub points: Vec<Point>,
    /// All crossings within the range, ascending.
    pub criticals: Vec<Critical>,
    /// Where all modes decay, within the range.
    pub stable_ranges_m_s: Vec<[f64; 2]>,
    /// Weave over the range.
    pub weave: Verdict,
    /// Capsize over the range.
    pub capsize: Verdict,
}

/// Largest step in speed from one set of modes to the next when following, m/s.
const FOLLOW_STEP_M_S: f64 = 0.02;
/// Names are given at least up to this speed, where the pattern is clear, m/s.
const NAMING_SPEED_M_S: f64 = 10.0;

impl Modes {
    /// Modes at `speeds_m_s` (finite, from zero up) under a constant torque pair. Crossings and
    /// ranges lie between the least and the greatest of them; there are none without two speeds. Without any finite
    /// speed there are no points either, and both verdicts are the cautious ones.
    pub fn over(bicycle: &Canonical, pair: MotorPair, speeds_m_s: &[f64]) -> Self {
        let low = speeds_m_s.iter().copied().fold(f64::INFINITY, f64::min);
        let high = speeds_m_s.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        if !(low.is_finite() && high.is_finite()) {
            return Self {
                points: Vec::new(),
                criticals: Vec::new(),
                stable_ranges_m_s: Vec::new(),
                weave: Verdict::AlwaysUnstable,
                capsize: Verdict::AlwaysUnstable,
            };
        }
        let (criticals, grid) = (
            bicycle.critical_speeds_m_s(pair),
            Grid::new(bicycle, pair, speeds_m_s),
        );
        let points = speeds_m_s
            .iter()
            .map(|v| grid.point(bicycle, pair, *v))
            .collect();
        let inside: Vec<_> = criticals
            .iter()
            .copied()
            .filter(|(v, _)| *v > low && *v < high)
            .collect();

        let mut found = Vec::new();
        for (v, crossing) in &inside {
            // The mode nearest to the axis at the crossing, of the right kind.
            let at = grid.point(bicycle, pair, *v);
            let oscillates = *crossing == Crossing::Oscillation;
            let nearest = at
                .modes
                .iter()
                .filter(|m| (m.pair.value.im != 0.0) == oscillates)
                .min_by(|a, b| a.pair.value.re.abs().total_cmp(&b.pair.value.re.abs()));
            let step = 1e-6 * v.max(1.0);
            let count = |v: f64| {
                bicycle
                    .eigenvalues(v, pair)
                    .iter()
                    .filter(|s| s.re > 0.0)
                    .count()
            };
            let (below, above) = (count(v - step), count(v + step));
            if let Some(mode) = nearest.filter(|_| below != above) {
                found.push(Critical {
                    speed_m_s: *v,
                    mode: mode.name,
                    crossing: *crossing,
                    stable_above: above < below,
                });
            }
        }

        // Between crossings nothing changes: judge each interval at its middle.
        let mut edges = vec![low];
        edges.extend(inside.iter().map(|(v, _)| *v));
        edges.push(high);
        let mut stable: Vec<[f64; 2]> = Vec::new();
        for ends in edges.windows(2) {
            let middle = 0.5 * (ends[0] + ends[1]);
            if bicycle.eigenvalues(middle, pair).iter().all(|s| s.re < 0.0) {
                match stable.last_mut() {
                    Some(last) if last[1] == ends[0] => last[1] = ends[1],
                    _ => stable.push([ends[0], ends[1]]),
                }
            }
        }
        let verdict = |name: ModeName| {
            if found.iter().any(|c| c.mode == name) {
                return Verdict::Crosses;
            }
            let middle = grid.point(bicycle, pair, 0.5 * (low + high));
            let unstable = middle
                .modes
                .iter()
                .any(|m| m.name == name && m.pair.value.re >= 0.0);
            if unstable {
                Verdict::AlwaysUnstable
            } else {
                Verdict::AlwaysStable
            }
        };
        let (weave, capsize) = (verdict(ModeName::Weave), verdict(ModeName::Capsize));
        Self {
            points,
            criticals: found,
            stable_ranges_m_s: stable,
            weave,
            capsize,
        }
    }

    /// Speed above which weave is stable: the highest at which it becomes so (else the first at
    /// which it changes at all).
    pub fn weave_speed_m_s(&self) -> Option<f64> {
        let mut weave = self.criticals.iter().filter(|c| c.mode == ModeName::Weave);
        let last = weave.clone().rfind(|c| c.stable_above);
        last.or_else(|| weave.next()).map(|c| c.speed_m_s)
    }

    /// Speed above which capsize is unstable: the lowest at which it becomes so (else the first at
    /// which it changes at all).
    pub fn capsize_speed_m_s(&self) -> Option<f64> {
        let mut capsize = self
            .criticals
            .iter()
            .filter(|c| c.mode == ModeName::Capsize);
        let first = capsize.clone().find(|c| !c.stable_above);
        first.or_else(|| capsize.next()).map(|c| c.speed_m_s)
    }
}

/// Names on a fine grid of speeds.
struct Grid {
    speeds_m_s: Vec<f64>,
    family: Vec<Vec<Eigenpair>>,
    names: Vec<Vec<ModeName>>,
}

impl Grid {
    fn new(bicycle: &Canonical, pair: MotorPair, speeds_m_s: &[f64]) -> Self {
        let low = speeds_m_s.iter().copied().fold(0.0, f64::min);
        let high = speeds_m_s.iter().copied().fold(NAMING_SPEED_M_S, f64::max);
        let steps = libm::ceil((high - low) / FOLLOW_STEP_M_S).clamp(1.0, 5000.0) as usize;
        let speeds: Vec<f64> = (0..=steps)
            .map(|i| low + (high - low) * i as f64 / steps as f64)
            .collect();
        let family: Vec<_> = speeds
            .iter()
            .map(|v| bicycle.eigenpairs(*v, pair))
            .collect();
        let clear = (0..family.len())
            .rev()
            .find(|k| names::ordinary(&family[*k]));
        let start = clear.unwrap_or(family.len() - 1);
        let first = names::name(&family[start], &Layout::benchmark());
        let mut named = vec![vec![ModeName::Other; 4]; family.len()];
        for (at, branch) in named.iter_mut().zip(follow(&family, start)) {
            for (b, index) in branch.into_iter().enumerate() {
                at[index] = first[b];
            }
        }
        Self {
            speeds_m_s: speeds,
            family,
            names: named,
        }
    }

    /// Modes at any speed, named after the nearest grid point.
    fn point(&self, bicycle: &Canonical, pair: MotorPair, speed_m_s: f64) -> Point {
        let pairs = bicycle.eigenpairs(speed_m_s, pair);
        let k = (0..self.speeds_m_s.len())
            .min_by(|a, b| {
                (self.speeds_m_s[*a] - speed_m_s)
                    .abs()
                    .total_cmp(&(self.speeds_m_s[*b] - speed_m_s).abs())
            })
            .unwrap_or(0);
        let mut modes: Vec<_> = pairs
            .into_iter()
            .map(|pair| Mode {
                name: ModeName::Other,
                pair,
            })
            .collect();
        let pairs: Vec<_> = modes.iter().map(|m| m.pair.clone()).collect();
        for (i, j) in crate::follow::continuation(&self.family[k], &pairs)
            .into_iter()
            .enumerate()
        {
            modes[j].name = self.names[k][i];
        }
        Point { speed_m_s, modes }
    }
}
