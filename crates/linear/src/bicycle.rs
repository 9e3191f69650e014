//! A bicycle: its parameters, where they come from, and how sure they are.

use crate::added::{Added, NamedMechanism};
use crate::error::BicycleError;
use crate::parameters::{Parameters, SYMBOLS};
use std::collections::BTreeMap;
use std::path::Path;

/// A named parameter set.
#[derive(Debug, Clone, PartialEq)]
pub struct Bicycle {
    /// Publication name, or the stem of the file.
    pub name: String,
    /// Where the values come from.
    pub source: String,
    /// The values.
    pub parameters: Parameters,
    /// One standard deviation by symbol, where the source gives it.
    pub standard_deviations: BTreeMap<&'static str, f64>,
    /// What is doubtful about the values, or was chosen in reading them.
    pub remarks: Vec<String>,
    /// What it has beyond rigid bodies.
    pub added: Added,
    /// Causes that a diagnosis accepted.
    pub mechanisms: Vec<NamedMechanism>,
}

/// The schema of a bicycle file.
#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    schema_version: u32,
    name: String,
    source: String,
    parameters: Parameters,
    #[serde(default)]
    standard_deviations: BTreeMap<String, f64>,
    #[serde(default)]
    added: Added,
    #[serde(default)]
    mechanism: Vec<NamedMechanism>,
}

impl Bicycle {
    /// A checked bicycle.
    pub fn new(name: &str, source: &str, parameters: Parameters) -> Result<Self, BicycleError> {
        let remarks = parameters.validate()?;
        Ok(Self {
            name: name.to_owned(),
            source: source.to_owned(),
            parameters,
            standard_deviations: BTreeMap::new(),
            remarks,
            added: Added::NONE,
            mechanisms: vec![],
        })
    }

    /// The value of a symbol of Meijaard et al. 2007, SI.
    pub fn get(&self, symbol: &str) -> Option<f64> {
        self.parameters.get(symbol)
    }

    /// Sets a value by its symbol; call `validate` after the last one.
    pub fn set(&mut self, symbol: &str, value: f64) -> Result<(), BicycleError> {
        self.parameters.set(symbol, value)
    }

    /// Applies `SYMBOL=NUMBER` assignments and checks the result.
    pub fn with<S: AsRef<str>>(mut self, assignments: &[S]) -> Result<Self, BicycleError> {
        for text in assignments.iter().map(AsRef::as_ref) {
            let bad = || BicycleError::Assignment {
                found: text.to_owned(),
            };
            let (symbol, value) = text.split_once('=').ok_or_else(bad)?;
            self.set(symbol.trim(), value.trim().parse().map_err(|_| bad())?)?;
            self.remarks.push(format!("set by hand: {}", text.trim()));
        }
        self.validate()?;
        Ok(self)
    }

    /// Checks the values as a whole; gives remarks on what is doubtful.
    pub fn validate(&self) -> Result<Vec<String>, BicycleError> {
        self.parameters.validate()
    }

    /// Reads the text of a bicycle file (`schema_version`, `name`, `source`, `[parameters]` with
    /// every symbol, optional `[standard_deviations]`, `[added]` matrices and `[[mechanism]]`).
    pub fn from_toml(text: &str, path: &Path) -> Result<Self, BicycleError> {
        let toml = |message: String| BicycleError::Toml {
            path: path.to_owned(),
            message,
        };
        let file: File =
            toml::from_str(text).map_err(|e| toml(e.to_string().trim_end().to_owned()))?;
        if file.schema_version != 1 {
            return Err(toml(format!(
                "schema_version = {}: accepted: 1",
                file.schema_version
            )));
        }
        let in_file = |source| BicycleError::InFile {
            path: path.to_owned(),
            source: Box::new(source),
        };
        let mut bicycle = Self::new(&file.name, &file.source, file.parameters).map_err(in_file)?;
        if !file.added.is_finite() {
            return Err(toml("added: accepted: finite numbers".to_owned()));
        }
        bicycle.added = file.added;
        for mechanism in &file.mechanism {
            bicycle
                .remarks
                .push(format!("extended by {}", mechanism.name));
        }
        bicycle.mechanisms = file.mechanism;
        for (symbol, sd) in &file.standard_deviations {
            let Some(known) = SYMBOLS.iter().find(|s| *s == symbol) else {
                return Err(in_file(BicycleError::UnknownSymbol {
                    found: symbol.clone(),
                    hint: String::new(),
                }));
            };
            if !(sd.is_finite() && *sd >= 0.0) {
                return Err(in_file(BicycleError::Value {
                    symbol: symbol.clone(),
                    value: *sd,
                    accepted: "a standard deviation of at least 0",
                }));
            }
            bicycle.standard_deviations.insert(known, *sd);
        }
        Ok(bicycle)
    }

    /// The text of a bicycle file, which `load` reads back without loss.
    pub fn to_toml(&self) -> String {
        let quote = |s: &str| toml::Value::String(s.to_owned()).to_string();
        let mut text = format!(
            "schema_version = 1\nname = {}\nsource = {}\n\n[parameters]\n",
            quote(&self.name),
            quote(&self.source)
        );
        for symbol in SYMBOLS {
            text += &format!("{symbol} = {:?}\n", self.get(symbol).unwrap_or(f64::NAN));
        }
        if !self.standard_deviations.is_empty() {
            text += "\n[standard_deviations]\n";
            for (symbol, sd) in &self.standard_deviations {
                text += &format!("{symbol} = {sd:?}\n");
            }
        }
        if self.added != Added::NONE {
            text += &format!(
                "\n[added]\nmass_kg_m2 = {:?}\ndamping_nms_rad = {:?}\nstiffness_nm_rad = {:?}\n",
                self.added.mass_kg_m2, self.added.damping_nms_rad, self.added.stiffness_nm_rad
            );
        }
        for mechanism in &self.mechanisms {
            let table = toml::to_string(mechanism).unwrap_or_default();
            // Sub-tables belong to this entry of the list.
            let table = table.replace("\n[", "\n[mechanism.");
            text += &format!("\n[[mechanism]]\n{table}");
        }
        text
    }
}
