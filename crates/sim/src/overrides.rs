//! `--set path=value`: one key of a file, changed from the command line.

use crate::error::SetupError;
use crate::resolve;
use toml::Value;

/// An assignment, split into its path and its value.
#[derive(Clone, Debug, PartialEq)]
pub struct Override {
    text: String,
    part: &'static str,
    path: Vec<String>,
    value: Value,
}

impl Override {
    /// Reads `path=value`. The value is TOML; what is no TOML is taken as text.
    ///
    /// # Errors
    /// If there is no `=` or no path.
    pub fn parse(text: &str) -> Result<Self, SetupError> {
        let bad = |detail: &str| SetupError::Override {
            assignment: text.into(),
            detail: detail.into(),
        };
        let (path, value) = text
            .split_once('=')
            .ok_or_else(|| bad("expected path=value"))?;
        let mut path: Vec<String> = path.trim().split('.').map(str::to_owned).collect();
        if path.iter().any(String::is_empty) {
            return Err(bad(
                "expected path=value, with a path such as `rider.rider.steer_torque.delay_s`",
            ));
        }
        let part = match path[0].as_str() {
            "rider" if path.len() > 1 => "rider",
            "law" if path.len() > 1 => "law",
            _ => "course",
        };
        if part != "course" {
            path.remove(0);
        }
        let value = value.trim();
        let value = toml::from_str::<toml::Table>(&format!("v = {value}"))
            .ok()
            .and_then(|mut table| table.remove("v"))
            .unwrap_or_else(|| Value::String(value.to_owned()));
        Ok(Self {
            text: text.to_owned(),
            part,
            path,
            value,
        })
    }

    /// The file that it changes: `course`, `rider` or `law`.
    pub fn part(&self) -> &'static str {
        self.part
    }

    /// The assignment as given.
    pub fn text(&self) -> &str {
        &self.text
    }
}

/// Changes the key. A key that does not exist is put in where there is a table for it, and what to
/// say if the reader then refuses it is given back: so a typo is noticed.
///
/// What is named in a course (`motors = "ideal"`) is written out first where the path leads into
/// it. An element of a list of kinds may be called by its kind: `sensors.sensor.roll.timing.delay_s`.
pub fn apply(tree: &mut Value, o: &Override) -> Result<Option<SetupError>, SetupError> {
    let bad = |detail: String| SetupError::Override {
        assignment: o.text.clone(),
        detail,
    };
    if o.part == "course" {
        if let [plant, multibody, bicycle, path @ ..] = &o.path[..]
            && plant == "plant"
            && multibody == "multibody"
            && (bicycle == "bicycle" || bicycle == "set")
            && !path.is_empty()
        {
            return change_bicycle(tree, o, &path.join("."));
        }
        for place in resolve::PLACES {
            let keys: Vec<&str> = place.split('.').collect();
            if o.path.len() > keys.len() && keys.iter().zip(&o.path).all(|(a, b)| a == b) {
                let found = keys
                    .iter()
                    .try_fold(&mut *tree, |value, key| value.get_mut(*key));
                if let Some(value) = found
                    && let Some(name) = value.as_str()
                {
                    *value = resolve::expanded(place, name)?;
                }
            }
        }
    }
    let mut place = tree;
    for (depth, key) in o.path.iter().enumerate() {
        let known = match &*place {
            Value::Table(table) => table.keys().cloned().collect::<Vec<_>>().join(", "),
            Value::Array(array) => format!("0 to {}", array.len().saturating_sub(1)),
            _ => String::from("nothing below it"),
        };
        let above = if depth == 0 {
            "the file".to_owned()
        } else {
            format!("`{}`", o.path[..depth].join("."))
        };
        let no_such_key = || bad(format!("no `{key}` in {above}, which has: {known}"));
        let next = match place {
            Value::Table(table) => {
                if depth + 1 == o.path.len() && !table.contains_key(key) {
                    table.insert(key.clone(), o.value.clone());
                    return Ok(Some(no_such_key()));
                }
                table.get_mut(key)
            }
            Value::Array(array) => match key.parse::<usize>() {
                Ok(i) => array.get_mut(i),
                Err(_) => array.iter_mut().find_map(|element| element.get_mut(key)),
            },
            _ => None,
        };
        place = next.ok_or_else(no_such_key)?;
    }
    // An integer where a float stands is meant as a float.
    *place = match (&*place, &o.value) {
        (Value::Float(_), Value::Integer(i)) => Value::Float(*i as f64),
        _ => o.value.clone(),
    };
    Ok(None)
}

/// Adds a change of a multibody bicycle's parameter to the course's `set`; the bicycle itself says
/// whether it has that parameter.
fn change_bicycle(
    tree: &mut Value,
    o: &Override,
    path: &str,
) -> Result<Option<SetupError>, SetupError> {
    let choice = tree
        .get_mut("plant")
        .and_then(|plant| plant.get_mut("multibody"))
        .and_then(Value::as_table_mut)
        .ok_or_else(|| SetupError::Override {
            assignment: o.text.clone(),
            detail: "the course does not ride the multibody plant".into(),
        })?;
    let set = choice
        .entry("set")
        .or_insert_with(|| Value::Table(toml::Table::new()));
    if let Some(set) = set.as_table_mut() {
        remove(set, path);
        set.insert(path.to_owned(), o.value.clone());
    }
    Ok(None)
}

/// Takes the entry at a dotted path out of nested tables.
fn remove(table: &mut toml::Table, path: &str) {
    table.remove(path);
    if let Some((head, rest)) = path.split_once('.')
        && let Some(Value::Table(inner)) = table.get_mut(head)
    {
        remove(inner, rest);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn set(assignment: &str) -> Result<Value, SetupError> {
        let mut tree: Value =
            toml::from_str("a = 1.5\n[b]\nc = \"x\"\nd = [{ e = 2 }]").expect("TOML");
        match apply(&mut tree, &Override::parse(assignment)?)? {
            Some(doubt) => Err(doubt),
            None => Ok(tree),
        }
    }

    #[test]
    fn keys_are_found_by_path_also_in_lists() {
        assert_eq!(set("a=2").expect("ok")["a"].as_float(), Some(2.0));
        assert_eq!(
            set("b.c=name").expect("ok")["b"]["c"].as_str(),
            Some("name")
        );
        assert_eq!(
            set("b.d.0.e = 7").expect("ok")["b"]["d"][0]["e"].as_integer(),
            Some(7)
        );
    }

    #[test]
    fn a_typo_lists_what_there_is() {
        let error = set("b.cc=1").expect_err("typo").to_string();
        assert!(error.contains("b.cc") && error.contains("c, d"), "{error}");
        assert!(set("a").is_err() && set("=3").is_err() && set("b.d.4.e=1").is_err());
    }

    #[test]
    fn names_are_written_out_where_a_path_leads_into_them() {
        let mut tree: Value = toml::from_str(
            "motors = \"direct_drive_250w\"\nsensors = \"laboratory\"\n[plant.multibody]\nroad = \"dry\"\n\
             [plant.multibody.set]\nair.x_m = 0.4",
        )
        .expect("TOML");
        for assignment in [
            "motors.front.lag_s=0.02",
            "sensors.sensor.roll.timing.delay_s=0.02",
            "plant.multibody.road.slope_rad=0.01",
            "plant.multibody.bicycle.air.x_m=0.5",
            "plant.multibody.set.tyre.front.twisting_gain=0.1",
        ] {
            apply(&mut tree, &Override::parse(assignment).expect("reads")).expect(assignment);
        }
        assert_eq!(tree["motors"]["front"]["lag_s"].as_float(), Some(0.02));
        let roll = &tree["sensors"]["sensor"][1]["roll"];
        assert_eq!(roll["timing"]["delay_s"].as_float(), Some(0.02));
        let plant = &tree["plant"]["multibody"];
        assert_eq!(plant["road"]["slope_rad"].as_float(), Some(0.01));
        assert_eq!(plant["set"]["air.x_m"].as_float(), Some(0.5));
        assert!(
            plant["set"]["air"]
                .as_table()
                .is_some_and(toml::Table::is_empty)
        );
        assert_eq!(
            plant["set"]["tyre.front.twisting_gain"].as_float(),
            Some(0.1)
        );
    }
}
