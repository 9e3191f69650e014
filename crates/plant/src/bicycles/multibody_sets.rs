//! Multibody bicycles that ship: each case of Bulsink (2017), table 3.3, for both bicycles, and the
//! benchmark of Meijaard et al. (2007) as a multibody model, without slip and on tyres.

use super::LoadError;
use crate::multibody::{BulsinkBicycle, Case, Parameters, Reading};
use crate::tyre;

/// The full model of the source's chapters 3 and 7.
pub const FULL: &str = "bulsink2017_bicycle1_full";

/// Options of the sets of Bulsink (2017).
const BULSINK_OPTIONS: &str = "products=adams|tensor, wheel_k=NUMBER, arms=torsional|linear, \
                               rider_height_m=NUMBER, rider_mass_kg=NUMBER, tyre=NAME";
/// Options of the other sets.
const TYRE_OPTION: &str = "tyre=NAME";

/// A set that ships.
#[derive(Clone, Debug)]
pub struct MultibodySet {
    /// Its name.
    pub name: String,
    /// One sentence, options included.
    pub about: String,
    kind: Kind,
}

#[derive(Clone, Copy, Debug)]
enum Kind {
    Bulsink(BulsinkBicycle, Case),
    Meijaard { tyres: bool },
}

/// Suffix and sentence of each case.
const CASES: [(&str, Case, &str); 8] = [
    ("case1", Case::NoSlipRigid, "no slip, rigid rider, no arms"),
    ("case2", Case::NoSlipPassive, "no slip, passive rider"),
    ("case3", Case::NoSlipArmMass, "no slip, forearms on the bar"),
    ("case4", Case::NoSlipArmDamping, "no slip, arm damping"),
    ("case5", Case::NoSlipArmStiffness, "no slip, arm stiffness"),
    ("case6", Case::TyresRigid, "tyres, rigid rider, no arms"),
    ("case7", Case::Full, "tyres, passive rider, arms"),
    ("full", Case::Full, "the same as case 7: everything"),
];

/// Every set.
pub fn all() -> Vec<MultibodySet> {
    let mut sets = Vec::new();
    for (number, bicycle) in [(1, BulsinkBicycle::One), (2, BulsinkBicycle::Two)] {
        for (suffix, case, about) in CASES {
            sets.push(MultibodySet {
                name: format!("bulsink2017_bicycle{number}_{suffix}"),
                about: format!(
                    "multibody, bicycle {number}: {about}; Bulsink (2017), tables 3.3 and A.1; options {BULSINK_OPTIONS}"
                ),
                kind: Kind::Bulsink(bicycle, case),
            });
        }
    }
    for (name, tyres, about) in [
        ("meijaard2007_multibody", false, "no slip"),
        ("meijaard2007_tyres", true, "tyres of Bulsink (2017)"),
    ] {
        sets.push(MultibodySet {
            name: name.to_owned(),
            about: format!(
                "multibody, benchmark bicycle of Meijaard et al. (2007), {about}; options {TYRE_OPTION}"
            ),
            kind: Kind::Meijaard { tyres },
        });
    }
    sets
}

/// The set of this name, without regard to case.
pub fn find(name: &str) -> Option<MultibodySet> {
    all()
        .into_iter()
        .find(|s| s.name.eq_ignore_ascii_case(name))
}

/// What the options of a set ask for.
#[derive(Default)]
struct Options {
    reading: Reading,
    tyre: Option<tyre::Tyre>,
}

impl MultibodySet {
    /// The parameters, with options `OPTION=VALUE,...`.
    pub fn build(&self, options: &str) -> Result<Parameters, LoadError> {
        let chosen = self.parse(options)?;
        let mut parameters = match self.kind {
            Kind::Bulsink(bicycle, case) => Parameters::bulsink2017(bicycle, case, &chosen.reading),
            Kind::Meijaard { tyres } => {
                let benchmark = twinhub_linear::Bicycle::load("meijaard2007_benchmark")?;
                let mut parameters = Parameters::from_whipple(&benchmark);
                if let Some(set) = tyre::set("bulsink2017").filter(|_| tyres) {
                    (parameters.tyre.rear, parameters.tyre.front) = (set.tyre, set.tyre);
                }
                parameters
            }
        };
        if let Some(tyre) = chosen.tyre {
            (parameters.tyre.rear, parameters.tyre.front) = (tyre, tyre);
        }
        parameters.name = if options.is_empty() {
            self.name.clone()
        } else {
            format!("{}:{options}", self.name)
        };
        parameters
            .validate()
            .map_err(|source| LoadError::Multibody {
                origin: parameters.name.clone(),
                source,
            })?;
        Ok(parameters)
    }

    fn parse(&self, options: &str) -> Result<Options, LoadError> {
        let mut chosen = Options::default();
        let bulsink = matches!(self.kind, Kind::Bulsink(..));
        for item in options.split(',').filter(|s| !s.is_empty()) {
            let wrong = || LoadError::Option {
                set: self.name.clone(),
                found: item.to_owned(),
                accepted: if bulsink {
                    BULSINK_OPTIONS
                } else {
                    TYRE_OPTION
                }
                .to_owned(),
            };
            let (key, value) = item.split_once('=').ok_or_else(wrong)?;
            let number = |low: f64, high: f64| {
                let value: f64 = value.trim().parse().map_err(|_| wrong())?;
                let in_range = value >= low && value <= high;
                in_range.then_some(value).ok_or_else(wrong)
            };
            let reading = &mut chosen.reading;
            match (key.trim(), value.trim()) {
                ("tyre", name) => chosen.tyre = Some(tyre::set(name).ok_or_else(wrong)?.tyre),
                _ if !bulsink => return Err(wrong()),
                ("products", "adams") => reading.products_by_footnote = true,
                ("products", "tensor") => reading.products_by_footnote = false,
                ("arms", "linear") => reading.linear_arms = true,
                ("arms", "torsional") => reading.linear_arms = false,
                ("wheel_k", _) => reading.wheel_inertia_ratio = number(0.01, 1.0)?,
                ("rider_height_m", _) => reading.rider_height_m = number(1.4, 2.1)?,
                ("rider_mass_kg", _) => reading.rider_mass_kg = number(40.0, 120.0)?,
                _ => return Err(wrong()),
            }
        }
        Ok(chosen)
    }
}
