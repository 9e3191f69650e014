//! Names of lateral modes, by their shape.

use crate::eigen::Eigenpair;

/// The lateral modes of a bicycle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum ModeName {
    /// Roll and steer swing together; at low speed two real modes.
    Weave,
    /// Slow, mostly roll.
    Capsize,
    /// Fast, mostly steer, decaying.
    Caster,
    /// Any other (wobble, wheel hop, rider's joints): models beyond the benchmark have them.
    Other,
}

impl ModeName {
    /// As printed.
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::Weave => "weave",
            Self::Capsize => "capsize",
            Self::Caster => "caster",
            Self::Other => "other",
        }
    }
}

impl core::fmt::Display for ModeName {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.pad(self.as_str())
    }
}

/// Where a state vector holds what the names depend on.
#[derive(Debug, Clone, PartialEq)]
pub struct Layout {
    /// Index of the roll angle.
    pub roll: usize,
    /// Index of the steer angle.
    pub steer: usize,
    /// Indices of all other configuration coordinates (not rates).
    pub others: Vec<usize>,
}

impl Layout {
    /// The benchmark's (roll, steer, roll rate, steer rate).
    pub const fn benchmark() -> Self {
        Self {
            roll: 0,
            steer: 1,
            others: Vec::new(),
        }
    }

    /// Squared magnitudes of roll, steer and all others in a shape.
    fn parts(&self, pair: &Eigenpair) -> (f64, f64, f64) {
        let at = |i: usize| pair.shape.get(i).map_or(0.0, |z| z.norm_sqr());
        (
            at(self.roll),
            at(self.steer),
            self.others.iter().map(|i| at(*i)).sum(),
        )
    }

    /// Share of roll and steer in the configuration, 0 to 1.
    fn lateral(&self, pair: &Eigenpair) -> f64 {
        let (roll, steer, others) = self.parts(pair);
        (roll + steer) / (roll + steer + others).max(f64::MIN_POSITIVE)
    }
}

/// Whether `pairs` show the ordinary pattern of the benchmark: one oscillation, two real modes.
pub(crate) fn ordinary(pairs: &[Eigenpair]) -> bool {
    pairs.len() == 4 && pairs.iter().filter(|p| p.value.im != 0.0).count() == 2
}

/// Names a set of modes by shape. Clear where one oscillation carries roll and steer and the real
/// modes differ in their steer share: at a speed well above that of the weave's birth. Carry names
/// to other speeds by `follow`.
pub fn name(pairs: &[Eigenpair], layout: &Layout) -> Vec<ModeName> {
    let mut names = vec![ModeName::Other; pairs.len()];
    // Lean tells weave from a wobble of the front assembly alone: weight by the roll share.
    let weave_score = |p: &Eigenpair| {
        let (roll, steer, _) = layout.parts(p);
        layout.lateral(p) * libm::sqrt(roll / (roll + steer).max(f64::MIN_POSITIVE))
    };
    let best = |names: &[ModeName],
                keep: &dyn Fn(&Eigenpair) -> bool,
                score: &dyn Fn(&Eigenpair) -> f64| {
        (0..pairs.len())
            .filter(|i| names[*i] == ModeName::Other && keep(&pairs[*i]))
            .max_by(|a, b| score(&pairs[*a]).total_cmp(&score(&pairs[*b])))
    };
    let take = |names: &mut [ModeName], i: usize, mode| {
        for (name, pair) in names.iter_mut().zip(pairs) {
            if pair.value == pairs[i].value || pair.value == pairs[i].value.conj() {
                *name = mode;
            }
        }
    };
    if let Some(i) = best(&names, &|p| p.value.im > 0.0, &weave_score) {
        take(&mut names, i, ModeName::Weave);
    }
    let real = |p: &Eigenpair| p.value.im == 0.0;
    let roll_share = |p: &Eigenpair| {
        let (roll, steer, _) = layout.parts(p);
        layout.lateral(p) * roll / (roll + steer).max(f64::MIN_POSITIVE)
    };
    let steer_share = |p: &Eigenpair| layout.lateral(p) - roll_share(p);
    if let Some(i) = best(&names, &real, &roll_share) {
        names[i] = ModeName::Capsize;
    }
    if let Some(i) = best(&names, &|p| real(p) && p.value.re < 0.0, &steer_share) {
        names[i] = ModeName::Caster;
    }
    names
}
