//! Every registry of the plant as kinds of `twinhub list`, and each entry's explanation with the
//! values of an example.

use serde::Serialize;
use twinhub_plant::disturbance::{self, Disturbance, DisturbanceModel as _};
use twinhub_plant::explain::Explain;
use twinhub_plant::motor::{self, Battery, BatteryModel as _, MotorDrive, MotorModel as _};
use twinhub_plant::road::{BUMPS, Bump, BumpModel as _};
use twinhub_plant::sensor::{self, SensorKind as _, SensorParameters};
use twinhub_plant::tyre::{self, Tyre, TyreModel as _};
use twinhub_plant::wind::{GUSTS, Gust, GustModel as _};
use twinhub_plant::{explain, options};

/// A registry: its kind, its names, and what is said of an entry.
pub struct Registry {
    /// As `twinhub list` prints it.
    pub kind: &'static str,
    /// Names of all entries.
    pub names: &'static [&'static str],
    explain: fn(&str) -> Option<Entry>,
}

/// An entry with the values of an example, as TOML.
struct Entry {
    explain: Explain,
    values: String,
}

fn entry(explain: Explain, example: &impl Serialize) -> Entry {
    Entry {
        explain,
        values: toml::to_string(example).unwrap_or_else(|e| format!("# no TOML: {e}\n")),
    }
}

/// Every registry.
pub const REGISTRIES: &[Registry] = &[
    Registry {
        kind: "tyre_models",
        names: Tyre::NAMES,
        explain: |name| {
            let set = tyre::SETS.iter().find(|set| set.tyre.name() == name)?;
            Some(entry(set.tyre.explain(), &set.tyre))
        },
    },
    Registry {
        kind: "motor_models",
        names: MotorDrive::NAMES,
        explain: |name| {
            let all = MotorDrive::examples();
            let found = all.iter().find(|m| m.name() == name)?;
            Some(entry(found.explain(), found))
        },
    },
    Registry {
        kind: "batteries",
        names: Battery::NAMES,
        explain: |name| {
            let mut sets = motor::sets::SETS
                .iter()
                .filter_map(|(set, _)| motor::sets::named(set));
            let found = sets.find(|set| set.battery.name() == name)?.battery;
            Some(entry(found.explain(), &found))
        },
    },
    Registry {
        kind: "sensor_models",
        names: SensorParameters::NAMES,
        explain: |name| {
            let suites = sensor::sets::SUITES
                .iter()
                .filter_map(|(suite, _)| sensor::sets::named(suite));
            let found = suites
                .flat_map(|suite| suite.sensor)
                .find(|s| s.name() == name)?;
            Some(entry(found.explain(), &found))
        },
    },
    Registry {
        kind: "disturbance_models",
        names: Disturbance::NAMES,
        explain: |name| {
            let all = disturbance::sets::all();
            let (_, _, found) = all.iter().find(|(_, _, what)| what.name() == name)?;
            Some(entry(found.explain(), found))
        },
    },
    Registry {
        kind: "bumps",
        names: Bump::NAMES,
        explain: |name| {
            let (_, found) = BUMPS.iter().find(|(_, b)| b.name() == name)?;
            Some(entry(found.explain(), found))
        },
    },
    Registry {
        kind: "gusts",
        names: Gust::NAMES,
        explain: |name| {
            let (_, found) = GUSTS.iter().find(|(_, g)| g.name() == name)?;
            Some(entry(found.explain(), found))
        },
    },
];

/// Kinds with names and sentences: the registries, and the options of the multibody model.
pub fn kinds() -> Vec<(&'static str, Vec<(&'static str, &'static str)>)> {
    let mut kinds: Vec<_> = REGISTRIES
        .iter()
        .map(|registry| {
            let sentence =
                |name: &&'static str| (registry.explain)(name).map(|e| (*name, e.explain.what));
            let entries = registry.names.iter().filter_map(sentence).collect();
            (registry.kind, entries)
        })
        .collect();
    let options = options::OPTIONS.iter().map(|o| (o.name, o.what)).collect();
    kinds.push(("options", options));
    kinds
}

/// What the registries and options say of a name.
pub fn explanations(name: &str) -> Vec<String> {
    let entries = REGISTRIES.iter().filter_map(|registry| {
        let found = (registry.explain)(name)?;
        Some(format!(
            "{} {}\nValues of an example, as TOML:\n{}",
            registry.kind,
            found.explain,
            found.values.trim_end()
        ))
    });
    let options = options::OPTIONS
        .iter()
        .filter(|o| o.name == name)
        .map(|o: &explain::Explain| format!("option {o}"));
    entries.chain(options).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_entry_of_every_registry_is_listed_and_explained() {
        let kinds = kinds();
        for registry in REGISTRIES {
            let (_, listed) = kinds
                .iter()
                .find(|(kind, _)| *kind == registry.kind)
                .expect("listed kind");
            for name in registry.names {
                assert!(
                    listed.iter().any(|(n, about)| n == name && about.len() > 5),
                    "{} {name} is not listed",
                    registry.kind
                );
                let texts = explanations(name);
                for part in ["Equation: ", "Source: ", "Assumes and ignores: ", "Values"] {
                    assert!(
                        texts.iter().any(|t| t.contains(part)),
                        "{} {name}: no {part} in {texts:?}",
                        registry.kind
                    );
                }
            }
        }
        for option in options::OPTIONS {
            assert!(!explanations(option.name).is_empty(), "{}", option.name);
        }
        assert!(explanations("nobody").is_empty());
    }
}
