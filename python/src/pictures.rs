//! Pictures for notebooks: inline SVG, no script.

use crate::errors;
use pyo3::prelude::*;
use twinhub_report::chart::{Chart, Panel, STYLES, Series};
use twinhub_report::league::{Dot, frontier_svg};

/// Title, unit, and lines: name, x, y.
type PanelData = (String, String, Vec<(String, Vec<f64>, Vec<f64>)>);

/// Panels above each other with one x axis.
#[pyfunction]
pub fn line_chart(title: &str, x_title: &str, panels: Vec<PanelData>) -> PyResult<String> {
    for (panel, _, lines) in &panels {
        if let Some((name, x, y)) = lines.iter().find(|(_, x, y)| x.len() != y.len()) {
            return Err(errors::input(format!(
                "line {name:?} of panel {panel:?} has {} x values and {} y values; accepted: as many",
                x.len(),
                y.len()
            )));
        }
    }
    let chart = Chart {
        title,
        x_title,
        panels: panels
            .iter()
            .map(|(title, unit, lines)| Panel {
                title,
                unit,
                series: lines
                    .iter()
                    .enumerate()
                    .map(|(i, (name, x, y))| Series {
                        name,
                        style: i % STYLES,
                        x,
                        y,
                    })
                    .collect(),
                ..Panel::default()
            })
            .collect(),
        ..Chart::default()
    };
    Ok(chart.standalone())
}

/// Effort saved against energy: name, energy, effort saved, on the frontier.
#[pyfunction]
pub fn frontier_picture(dots: Vec<(String, f64, f64, bool)>) -> String {
    let dots: Vec<Dot> = dots
        .into_iter()
        .map(
            |(name, energy_wh_per_km, effort_saved_nm, on_frontier)| Dot {
                name,
                energy_wh_per_km,
                effort_saved_nm,
                on_frontier,
            },
        )
        .collect();
    frontier_svg(&dots, true)
}
