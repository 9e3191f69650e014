//! Weave speed by the thesis's own method beside that by linearisation.

use crate::assumed::{Assumed, Measured};
use crate::chapter3::benchmark_bicycle;
use crate::error::ReproduceError;
use crate::push;
use crate::stability::critical;
use serde::Serialize;
use twinhub_plant::multibody::{Case, Course, Parameters};

/// One bicycle by both methods.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Method {
    /// Which bicycle.
    pub name: &'static str,
    /// Weave speed of the linearised model, m/s.
    pub linearised_m_s: Option<f64>,
    /// Weave speed by four poles fitted to the response to a push, m/s.
    pub four_poles_m_s: Option<f64>,
}

impl Method {
    /// Difference over the linearised, percent; none where one of them does not exist.
    pub fn difference_percent(&self) -> Option<f64> {
        Some(100.0 * (self.four_poles_m_s? / self.linearised_m_s? - 1.0))
    }
}

/// Where the method is tried.
#[derive(Clone, Copy, Debug)]
pub struct Trial {
    /// Which bicycle.
    pub name: &'static str,
    bicycle: Which,
    pair_nm: f64,
}

#[derive(Clone, Copy, Debug)]
enum Which {
    Benchmark { tyres: bool },
    Case(Case, Measured),
    Chapter7,
}

const fn trial(name: &'static str, bicycle: Which, pair_nm: f64) -> Trial {
    Trial {
        name,
        bicycle,
        pair_nm,
    }
}

/// All trials.
pub const TRIALS: &[Trial] = &[
    trial("benchmark, no slip", Which::Benchmark { tyres: false }, 0.0),
    trial("benchmark on tyres", Which::Benchmark { tyres: true }, 0.0),
    trial(
        "case 1",
        Which::Case(Case::NoSlipRigid, Measured::At400N),
        0.0,
    ),
    trial(
        "case 2",
        Which::Case(Case::NoSlipPassive, Measured::At400N),
        0.0,
    ),
    trial(
        "case 3",
        Which::Case(Case::NoSlipArmMass, Measured::At400N),
        0.0,
    ),
    trial(
        "case 4",
        Which::Case(Case::NoSlipArmDamping, Measured::At400N),
        0.0,
    ),
    trial(
        "case 6",
        Which::Case(Case::TyresRigid, Measured::At400N),
        0.0,
    ),
    trial(
        "case 7, 400 N",
        Which::Case(Case::Full, Measured::At400N),
        0.0,
    ),
    trial(
        "case 7, 600 N",
        Which::Case(Case::Full, Measured::At600N),
        0.0,
    ),
    trial("chapter 7, pair of 40 Nm", Which::Chapter7, 40.0),
    trial("chapter 7, pair of 80 Nm", Which::Chapter7, 80.0),
];

impl Trial {
    /// The course, at 5 m/s.
    pub fn course(&self) -> Course {
        Course::pair(5.0, self.pair_nm)
    }

    /// The bicycle.
    ///
    /// # Errors
    /// If the benchmark's parameters are refused.
    pub fn parameters(&self, assumed: &Assumed) -> Result<Parameters, ReproduceError> {
        match self.bicycle {
            Which::Benchmark { tyres } => benchmark_bicycle(assumed, tyres),
            Which::Chapter7 => Ok(assumed.chapter7()),
            Which::Case(case, measured) => {
                let mut p = assumed.case(case);
                if matches!(case, Case::TyresRigid | Case::Full) {
                    assumed.fit_tyres(&mut p, measured, &|_| {});
                }
                Ok(p)
            }
        }
    }

    /// Both methods.
    ///
    /// # Errors
    /// Where the model has no steady state.
    pub fn run(&self, assumed: &Assumed) -> Result<Method, ReproduceError> {
        let p = self.parameters(assumed)?;
        let course = self.course();
        let speeds: Vec<f64> = (0..=8).map(|k| 3.5 + f64::from(k)).collect();
        Ok(Method {
            name: self.name,
            linearised_m_s: critical(&p, &course)?.weave_m_s,
            four_poles_m_s: push::weave_speed_m_s(&p, &course, &speeds)?,
        })
    }
}
