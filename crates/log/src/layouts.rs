//! Layouts for Foxglove and PlotJuggler, and whether a log has what they show.

use serde_json::Value;

use crate::reader::LogFile;

/// Layout for Foxglove: import it, then open a log.
pub const FOXGLOVE_LAYOUT: &str = include_str!("../layouts/foxglove.json");

/// Layout for PlotJuggler: open a log, then load it.
pub const PLOTJUGGLER_LAYOUT: &str = include_str!("../layouts/plotjuggler.xml");

/// Checks that `log` has every topic and column that the layouts show; otherwise says which are
/// missing.
pub fn check_layouts(log: &LogFile) -> Result<(), Vec<String>> {
    let shown = foxglove_paths(FOXGLOVE_LAYOUT)
        .into_iter()
        .map(|path| ("foxglove.json", path))
        .chain(
            plotjuggler_curves(PLOTJUGGLER_LAYOUT)
                .into_iter()
                .map(|c| ("plotjuggler.xml", c)),
        );
    let missing: Vec<String> = shown
        .filter(|(_, path)| !has(log, path))
        .map(|(layout, path)| format!("{layout} shows {path}, which the log does not have"))
        .collect();
    if missing.is_empty() {
        Ok(())
    } else {
        Err(missing)
    }
}

/// A topic, or a topic and a column of it: `/plant/truth.roll_rad` in Foxglove,
/// `/plant/truth/roll_rad` in PlotJuggler.
fn has(log: &LogFile, path: &str) -> bool {
    if log.texts.contains_key(path) {
        return true;
    }
    log.tables.iter().any(|(topic, table)| {
        let Some(rest) = path.strip_prefix(topic.as_str()) else {
            return false;
        };
        let column = rest.trim_start_matches(['.', '/']).replace('/', ".");
        !column.is_empty() && table.column(&column).is_some()
    })
}

/// Every topic and path that a Foxglove layout shows.
fn foxglove_paths(layout: &str) -> Vec<String> {
    let mut paths = Vec::new();
    let layout: Value = serde_json::from_str(layout).unwrap_or_default();
    for panel in layout["configById"]
        .as_object()
        .into_iter()
        .flat_map(|panels| panels.values())
    {
        let plots = panel["paths"].as_array().into_iter().flatten();
        paths.extend(
            plots
                .filter_map(|plot| plot["value"].as_str())
                .map(String::from),
        );
        let topics = panel["topics"].as_object().into_iter().flatten();
        paths.extend(topics.map(|(topic, _)| topic.clone()));
        paths.extend(panel["topicToRender"].as_str().map(String::from));
    }
    paths
}

/// Every curve that a PlotJuggler layout shows.
fn plotjuggler_curves(layout: &str) -> Vec<String> {
    layout
        .split("<curve name=\"")
        .skip(1)
        .filter_map(|rest| rest.split_once('"'))
        .map(|(name, _)| name.to_string())
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_layouts_show_something_and_an_empty_log_has_none_of_it() {
        let paths = foxglove_paths(FOXGLOVE_LAYOUT);
        assert!(
            paths.iter().any(|path| path == "/plant/truth.roll_rad"),
            "{paths:?}"
        );
        assert!(paths.iter().any(|path| path == "/scene") && paths.iter().any(|p| p == "/event"));
        let curves = plotjuggler_curves(PLOTJUGGLER_LAYOUT);
        assert!(
            curves
                .iter()
                .any(|curve| curve == "/control/output/estimate/roll_rad")
        );
        let missing = check_layouts(&LogFile::default()).expect_err("nothing is there");
        assert_eq!(missing.len(), paths.len() + curves.len());
    }

    #[test]
    fn every_panel_of_the_foxglove_layout_stands_somewhere() {
        let layout: Value = serde_json::from_str(FOXGLOVE_LAYOUT).expect("JSON");
        let placed = layout["layout"].to_string();
        for panel in layout["configById"].as_object().expect("panels").keys() {
            assert!(placed.contains(&format!("\"{panel}\"")), "{panel}");
        }
    }
}
