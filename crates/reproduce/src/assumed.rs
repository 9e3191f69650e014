//! The one set of assumptions behind every row, and the others that it was chosen from.
//!
//! Table A.1 leaves room (see [`Reading`]), and so does the tyre: the file's friction is 1.642, the
//! road's 1.0, and the printed equations have no combined slip. [`Assumed::default`] is used for
//! all rows; [`Assumed::all`] are the named alternatives that `twinhub reproduce --readings` counts
//! met rows for. Nothing is fitted.

use std::fmt;
use twinhub_plant::multibody::{BulsinkBicycle, Case, Parameters, Reading};
use twinhub_plant::tyre::{self, Combined, Friction, MagicFormula, Tyre};

/// What limits the tyres' forces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Grip {
    /// The tyre file's 1.642 times the road's 1.0, no combined slip: the printed equations.
    AsFile,
    /// The road's 1.0 alone, and the friction ellipse.
    Ellipse,
}

/// Load at which the tyres were measured, as the source has it in case 7.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Measured {
    /// Table A3 as printed: measured at 400 N, coefficients follow the load.
    At400N,
    /// Table A3 taken to 600 N by its own load dependence, and held there.
    At600N,
}

/// A reading of everything that the source leaves open.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Assumed {
    /// Table A.1.
    pub reading: Reading,
    /// Tyres.
    pub grip: Grip,
    /// Tyres of chapter 7, which does not say. Its weave speed with one motor, 8.34 m/s, is that of
    /// case 7 on the tyres measured at 600 N (8.3), not on those measured at 400 N (9.7).
    pub chapter7: Measured,
    /// True: each miss is followed by a search for what would meet it.
    pub explain_misses: bool,
}

impl Default for Assumed {
    fn default() -> Self {
        Self {
            reading: Reading::default(),
            grip: Grip::AsFile,
            chapter7: Measured::At600N,
            explain_misses: true,
        }
    }
}

impl Assumed {
    /// Every combination of the named options.
    pub fn all() -> Vec<Self> {
        let mut all = Vec::new();
        for products_by_footnote in [true, false] {
            for wheel_inertia_ratio in [0.43, 0.45, 0.47] {
                for linear_arms in [false, true] {
                    for grip in [Grip::AsFile, Grip::Ellipse] {
                        for chapter7 in [Measured::At400N, Measured::At600N] {
                            let reading = Reading {
                                products_by_footnote,
                                wheel_inertia_ratio,
                                linear_arms,
                                ..Reading::default()
                            };
                            all.push(Self {
                                reading,
                                grip,
                                chapter7,
                                explain_misses: true,
                            });
                        }
                    }
                }
            }
        }
        all
    }

    /// Bicycle 1 in a case of table 3.3.
    pub fn case(&self, case: Case) -> Parameters {
        let mut parameters = Parameters::bulsink2017(BulsinkBicycle::One, case, &self.reading);
        if matches!(case, Case::TyresRigid | Case::Full) {
            self.fit_tyres(&mut parameters, Measured::At400N, &|_| {});
        }
        parameters
    }

    /// Bicycle 1 of chapter 7: case 7.
    pub fn chapter7(&self) -> Parameters {
        let mut parameters = self.case(Case::Full);
        self.fit_tyres(&mut parameters, self.chapter7, &|_| {});
        parameters
    }

    /// Puts the source's tyres on both wheels, changed by `change`.
    pub fn fit_tyres(
        &self,
        parameters: &mut Parameters,
        measured: Measured,
        change: &dyn Fn(&mut MagicFormula),
    ) {
        let name = match measured {
            Measured::At400N => "bulsink2017",
            Measured::At600N => "bulsink2017_600n",
        };
        if let Some(Tyre::MagicFormula(mut tyre)) = tyre::set(name).map(|set| set.tyre) {
            if self.grip == Grip::Ellipse {
                tyre.friction = Friction::Absolute;
                tyre.combined = Combined::Ellipse;
            }
            change(&mut tyre);
            parameters.tyre.rear = Tyre::MagicFormula(tyre);
            parameters.tyre.front = Tyre::MagicFormula(tyre);
        }
    }
}

impl fmt::Display for Assumed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "products of inertia {}, wheel inertia {:.2} m R², {} arms, {}, tyres of chapter 7 as measured at {} N",
            if self.reading.products_by_footnote {
                "by the footnote of table A.1"
            } else {
                "as the usual tensor"
            },
            self.reading.wheel_inertia_ratio,
            if self.reading.linear_arms {
                "linear"
            } else {
                "torsional"
            },
            match self.grip {
                Grip::AsFile => "friction 1.642 of the tyre file without combined slip",
                Grip::Ellipse => "friction 1.0 of the road with the friction ellipse",
            },
            if self.chapter7 == Measured::At400N {
                400
            } else {
                600
            }
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_set_that_is_used_is_one_of_the_named() {
        let all = Assumed::all();
        assert_eq!(all.len(), 48);
        assert_eq!(all.iter().filter(|a| **a == Assumed::default()).count(), 1);
        let mut names: Vec<String> = all.iter().map(Assumed::to_string).collect();
        names.sort();
        names.dedup();
        assert_eq!(names.len(), 48, "each has words of its own");
    }
}
