//! Everything that has a name and a file, by kind: what ships, and its values with changes, as TOML.
//!
//! For front ends that treat all of them alike; a ride itself takes them by [`Ride::load`](crate::Ride::load).

use crate::choice::Choice;
use crate::error::SetupError;
use crate::overrides::{Override, apply};
use crate::scenario::Scenario;
use crate::{resolve, setup, shipped};
use serde::Serialize;
use serde::de::DeserializeOwned;
use twinhub_plant::bicycles;
use twinhub_plant::motor::{self, PowerTrain, PowerTrainParameters};
use twinhub_plant::rider::RiderFile;
use twinhub_plant::road::Road;
use twinhub_plant::sensor::{self, SensorSuite, SuiteParameters};
use twinhub_plant::tyre::{self, TyreModel as _};
use twinhub_plant::wind::Wind;

/// The kinds.
pub const KINDS: [&str; 10] = [
    "bicycle", "course", "law", "motors", "rider", "road", "scenario", "sensors", "tyre", "wind",
];

fn no_kind(kind: &str) -> SetupError {
    SetupError::NotFound {
        kind: "kind",
        found: kind.into(),
        shipped: KINDS.to_vec(),
    }
}

/// Names of what ships of a kind.
///
/// # Errors
/// If there is no such kind.
pub fn names(kind: &str) -> Result<Vec<String>, SetupError> {
    let files = |table: &[shipped::Shipped]| -> Vec<String> {
        table.iter().map(|file| file.name.to_owned()).collect()
    };
    let pairs = |list: &[(&str, &str)]| -> Vec<String> {
        list.iter().map(|(name, _)| (*name).to_owned()).collect()
    };
    Ok(match kind {
        "bicycle" => bicycles::names(),
        "course" => files(shipped::COURSES),
        "law" => files(shipped::LAWS),
        "motors" => pairs(motor::sets::SETS),
        "rider" => files(shipped::RIDERS),
        "road" => files(shipped::ROADS),
        "scenario" => files(shipped::SCENARIOS),
        "sensors" => pairs(sensor::sets::SUITES),
        "tyre" => tyre::SETS.iter().map(|set| set.name.to_owned()).collect(),
        "wind" => files(shipped::WINDS),
        other => return Err(no_kind(other)),
    })
}

/// The values of `name` (a name that ships, or a file) with `assignments` (`path=value`), as TOML.
///
/// # Errors
/// If there is none, an assignment is wrong, or a number is out of range.
pub fn toml(kind: &str, name: &str, assignments: &[String]) -> Result<String, SetupError> {
    let named = || name.to_owned();
    let bad = |detail: String| SetupError::Format {
        origin: format!("{kind} `{name}`"),
        detail,
    };
    let said = |e: &dyn std::error::Error| bad(e.to_string());
    match kind {
        "bicycle" => bicycles::load(name, assignments)
            .map(|bicycle| bicycle.to_toml())
            .map_err(|e| said(&e)),
        "course" => {
            crate::Ride::load(name, assignments).and_then(|ride| written(kind, name, &ride.course))
        }
        "law" => written(kind, name, &setup::load_law(name, assignments)?),
        "motors" => {
            let set = resolve::motors(&Choice::Named(named()))?;
            let set: PowerTrainParameters = changed(kind, name, &set, assignments)?;
            PowerTrain::new(&set).map_err(|e| said(&e))?;
            written(kind, name, &set)
        }
        "rider" => {
            let rider: RiderFile = changed(kind, name, &setup::load_rider(name)?, assignments)?;
            rider.validate().map_err(|e| said(&e))?;
            written(kind, name, &rider)
        }
        "road" => {
            let road = resolve::road(&Choice::Named(named()))?;
            let road: Road = changed(kind, name, &road, assignments)?;
            road.validate().map_err(|e| said(&e))?;
            written(kind, name, &road)
        }
        "scenario" => written(kind, name, &Scenario::load(name, assignments)?),
        "sensors" => {
            let suite = resolve::sensors(&Choice::Named(named()))?;
            let suite: SuiteParameters = changed(kind, name, &suite, assignments)?;
            SensorSuite::new(&suite, 0).map_err(|e| said(&e))?;
            written(kind, name, &suite)
        }
        "tyre" => {
            let set = tyre::set(name).ok_or_else(|| SetupError::NotFound {
                kind: "tyre",
                found: name.into(),
                shipped: tyre::SETS.iter().map(|set| set.name).collect(),
            })?;
            let tyre: tyre::Tyre = changed(kind, name, &set.tyre, assignments)?;
            tyre.validate().map_err(|e| said(&e))?;
            written(kind, name, &tyre)
        }
        "wind" => {
            let wind = resolve::wind(&Choice::Named(named()))?;
            let wind: Wind = changed(kind, name, &wind, assignments)?;
            wind.validate().map_err(|e| said(&e))?;
            written(kind, name, &wind)
        }
        other => Err(no_kind(other)),
    }
}

fn changed<T: Clone + Serialize + DeserializeOwned>(
    kind: &str,
    name: &str,
    value: &T,
    assignments: &[String],
) -> Result<T, SetupError> {
    if assignments.is_empty() {
        return Ok(value.clone());
    }
    let format = |detail: String| SetupError::Format {
        origin: format!("{kind} `{name}`"),
        detail,
    };
    let mut tree = toml::Value::try_from(value).map_err(|e| format(e.to_string()))?;
    let mut doubts = Vec::new();
    for text in assignments {
        // As a ride has them: paths of its rider begin with `rider.`.
        let o = match kind {
            "rider" => Override::parse(&format!("rider.{text}"))?,
            _ => Override::parse(text)?,
        };
        doubts.extend(apply(&mut tree, &o)?);
    }
    tree.try_into().map_err(|e: toml::de::Error| {
        let otherwise = format(format!(
            "{}: {}",
            assignments.join(", "),
            e.to_string().trim_end()
        ));
        doubts.into_iter().next().unwrap_or(otherwise)
    })
}

fn written(kind: &str, name: &str, value: &impl Serialize) -> Result<String, SetupError> {
    toml::to_string(value).map_err(|e| SetupError::Format {
        origin: format!("{kind} `{name}`"),
        detail: e.to_string(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn everything_that_ships_can_be_written() {
        for kind in KINDS {
            for name in names(kind).expect(kind) {
                let text =
                    super::toml(kind, &name, &[]).unwrap_or_else(|e| panic!("{kind} {name}: {e}"));
                assert!(text.parse::<toml::Table>().is_ok(), "{kind} {name}");
            }
        }
    }

    #[test]
    fn changes_are_taken_and_typos_refused() {
        let set = |text: &str| vec![text.to_owned()];
        let road = super::toml("road", "dry", &set("friction_ratio=0.5")).expect("legal");
        assert!(road.contains("friction_ratio = 0.5"), "{road}");
        let error = super::toml("road", "dry", &set("friktion_ratio=0.5")).expect_err("a typo");
        assert!(error.to_string().contains("friktion_ratio"), "{error}");
        let error = super::toml("road", "dry", &set("friction_ratio=-1.0")).expect_err("absurd");
        assert!(error.to_string().contains("-1"), "{error}");
        let error = super::toml("roof", "dry", &[]).expect_err("no such kind");
        assert!(error.to_string().contains("road"), "{error}");
        let rider = super::toml("rider", "older", &set("rider.steer_torque.delay_s=0.3"));
        assert!(rider.expect("legal").contains("delay_s = 0.3"));
    }
}
