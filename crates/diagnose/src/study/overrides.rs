//! `--set path=value`: one key of a study, changed from the command line.

use super::StudyError;

/// Puts `path=value` overrides into the text.
pub(super) fn with_overrides(text: &str, overrides: &[String]) -> Result<String, StudyError> {
    let refuse = |assignment: &str, message: String| StudyError::Override {
        assignment: assignment.to_owned(),
        message,
    };
    let mut root: toml::Value = toml::from_str::<toml::Table>(text)
        .map(toml::Value::Table)
        .map_err(|e| refuse("", e.message().to_owned()))?;
    for assignment in overrides {
        let (path, value) = assignment.split_once('=').ok_or_else(|| {
            refuse(
                assignment,
                "accepted: PATH=VALUE, for instance bicycle.values.IBxx=9.2".to_owned(),
            )
        })?;
        // A bare word is a string.
        let parsed: toml::Table = toml::from_str(&format!("v = {value}"))
            .or_else(|_| toml::from_str(&format!("v = {}", toml::Value::String(value.to_owned()))))
            .map_err(|e| refuse(assignment, e.message().to_owned()))?;
        let mut at = &mut root;
        let (parents, key) = path.trim().rsplit_once('.').unwrap_or(("", path.trim()));
        for part in parents.split('.').filter(|p| !p.is_empty()) {
            at = match at {
                toml::Value::Table(table) => table
                    .entry(part)
                    .or_insert_with(|| toml::Value::Table(toml::Table::new())),
                toml::Value::Array(items) => {
                    let count = items.len();
                    part.parse::<usize>()
                        .ok()
                        .and_then(|i| items.get_mut(i))
                        .ok_or_else(|| {
                            refuse(
                                assignment,
                                format!(
                                    "`{part}` is no index; accepted: 0 to {}",
                                    count.saturating_sub(1)
                                ),
                            )
                        })?
                }
                _ => {
                    return Err(refuse(
                        assignment,
                        format!("`{part}` lies below a plain value"),
                    ));
                }
            };
        }
        match (at, parsed.get("v")) {
            (toml::Value::Table(table), Some(value)) => table.insert(key.to_owned(), value.clone()),
            _ => {
                return Err(refuse(
                    assignment,
                    format!("`{key}` is not a key of a table"),
                ));
            }
        };
    }
    toml::to_string(&root).map_err(|e| refuse(&overrides.join(" "), e.to_string()))
}
