//! Which sets a suite is made of.

use crate::gates;
use serde::{Deserialize, Serialize};
use twinhub_hidden::random::Stream;
use twinhub_hidden::{Kind, Scenario};

/// One set of the suite.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Planned {
    pub kind: String,
    pub seed: u64,
    /// Sizes of its effects in multiples of the printed limit.
    pub multiples: Vec<f64>,
    /// Whether the model told the truth is asked too.
    pub oracle: bool,
}

/// The sets of a suite of this size, of these kinds.
pub fn plan(size: usize, seed: u64, kinds: &[Kind]) -> Vec<Planned> {
    let mut sets = vec![];
    for kind in kinds {
        let share = match kind {
            Kind::Clean => gates::SHARE_CLEAN + gates::OWN_CLEAN,
            Kind::OneEffect => gates::SHARE_ONE,
            Kind::TwoEffects => gates::SHARE_TWO,
            Kind::Outside => gates::SHARE_OUTSIDE,
            Kind::Mismatched => gates::OWN_MISMATCHED,
            Kind::Shifted | Kind::Mixed => gates::OWN_CONTROL,
            Kind::Confounded => gates::OWN_CONFOUNDED,
        };
        let count = ((size as f64 * share).round() as usize).max(1);
        sets.extend(
            (0..count).map(|k| planned(*kind, seed.wrapping_mul(1_000_003).wrapping_add(k as u64))),
        );
    }
    sets
}

/// The set of this kind and seed, with the sizes that the seed gives it.
pub fn planned(kind: Kind, seed: u64) -> Planned {
    let mut pick = Stream::new(seed, "multiples");
    let effects = Scenario::new(kind, seed).hidden.len();
    let [low, high] = gates::TWO_MULTIPLES;
    let one = |pick: &mut Stream| match kind {
        Kind::OneEffect => gates::MULTIPLES[pick.index(gates::MULTIPLES.len())],
        _ => pick.between(low, high),
    };
    let multiples: Vec<f64> = (0..effects).map(|_| one(&mut pick)).collect();
    Planned {
        kind: kind.name().to_owned(),
        seed,
        oracle: kind == Kind::OneEffect && multiples.iter().all(|m| *m >= gates::FIRST_FROM),
        multiples,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_full_suite_is_as_designed() {
        let sets = plan(300, 1, &Kind::ALL);
        let count = |kind: Kind| sets.iter().filter(|s| s.kind == kind.name()).count();
        assert_eq!(count(Kind::Clean), 375);
        assert_eq!(count(Kind::OneEffect), 135);
        assert_eq!(count(Kind::TwoEffects) + count(Kind::Outside), 90);
        let mut seeds: Vec<_> = sets.iter().map(|s| (&s.kind, s.seed)).collect();
        seeds.sort();
        seeds.dedup();
        assert_eq!(seeds.len(), sets.len());
        assert!(
            sets.iter()
                .all(|s| s.kind != "one_effect" || s.multiples.len() == 1)
        );
    }
}
