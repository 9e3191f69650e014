//! Bicycles and their parameters.

use crate::errors;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use twinhub_linear::{Bicycle, SYMBOLS, sets};

/// Names of the built-in parameter sets.
#[pyfunction]
pub fn bicycles() -> Vec<&'static str> {
    sets::NAMES.to_vec()
}

/// Unit by symbol.
#[pyfunction]
pub fn parameter_units(py: Python<'_>) -> PyResult<Bound<'_, PyDict>> {
    let units = PyDict::new(py);
    for symbol in SYMBOLS {
        units.set_item(symbol, twinhub_linear::unit(symbol).unwrap_or_default())?;
    }
    Ok(units)
}

/// Values by symbol, in the order of the paper.
#[pyfunction]
pub fn parameters<'py>(
    py: Python<'py>,
    bicycle: &str,
    assignments: Vec<String>,
) -> PyResult<Bound<'py, PyDict>> {
    let bicycle = load(bicycle, &assignments)?;
    let values = PyDict::new(py);
    for symbol in SYMBOLS {
        values.set_item(symbol, bicycle.get(symbol))?;
    }
    Ok(values)
}

/// The bicycle with the assignments (`SYMBOL=NUMBER`) applied.
pub fn load(bicycle: &str, assignments: &[String]) -> PyResult<Bicycle> {
    Bicycle::load(bicycle)
        .and_then(|b| b.with(assignments))
        .map_err(errors::input)
}
