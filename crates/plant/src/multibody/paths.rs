//! Parameters by dotted path: `tyre.front.twisting_gain`, `frame.mass_kg`, `joints.legs.free`.
//!
//! The path is that of the TOML file. The name of the tyre model may be left out
//! (`tyre.front.twisting_gain` for `tyre.front.magic_formula.twisting_gain`).

use super::error::MultibodyError;
use super::parameters::Parameters;
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
        let value = match (slot(&mut table, path), text.trim()) {
            (Some(Value::String(_)), text) => Value::String(text.to_owned()),
            (_, "true") => Value::Boolean(true),
            (_, "false") => Value::Boolean(false),
            (_, text) => match text.parse::<f64>() {
                Ok(v) => Value::Float(v),
                Err(_) => Value::String(text.to_owned()),
            },
        };
        self.set_value(path, value)
    }

    fn set_value(&mut self, path: &str, value: Value) -> Result<(), MultibodyError> {
        let mut table = self.table();
        let text = value.to_string();
        match slot(&mut table, path) {
            Some(place) => *place = value,
            // An option that is absent now: its parent must exist, and must know the name.
            None => {
                let (parent, key) = path.rsplit_once('.').ok_or_else(|| self.unknown(path))?;
                match slot(&mut table, parent) {
                    Some(Value::Table(t)) => {
                        let t = only_table(t, key);
                        t.insert(key.to_owned(), value);
                    }
                    _ => return Err(self.unknown(path)),
                }
            }
        }
        let changed: Self = Value::Table(table)
            .try_into()
            .map_err(|e: toml::de::Error| {
                if e.message().starts_with("unknown field") {
                    self.unknown(path)
                } else {
                    MultibodyError::Kind {
                        path: path.to_owned(),
                        found: text,
                        accepted: e.message().to_owned(),
                    }
                }
            })?;
        changed.validate()?;
        *self = changed;
        Ok(())
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
