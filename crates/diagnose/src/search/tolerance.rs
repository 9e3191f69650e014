//! A calibration parameter that wants to lie beyond its declared tolerance, as a candidate like any
//! mechanism: it competes with them, and may turn out the same as one of them.

use super::fitting::{self, Baseline, Calibrated};
use std::sync::{Mutex, PoisonError};
use twinhub_linear::Parameters;
use twinhub_mechanism::{Card, Equation, Family, Mechanism, Param};

/// The value of one symbol, free within what is left of belief.
#[derive(Debug)]
struct Free {
    symbol: &'static str,
    card: &'static Card,
}

/// What the names of such candidates begin with.
pub const PREFIX: &str = "tolerance:";
/// How far a value may lie from the declared one, in declared standard deviations: beyond the box of
/// the calibration, and not so far that a parameter can stand in for anything.
const FARTHEST_SD: f64 = 6.0;

/// Whether a candidate is a parameter out of tolerance.
pub fn is_candidate(mechanism: &dyn Mechanism) -> bool {
    mechanism.card().name.starts_with(PREFIX)
}

/// Whether the calibration still wants the candidate's parameter at the end of its tolerance or beyond:
/// one that only stood in for a cause that is found by now does not.
pub fn is_at_end(mechanism: &dyn Mechanism, baseline: &Baseline) -> bool {
    let symbol = mechanism.card().name.strip_prefix(PREFIX);
    let z = (baseline.all.iter().zip(&baseline.z)).find(|(c, _)| Some(c.symbol) == symbol);
    z.is_some_and(|(_, z)| fitting::is_at_end(*z))
}

/// How far a candidate's value lies from the declared one, in declared standard deviations; nothing for a
/// mechanism.
pub fn deviation_sd(mechanism: &dyn Mechanism, value: f64) -> Option<f64> {
    let param = &mechanism.card().parameters[0];
    let share = (value - param.least) / (param.most - param.least);
    is_candidate(mechanism).then_some(FARTHEST_SD * (2.0 * share - 1.0))
}

/// Candidates live as long as the program, as mechanisms do: one for each symbol and range.
static ALL: Mutex<Vec<&'static Free>> = Mutex::new(Vec::new());

/// The candidate of a symbol that was declared with a value and a standard deviation.
pub fn candidate(calibrated: &Calibrated) -> &'static dyn Mechanism {
    let Calibrated { symbol, value, sd } = *calibrated;
    let (least, most) = (value - FARTHEST_SD * sd, value + FARTHEST_SD * sd);
    let mut all = ALL.lock().unwrap_or_else(PoisonError::into_inner);
    let same = |f: &&&'static Free| {
        let param = &f.card.parameters[0];
        f.symbol == symbol && param.least == least && param.most == most
    };
    if let Some(known) = all.iter().find(same) {
        return *known;
    }
    let param = Param {
        name: symbol,
        null: f64::NAN,
        least,
        most,
        probe: 0.01,
        starts: &[],
        about: "value of the symbol",
    };
    let free: &'static Free = Box::leak(Box::new(Free {
        symbol,
        card: Box::leak(Box::new(Card {
            name: Box::leak(format!("{PREFIX}{symbol}").into_boxed_str()),
            family: Family::Structure,
            equations: &[Equation::Steer, Equation::Roll],
            claim: "a parameter lies beyond its declared tolerance",
            equation: "the symbol's value, free within six declared standard deviations",
            source: "Meijaard et al. (2007), table 1",
            parameters: Box::leak(Box::new([param])),
            requires: &[],
            confounded_with: &[],
            separated_by: "measure the parameter again",
        })),
    }));
    all.push(free);
    free
}

fn probe(value: f64) -> f64 {
    if value == 0.0 {
        0.01
    } else {
        0.01 * value.abs()
    }
}

impl Mechanism for Free {
    fn card(&self) -> &'static Card {
        self.card
    }

    fn null(&self, bicycle: &Parameters) -> Vec<f64> {
        vec![bicycle.get(self.symbol).unwrap_or(f64::NAN)]
    }

    fn probes(&self, bicycle: &Parameters) -> Vec<Vec<f64>> {
        let value = self.null(bicycle)[0];
        vec![vec![value + probe(value)]]
    }

    fn from_probes(&self, c: &[f64], bicycle: &Parameters) -> Vec<f64> {
        let value = self.null(bicycle)[0];
        vec![value + c[0] * probe(value)]
    }

    fn reshape(&self, p: &[f64], bicycle: &mut Parameters) {
        // A value that cannot be is refused when the bicycle is checked as a whole.
        let _ = bicycle.set(self.symbol, p[0]);
    }
}
