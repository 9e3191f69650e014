//! Parameters by dotted path: `tyre.front.twisting_gain`, `frame.mass_kg`, `joints.legs.free`.
//!
//! The path is that of the TOML file. The name of the tyre model may be left out
//! (`tyre.front.twisting_gain` for `tyre.front.magic_formula.twisting_gain`).

use super::error::MultibodyError;
use super::parameters::Parameters;
use super::pedalling::Pedalling;
use crate::bicycles::LoadError;
use toml::{Table, Value};

/// A parameter with its value.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    /// Dotted path.
    pub path: String,
    /// Value as TOML has it.
    pub value: Value,
}

impl Parameters {
    /// Every parameter, in the order of the file.
    pub fn entries(&self) -> Vec<Entry> {
        let mut entries = Vec::new();
        collect(&self.table(), "", &mut entries);
        entries
    }

    /// The paths of all numbers.
    pub fn paths(&self) -> Vec<String> {
        let number = |e: &Entry| matches!(e.value, Value::Float(_) | Value::Integer(_));
        self.entries()
            .into_iter()
            .filter(number)
            .map(|e| e.path)
            .collect()
    }

    /// The value at a path, if there is one.
    pub fn entry(&self, path: &str) -> Option<Value> {
        let mut table = self.table();
        slot(&mut table, path)
            .filter(|value| !value.is_table())
            .cloned()
    }

    /// The number at a path.
    pub fn get(&self, path: &str) -> Result<f64, MultibodyError> {
        let mut table = self.table();
        match slot(&mut table, path) {
            Some(Value::Float(v)) => Ok(*v),
            Some(Value::Integer(v)) => Ok(*v as f64),
            Some(other) => Err(MultibodyError::Kind {
                path: path.to_owned(),
                found: other.to_string(),
                accepted: "a path to a number".to_owned(),
            }),
            None => Err(self.unknown(path)),
        }
    }

    /// Sets the number at a path; the set as a whole is checked.
    pub fn set(&mut self, path: &str, value: f64) -> Result<(), MultibodyError> {
        self.set_value(path, Value::Float(value))
    }

    /// Sets what is at a path from text: a number, `true`, `false`, or a name.
    pub fn set_text(&mut self, path: &str, text: &str) -> Result<(), MultibodyError> {
        let mut table = self.table();
        let value = read(slot(&mut table, path), path, text)?;
        self.set_value(path, value)
    }

    /// This set with `PATH=VALUE` assignments, checked as a whole after the last one. `tyre=NAME`
    /// takes a tyre set for both wheels, `tyre.front=NAME` for one.
    pub fn with<S: AsRef<str>>(&self, assignments: &[S]) -> Result<Self, LoadError> {
        let mut table = self.table();
        for assignment in assignments.iter().map(AsRef::as_ref) {
            let wrong = |detail: String| LoadError::Assignment {
                assignment: assignment.to_owned(),
                detail,
            };
            let (path, text) = assignment
                .split_once('=')
                .map(|(path, text)| (path.trim(), text.trim()))
                .ok_or_else(|| wrong("accepted: path=value".to_owned()))?;
            let wheels: &[&str] = if path == "tyre" {
                &["tyre.rear", "tyre.front"]
            } else {
                &[path]
            };
            for path in wheels {
                let value =
                    read(slot(&mut table, path), path, text).map_err(|e| wrong(e.to_string()))?;
                self.put(&mut table, path, value)
                    .map_err(|e| wrong(e.to_string()))?;
                // Each as it is put, so that an unknown name is told at its assignment.
                self.made(table.clone(), path, text)
                    .map_err(|e| wrong(e.to_string()))?;
            }
        }
        let changed: Self = self
            .made(table, "", "")
            .and_then(|changed| changed.validate().map(|()| changed))
            .map_err(|source| LoadError::Multibody {
                origin: self.name.clone(),
                source,
            })?;
        Ok(changed)
    }

    fn set_value(&mut self, path: &str, value: Value) -> Result<(), MultibodyError> {
        let mut table = self.table();
        let text = value.to_string();
        self.put(&mut table, path, value)?;
        let changed = self.made(table, path, &text)?;
        changed.validate()?;
        *self = changed;
        Ok(())
    }

    /// Puts a value in its place.
    fn put(&self, table: &mut Table, path: &str, value: Value) -> Result<(), MultibodyError> {
        if let Some(place) = slot(table, path) {
            *place = value;
            return Ok(());
        }
        // An option that is absent now: its parent must exist, and must know the name.
        if path == "pedalling" {
            table.insert(path.to_owned(), value);
            return Ok(());
        }
        let (parent, key) = path.rsplit_once('.').ok_or_else(|| self.unknown(path))?;
        match slot(table, parent) {
            Some(Value::Table(t)) => {
                only_table(t, key).insert(key.to_owned(), value);
                Ok(())
            }
            _ => Err(self.unknown(path)),
        }
    }

    /// The parameters of a table in which `path` was just set to `text`.
    fn made(&self, table: Table, path: &str, text: &str) -> Result<Self, MultibodyError> {
        Value::Table(table)
            .try_into()
            .map_err(|e: toml::de::Error| {
                if e.message().starts_with("unknown field") {
                    self.unknown(path)
                } else {
                    MultibodyError::Kind {
                        path: path.to_owned(),
                        found: text.to_owned(),
                        accepted: e.message().to_owned(),
                    }
                }
            })
    }

    fn table(&self) -> Table {
        Table::try_from(self).expect("plain numbers, flags and names are representable")
    }

    fn unknown(&self, path: &str) -> MultibodyError {
        let last = path.rsplit('.').next().unwrap_or(path);
        let near: Vec<String> = self
            .entries()
            .into_iter()
            .map(|e| e.path)
            .filter(|p| {
                p.rsplit('.')
                    .next()
                    .is_some_and(|l| l == last || l.contains(last) || last.contains(l))
            })
            .take(3)
            .collect();
        let hint = if near.is_empty() {
            String::new()
        } else {
            format!("; near: {}", near.join(", "))
        };
        MultibodyError::UnknownPath {
            found: path.to_owned(),
            hint,
        }
    }
}

/// What `text` means at a place that holds `now`.
fn read(now: Option<&mut Value>, path: &str, text: &str) -> Result<Value, MultibodyError> {
    let text = text.trim();
    if path == "pedalling" {
        return match text {
            "default" => {
                Ok(Value::try_from(Pedalling::default()).expect("plain numbers are representable"))
            }
            _ => Err(MultibodyError::Kind {
                path: path.to_owned(),
                found: text.to_owned(),
                accepted: "default, and then pedalling.cadence_rad_s=... and its neighbours"
                    .to_owned(),
            }),
        };
    }
    Ok(match (now, text) {
        (Some(Value::String(_)), _) => Value::String(text.to_owned()),
        (Some(Value::Table(_)), name) if path.starts_with("tyre.") => {
            let set = crate::tyre::set(name).ok_or_else(|| MultibodyError::Kind {
                path: path.to_owned(),
                found: name.to_owned(),
                accepted: crate::tyre::SETS
                    .iter()
                    .map(|set| set.name)
                    .collect::<Vec<_>>()
                    .join(", "),
            })?;
            Value::try_from(set.tyre).expect("plain numbers and names are representable")
        }
        (_, "true") => Value::Boolean(true),
        (_, "false") => Value::Boolean(false),
        _ => match text.parse::<f64>() {
            Ok(v) => Value::Float(v),
            Err(_) => Value::String(text.to_owned()),
        },
    })
}

/// The table itself, or the one table in it that is the tyre model.
fn only_table<'a>(table: &'a mut Table, key: &str) -> &'a mut Table {
    if table.len() == 1 && !table.contains_key(key) {
        let inner = table.keys().next().cloned().unwrap_or_default();
        if matches!(table.get(&inner), Some(Value::Table(_))) {
            let Some(Value::Table(t)) = table.get_mut(&inner) else {
                unreachable!("just seen")
            };
            return t;
        }
    }
    table
}

fn slot<'a>(table: &'a mut Table, path: &str) -> Option<&'a mut Value> {
    match path.split_once('.') {
        None => only_table(table, path).get_mut(path),
        Some((head, rest)) => match only_table(table, head).get_mut(head)? {
            Value::Table(inner) => slot(inner, rest),
            _ => None,
        },
    }
}

fn collect(table: &Table, prefix: &str, entries: &mut Vec<Entry>) {
    for (key, value) in table {
        let path = if prefix.is_empty() {
            key.clone()
        } else {
            format!("{prefix}.{key}")
        };
        match value {
            Value::Table(inner) => collect(inner, &path, entries),
            _ => entries.push(Entry {
                path,
                value: value.clone(),
            }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{BulsinkBicycle, Case, Reading};
    use super::*;

    fn full() -> Parameters {
        Parameters::bulsink2017(BulsinkBicycle::One, Case::Full, &Reading::default())
    }

    #[test]
    fn every_number_can_be_read_and_set() {
        let mut p = full();
        let paths = p.paths();
        assert!(paths.len() > 100, "{}", paths.len());
        for path in &paths {
            let value = p.get(path).unwrap();
            p.set(path, value).unwrap_or_else(|e| panic!("{path}: {e}"));
        }
        assert_eq!(p, full());
        p.set("tyre.front.twisting_gain", 2.0).unwrap();
        assert_eq!(
            p.get("tyre.front.magic_formula.twisting_gain").unwrap(),
            2.0
        );
        p.set("tyre.front.relaxation_length_m", 0.1).unwrap();
        assert_eq!(p.get("tyre.front.relaxation_length_m").unwrap(), 0.1);
        p.set_text("joints.legs.free", "false").unwrap();
        assert!(!p.joints.legs.free);
    }

    #[test]
    fn wrong_paths_and_values_say_what_is_accepted() {
        let mut p = full();
        let e = p
            .set("tyre.front.twistin_gain", 1.0)
            .unwrap_err()
            .to_string();
        assert!(e.contains("twistin_gain"), "{e}");
        let e = p.set("fram.mass_kg", 1.0).unwrap_err().to_string();
        assert!(e.contains("frame.mass_kg"), "{e}");
        let e = p.set("geometry.wheelbase_m", -1.0).unwrap_err().to_string();
        assert!(e.contains("0.1 to 10"), "{e}");
        let e = p
            .set("geometry.wheelbase_m", f64::NAN)
            .unwrap_err()
            .to_string();
        assert!(e.contains("wheelbase"), "{e}");
        let e = p
            .set_text("geometry.wheelbase_m", "long")
            .unwrap_err()
            .to_string();
        assert!(e.contains("wheelbase"), "{e}");
    }

    #[test]
    fn toml_round_trip_keeps_every_bit() {
        let p = full();
        assert_eq!(Parameters::from_toml(&p.to_toml()).unwrap(), p);
        let e =
            Parameters::from_toml(&p.to_toml().replace("wheelbase_m", "wheel_base_m")).unwrap_err();
        assert!(e.to_string().contains("wheel_base_m"), "{e}");
    }
}
