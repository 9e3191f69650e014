//! From names to values: of everything in a course that may be named or written out.

use crate::choice::Choice;
use crate::error::SetupError;
use crate::shipped::{self, Shipped};
use serde::de::DeserializeOwned;
use std::path::Path;
use twinhub_plant::motor::{self, PowerTrainParameters};
use twinhub_plant::road::Road;
use twinhub_plant::sensor::{self, SuiteParameters};
use twinhub_plant::wind::Wind;

/// The places of a course that hold such a choice; the bicycle's changes go a way of their own.
pub(crate) const PLACES: [&str; 4] = [
    "motors",
    "sensors",
    "plant.multibody.road",
    "plant.multibody.wind",
];

/// The values that `name` has at one of [`PLACES`], as TOML.
pub(crate) fn expanded(place: &str, name: &str) -> Result<toml::Value, SetupError> {
    let named = || name.to_owned();
    let value = match place {
        "motors" => toml::Value::try_from(motors(&Choice::Named(named()))?),
        "sensors" => toml::Value::try_from(sensors(&Choice::Named(named()))?),
        "plant.multibody.road" => toml::Value::try_from(road(&Choice::Named(named()))?),
        _ => toml::Value::try_from(wind(&Choice::Named(named()))?),
    };
    value.map_err(|e| SetupError::Format {
        origin: place.into(),
        detail: e.to_string(),
    })
}

/// Motor drives and battery.
pub(crate) fn motors(
    choice: &Choice<PowerTrainParameters>,
) -> Result<PowerTrainParameters, SetupError> {
    from_sets("motor set", choice, motor::sets::named, motor::sets::SETS)
}

/// Sensors and their faults.
pub(crate) fn sensors(choice: &Choice<SuiteParameters>) -> Result<SuiteParameters, SetupError> {
    from_sets(
        "sensor suite",
        choice,
        sensor::sets::named,
        sensor::sets::SUITES,
    )
}

/// A road.
pub(crate) fn road(choice: &Choice<Road>) -> Result<Road, SetupError> {
    from_files("road", choice, shipped::ROADS)
}

/// A wind.
pub(crate) fn wind(choice: &Choice<Wind>) -> Result<Wind, SetupError> {
    from_files("wind", choice, shipped::WINDS)
}

fn from_sets<T: Clone + DeserializeOwned>(
    kind: &'static str,
    choice: &Choice<T>,
    named: fn(&str) -> Option<T>,
    sets: &[(&'static str, &str)],
) -> Result<T, SetupError> {
    let name = match choice {
        Choice::Given(values) => return Ok((**values).clone()),
        Choice::Named(name) => name,
    };
    match named(name) {
        Some(set) => Ok(set),
        None => {
            let shipped = sets.iter().map(|(name, _)| *name).collect();
            read(kind, name, shipped)
        }
    }
}

fn from_files<T: Clone + DeserializeOwned>(
    kind: &'static str,
    choice: &Choice<T>,
    table: &[Shipped],
) -> Result<T, SetupError> {
    let name = match choice {
        Choice::Given(values) => return Ok((**values).clone()),
        Choice::Named(name) => name,
    };
    match table.iter().find(|file| file.name == name.as_str()) {
        Some(file) => parsed(&format!("{kind} `{name}`"), file.text),
        None => read(kind, name, shipped::names(table)),
    }
}

fn read<T: DeserializeOwned>(
    kind: &'static str,
    name: &str,
    shipped: Vec<&'static str>,
) -> Result<T, SetupError> {
    let path = Path::new(name);
    if !path.exists() {
        return Err(SetupError::NotFound {
            kind,
            found: name.into(),
            shipped,
        });
    }
    let text = std::fs::read_to_string(path).map_err(|source| SetupError::Unreadable {
        path: path.into(),
        source,
    })?;
    parsed(name, &text)
}

/// A file strictly, its name in the message.
pub(crate) fn parsed<T: DeserializeOwned>(origin: &str, text: &str) -> Result<T, SetupError> {
    toml::from_str(text).map_err(|e| SetupError::Format {
        origin: origin.into(),
        detail: e.to_string().trim_end().to_owned(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn everything_that_ships_resolves_and_is_valid() {
        for file in shipped::ROADS {
            let road = road(&Choice::Named(file.name.into())).expect(file.name);
            road.validate().expect(file.name);
        }
        for file in shipped::WINDS {
            let wind = wind(&Choice::Named(file.name.into())).expect(file.name);
            wind.validate().expect(file.name);
        }
        for (name, _) in motor::sets::SETS {
            motors(&Choice::Named((*name).into())).expect(name);
        }
        let error = road(&Choice::Named("mud".into())).expect_err("no such road");
        assert!(error.to_string().contains("dry, wet"), "{error}");
    }
}
