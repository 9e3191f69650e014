//! The extended plant: a bicycle with the mechanisms that a diagnosis accepted, as a file that every
//! command takes where it takes a bicycle.

use crate::body::Body;
use crate::hooks::Mechanism;
use crate::registry::{find, names};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use twinhub_linear::{Bicycle, BicycleError, Parameters};

/// A value with its uncertainty.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Estimate {
    pub value: f64,
    /// One standard deviation; absent where only a bound is known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sd: Option<f64>,
}

/// One accepted mechanism.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Accepted {
    pub name: String,
    /// Whether the residual in its equation became clean.
    pub confirmed: bool,
    pub parameters: BTreeMap<String, Estimate>,
}

/// The file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ExtendedPlant {
    pub schema_version: u32,
    /// Says what kind of file this is: `extended_plant`.
    pub kind: String,
    pub name: String,
    /// Study, rides and their hashes, tool and thresholds.
    pub provenance: String,
    /// Calibrated parameters of the benchmark bicycle, by the symbols of Meijaard et al. (2007).
    pub parameters: Parameters,
    #[serde(default)]
    pub mechanism: Vec<Accepted>,
    /// Covariance of all mechanism parameters, in the order of the list, row by row.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub covariance: Vec<Vec<f64>>,
}

/// Why an extended plant cannot be used.
#[non_exhaustive]
#[derive(Debug, thiserror::Error)]
pub enum ExtendedError {
    #[error("cannot read {}: {source}", path.display())]
    Read {
        path: PathBuf,
        source: std::io::Error,
    },
    #[error("{}: {message}", path.display())]
    Toml { path: PathBuf, message: String },
    #[error("{}: found {found}; accepted: {accepted}", path.display())]
    Value {
        path: PathBuf,
        found: String,
        accepted: String,
    },
    #[error("{}: {source}", path.display())]
    Bicycle {
        path: PathBuf,
        source: Box<BicycleError>,
    },
}

/// The word of `kind`.
pub const KIND: &str = "extended_plant";

impl ExtendedPlant {
    /// Whether a text is an extended plant, by its `kind`.
    pub fn is_one(text: &str) -> bool {
        toml::from_str::<toml::Table>(text)
            .is_ok_and(|t| t.get("kind").and_then(toml::Value::as_str) == Some(KIND))
    }

    /// Reads and checks a file.
    pub fn read(path: &Path) -> Result<Self, ExtendedError> {
        let text = std::fs::read_to_string(path).map_err(|source| ExtendedError::Read {
            path: path.to_owned(),
            source,
        })?;
        Self::parse(&text, path)
    }

    /// Parses and checks a text; `path` is for errors.
    pub fn parse(text: &str, path: &Path) -> Result<Self, ExtendedError> {
        let plant: Self = toml::from_str(text).map_err(|e| ExtendedError::Toml {
            path: path.to_owned(),
            message: e.to_string().trim_end().to_owned(),
        })?;
        let refuse = |found: String, accepted: String| {
            Err(ExtendedError::Value {
                path: path.to_owned(),
                found,
                accepted,
            })
        };
        if plant.schema_version != 1 || plant.kind != KIND {
            return refuse(
                format!(
                    "schema_version = {}, kind = \"{}\"",
                    plant.schema_version, plant.kind
                ),
                format!("schema_version = 1, kind = \"{KIND}\""),
            );
        }
        for accepted in &plant.mechanism {
            let Some(mechanism) = find(&accepted.name) else {
                return refuse(
                    format!("mechanism `{}`", accepted.name),
                    names().collect::<Vec<_>>().join(", "),
                );
            };
            let card = mechanism.card();
            for (name, estimate) in &accepted.parameters {
                let param = card.parameters.iter().find(|p| p.name == name);
                match param {
                    None => {
                        let all: Vec<&str> = card.parameters.iter().map(|p| p.name).collect();
                        return refuse(format!("{}.{name}", accepted.name), all.join(", "));
                    }
                    Some(p) if !(p.least..=p.most).contains(&estimate.value) => {
                        return refuse(
                            format!("{}.{name} = {}", accepted.name, estimate.value),
                            format!("{} to {}", p.least, p.most),
                        );
                    }
                    Some(_) => {}
                }
            }
        }
        plant.body().map_err(|source| ExtendedError::Bicycle {
            path: path.to_owned(),
            source: Box::new(source),
        })?;
        Ok(plant)
    }

    /// The text of the file.
    pub fn to_toml(&self) -> String {
        toml::to_string(self).unwrap_or_default()
    }

    /// The bicycle without its mechanisms.
    pub fn bicycle(&self) -> Result<Bicycle, BicycleError> {
        Bicycle::new(&self.name, &self.provenance, self.parameters)
    }

    /// Its mechanisms with their parameters in the order of their cards.
    pub fn mechanisms(&self) -> Vec<(&'static dyn Mechanism, Vec<f64>)> {
        let known = self
            .mechanism
            .iter()
            .filter_map(|a| Some((find(&a.name)?, a)));
        known
            .map(|(mechanism, accepted)| {
                let mut p = mechanism.null(&self.parameters);
                for (value, param) in p.iter_mut().zip(mechanism.card().parameters) {
                    if let Some(estimate) = accepted.parameters.get(param.name) {
                        *value = estimate.value;
                    }
                }
                (mechanism, p)
            })
            .collect()
    }

    /// The bicycle with what its mechanisms change in parameters and matrices.
    pub fn body(&self) -> Result<Body, BicycleError> {
        let mechanisms = self.mechanisms();
        let list: Vec<(&'static dyn Mechanism, &[f64])> =
            mechanisms.iter().map(|(m, p)| (*m, p.as_slice())).collect();
        Body::with(&self.bicycle()?, &list)
    }
}
