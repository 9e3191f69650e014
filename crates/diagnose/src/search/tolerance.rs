//! A calibration parameter that wants to lie beyond its declared tolerance, as a candidate like any
//! mechanism: it competes with them, and may turn out the same as one of them.

use twinhub_linear::Parameters;
use twinhub_mechanism::{Card, Equation, Family, Mechanism, Param};

/// The value of one symbol, free.
#[derive(Debug)]
struct Free {
    symbol: &'static str,
    card: Card,
}

/// What the names of such candidates begin with.
pub const PREFIX: &str = "tolerance:";

macro_rules! free {
    ($($symbol:ident),*) => {
        static ALL: &[&Free] = &[$({
            static PARAM: [Param; 1] = [Param {
                name: stringify!($symbol),
                null: f64::NAN,
                least: -1e4,
                most: 1e4,
                probe: 0.01,
                starts: &[],
                about: "value of the symbol",
            }];
            static F: Free = Free {
                symbol: stringify!($symbol),
                card: Card {
                    name: concat!("tolerance:", stringify!($symbol)),
                    family: Family::Structure,
                    equations: &[Equation::Steer, Equation::Roll],
                    claim: "a parameter lies beyond its declared tolerance",
                    equation: "the symbol's value, free",
                    source: "Meijaard et al. (2007), table 1",
                    parameters: &PARAM,
                    requires: &[],
                    confounded_with: &[],
                    separated_by: "measure the parameter again",
                },
            };
            &F
        }),*];
    };
}
free!(
    w, c, lam, rR, mR, IRxx, IRyy, xB, zB, mB, IBxx, IBzz, IBxz, xH, zH, mH, IHxx, IHzz, IHxz, rF,
    mF, IFxx, IFyy
);

/// The candidate of a symbol.
pub fn candidate(symbol: &str) -> Option<&'static dyn Mechanism> {
    ALL.iter()
        .find(|f| f.symbol == symbol)
        .map(|f| *f as &'static dyn Mechanism)
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
        ALL.iter()
            .find(|f| f.symbol == self.symbol)
            .map_or(&ALL[0].card, |f| &f.card)
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
