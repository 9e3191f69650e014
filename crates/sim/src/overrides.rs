//! `--set path=value`: one key of a file, changed from the command line.

use crate::error::SetupError;
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

/// Changes the key; it has to exist, so that a typo is noticed.
pub fn apply(tree: &mut Value, o: &Override) -> Result<(), SetupError> {
    let bad = |detail: String| SetupError::Override {
        assignment: o.text.clone(),
        detail,
    };
    let mut place = tree;
    for (depth, key) in o.path.iter().enumerate() {
        let known = match &*place {
            Value::Table(table) => table.keys().cloned().collect::<Vec<_>>().join(", "),
            Value::Array(array) => format!("0 to {}", array.len().saturating_sub(1)),
            _ => String::from("nothing below it"),
        };
        let next = match place {
            Value::Table(table) => table.get_mut(key),
            Value::Array(array) => key.parse::<usize>().ok().and_then(|i| array.get_mut(i)),
            _ => None,
        };
        place = next.ok_or_else(|| {
            let above = if depth == 0 {
                "the file".to_owned()
            } else {
                format!("`{}`", o.path[..depth].join("."))
            };
            bad(format!("no `{key}` in {above}, which has: {known}"))
        })?;
    }
    // An integer where a float stands is meant as a float.
    *place = match (&*place, &o.value) {
        (Value::Float(_), Value::Integer(i)) => Value::Float(*i as f64),
        _ => o.value.clone(),
    };
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn set(assignment: &str) -> Result<Value, SetupError> {
        let mut tree: Value =
            toml::from_str("a = 1.5\n[b]\nc = \"x\"\nd = [{ e = 2 }]").expect("TOML");
        apply(&mut tree, &Override::parse(assignment)?)?;
        Ok(tree)
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
}
