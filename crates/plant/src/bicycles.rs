//! Whatever bicycle a user names: a linear one by Whipple and Carvallo, or a multibody one.
//!
//! Every command takes the same names: sets that ship ([`twinhub_linear::sets::NAMES`] and
//! [`multibody_sets::all`]), each with options as `NAME:OPTION=VALUE,...`; files (a bicycle TOML of
//! `twinhub_linear`, a BicycleParameters `*Benchmark.txt`, `BICYCLE+RIDER`, or a plant TOML as
//! [`Parameters::to_toml`] writes it). Assignments `KEY=VALUE` take symbols of Meijaard et al.
//! (2007) for the first kind, dotted paths of the plant file for the second.

pub mod multibody_sets;

use crate::multibody::{MultibodyError, Parameters};
use std::path::{Path, PathBuf};
use twinhub_linear::BicycleError;

/// A bicycle of either kind.
#[derive(Clone, Debug, PartialEq)]
pub enum Bicycle {
    /// The 25 parameters of a Whipple-Carvallo bicycle.
    Benchmark(Box<twinhub_linear::Bicycle>),
    /// The multibody model's.
    Multibody(Box<Parameters>),
}

/// Why a bicycle cannot be had.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum LoadError {
    /// Neither a set that ships nor a file.
    #[error(
        "no bicycle `{found}`: neither a set that ships ({}) nor an existing file (a bicycle or \
         plant `.toml`, or a BicycleParameters `*Benchmark.txt`)",
        names().join(", ")
    )]
    Unknown {
        /// What was asked for.
        found: String,
    },
    /// An option of a set is wrong.
    #[error("bicycle `{set}`: option `{found}`; accepted: {accepted}")]
    Option {
        /// The set.
        set: String,
        /// As given.
        found: String,
        /// What would be accepted.
        accepted: String,
    },
    /// A linear bicycle is refused.
    #[error(transparent)]
    Benchmark(#[from] BicycleError),
    /// A file cannot be read.
    #[error("cannot read bicycle file {}: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// A plant file is refused.
    #[error("{origin}: {source}")]
    Multibody {
        /// The file or the set.
        origin: String,
        /// Why.
        source: MultibodyError,
    },
    /// A `KEY=VALUE` is wrong.
    #[error("--set {assignment}: {detail}")]
    Assignment {
        /// As given.
        assignment: String,
        /// What is wrong.
        detail: String,
    },
}

/// The names of everything that ships, linear sets first.
pub fn names() -> Vec<String> {
    let linear = twinhub_linear::sets::NAMES.iter().map(|n| (*n).to_owned());
    linear
        .chain(multibody_sets::all().into_iter().map(|set| set.name))
        .collect()
}

/// One sentence about a set that ships.
pub fn describe(name: &str) -> Option<String> {
    twinhub_linear::sets::describe(name)
        .map(str::to_owned)
        .or_else(|| multibody_sets::find(name).map(|set| set.about))
}

/// The bicycle that `spec` names, with `assignments` (`KEY=VALUE`) applied.
pub fn load<S: AsRef<str>>(spec: &str, assignments: &[S]) -> Result<Bicycle, LoadError> {
    match named(spec)? {
        Bicycle::Benchmark(bicycle) => {
            if let Some(dotted) = assignments
                .iter()
                .map(AsRef::as_ref)
                .find(|a| a.split('=').next().is_some_and(|key| key.contains('.')))
            {
                return Err(LoadError::Assignment {
                    assignment: dotted.to_owned(),
                    detail: format!(
                        "`{}` is a linear bicycle, with symbols instead of paths ({}); dotted paths \
                         belong to multibody bicycles such as `{}`",
                        bicycle.name,
                        twinhub_linear::SYMBOLS.join(", "),
                        multibody_sets::FULL,
                    ),
                });
            }
            Ok(Bicycle::Benchmark(Box::new(bicycle.with(assignments)?)))
        }
        Bicycle::Multibody(parameters) => {
            Ok(Bicycle::Multibody(Box::new(parameters.with(assignments)?)))
        }
    }
}

/// The multibody bicycle that `spec` names; of a linear one the same without slip and with a
/// rigid rider ([`Parameters::from_whipple`]).
pub fn load_multibody<S: AsRef<str>>(
    spec: &str,
    assignments: &[S],
) -> Result<Parameters, LoadError> {
    match named(spec)? {
        Bicycle::Benchmark(bicycle) => Parameters::from_whipple(&bicycle).with(assignments),
        Bicycle::Multibody(parameters) => parameters.with(assignments),
    }
}

fn named(spec: &str) -> Result<Bicycle, LoadError> {
    let (name, options) = spec.split_once(':').unwrap_or((spec, ""));
    if let Some(set) = multibody_sets::find(name) {
        return Ok(Bicycle::Multibody(Box::new(set.build(options)?)));
    }
    let path = Path::new(spec);
    let toml = path
        .extension()
        .is_some_and(|e| e.eq_ignore_ascii_case("toml"));
    if toml && path.is_file() {
        let text = std::fs::read_to_string(path).map_err(|source| LoadError::Read {
            path: path.to_owned(),
            source,
        })?;
        if is_plant_file(&text) {
            let parameters =
                Parameters::from_toml(&text).map_err(|source| LoadError::Multibody {
                    origin: path.display().to_string(),
                    source,
                })?;
            return Ok(Bicycle::Multibody(Box::new(parameters)));
        }
    }
    match twinhub_linear::Bicycle::load(spec) {
        Ok(bicycle) => Ok(Bicycle::Benchmark(Box::new(bicycle))),
        Err(BicycleError::UnknownBicycle { found }) => Err(LoadError::Unknown { found }),
        Err(error) => Err(error.into()),
    }
}

/// A file of the linear kind has a table of symbols, or says which version of that format it is.
/// Anything else that is TOML is meant for the multibody model; so is what does not parse and
/// speaks of its tables.
fn is_plant_file(text: &str) -> bool {
    match text.parse::<toml::Table>() {
        Ok(table) => !table.contains_key("schema_version") && !table.contains_key("parameters"),
        Err(_) => text.contains("[geometry]") || text.contains("gravity_m_s2"),
    }
}

impl Bicycle {
    /// Its name.
    pub fn name(&self) -> &str {
        match self {
            Self::Benchmark(b) => &b.name,
            Self::Multibody(p) => &p.name,
        }
    }

    /// Where its values come from.
    pub fn source(&self) -> &str {
        match self {
            Self::Benchmark(b) => &b.source,
            Self::Multibody(p) => &p.source,
        }
    }

    /// The file that loads as this bicycle again, without loss.
    pub fn to_toml(&self) -> String {
        match self {
            Self::Benchmark(b) => b.to_toml(),
            Self::Multibody(p) => p.to_toml(),
        }
    }
}

#[cfg(test)]
mod tests;
