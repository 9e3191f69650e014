//! Everything that has a name and a file, by kind, and what can be asked of it.

use crate::errors;
use numpy::IntoPyArray;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use twinhub_diagnose::study::{Study, shipped};
use twinhub_plant::bicycles;
use twinhub_plant::multibody::Multibody;
use twinhub_plant::rider::RiderFile;
use twinhub_plant::rider::closed_loop::stability;
use twinhub_plant::tyre::{Tyre, TyreInput, TyreModel as _};
use twinhub_sim::scenario::{Scenario, record};
use twinhub_sim::{RideError, things};

/// The kind that belongs to the diagnosis, not to rides.
const STUDY: &str = "study";

/// Names of what ships of a kind.
#[pyfunction]
pub fn thing_names(kind: &str) -> PyResult<Vec<String>> {
    if kind == STUDY {
        return Ok(shipped::NAMES
            .iter()
            .map(|name| (*name).to_owned())
            .collect());
    }
    things::names(kind).map_err(errors::setup)
}

/// Values with changes, as TOML.
#[pyfunction]
pub fn thing_toml(kind: &str, name: &str, assignments: Vec<String>) -> PyResult<String> {
    if kind == STUDY {
        if shipped::text(name).is_none() && !std::path::Path::new(name).exists() {
            return Err(errors::input(format!(
                "no study `{name}`: neither a file nor one that ships ({})",
                shipped::NAMES.join(", ")
            )));
        }
        Study::read(name, &assignments).map_err(errors::input)?;
        return match shipped::text(name) {
            Some(text) => Ok(text.to_owned()),
            None => {
                std::fs::read_to_string(name).map_err(|e| errors::input(format!("{name}: {e}")))
            }
        };
    }
    things::toml(kind, name, &assignments).map_err(errors::setup)
}

/// Growth rates of a rider's closed loop, 1/s, and frequencies, rad/s.
#[pyfunction]
pub fn rider_growth<'py>(
    py: Python<'py>,
    rider: &str,
    bicycle: &str,
    assignments: Vec<String>,
    speeds_m_s: Vec<f64>,
    pair_nm: f64,
) -> PyResult<Bound<'py, PyDict>> {
    let rider: RiderFile = toml::from_str(rider).map_err(errors::input)?;
    let parameters = bicycles::load_multibody(bicycle, &assignments).map_err(errors::input)?;
    let model = Multibody::new(&parameters).map_err(errors::input)?;
    let found = py
        .detach(|| stability(&model, &rider, pair_nm, &speeds_m_s))
        .map_err(errors::input)?;
    let answer = PyDict::new(py);
    let growth: Vec<f64> = found.iter().map(|s| s.growth_per_s).collect();
    let frequency: Vec<f64> = found.iter().map(|s| s.frequency_rad_s).collect();
    answer.set_item("speed_m_s", speeds_m_s.into_pyarray(py))?;
    answer.set_item("growth_1_s", growth.into_pyarray(py))?;
    answer.set_item("frequency_rad_s", frequency.into_pyarray(py))?;
    Ok(answer)
}

/// Forces and torques of a tyre at places of equal number.
#[pyfunction]
#[allow(clippy::too_many_arguments)] // the quantities of a contact
pub fn tyre_forces<'py>(
    py: Python<'py>,
    tyre: &str,
    load_n: Vec<f64>,
    slip_angle_rad: Vec<f64>,
    camber_rad: Vec<f64>,
    slip_ratio: Vec<f64>,
    friction_ratio: f64,
    radius_m: f64,
    speed_m_s: f64,
) -> PyResult<Bound<'py, PyDict>> {
    let tyre: Tyre = toml::from_str(tyre).map_err(errors::input)?;
    let mut columns: [Vec<f64>; 5] = Default::default();
    for i in 0..load_n.len() {
        let force = tyre.output(&TyreInput {
            load_n: load_n[i],
            slip_angle_rad: slip_angle_rad[i],
            camber_rad: camber_rad[i],
            slip_ratio: slip_ratio[i],
            friction_ratio,
            radius_m,
            speed_m_s,
        });
        let values = [
            force.longitudinal_n,
            force.lateral_n,
            force.overturning_nm,
            force.rolling_resistance_nm,
            force.aligning_nm,
        ];
        for (column, value) in columns.iter_mut().zip(values) {
            column.push(value);
        }
    }
    let answer = PyDict::new(py);
    let names = [
        "longitudinal_n",
        "lateral_n",
        "overturning_nm",
        "rolling_resistance_nm",
        "aligning_nm",
    ];
    for (name, column) in names.into_iter().zip(columns) {
        answer.set_item(name, column.into_pyarray(py))?;
    }
    Ok(answer)
}

/// Rows of an open-loop run as columns, and its summary as JSON.
#[pyfunction]
pub fn simulate<'py>(
    py: Python<'py>,
    scenario: &str,
    assignments: Vec<String>,
) -> PyResult<(Bound<'py, PyDict>, String)> {
    let scenario = Scenario::load(scenario, &assignments).map_err(errors::setup)?;
    let mut raised = None;
    let found = py.detach(|| {
        record(&scenario, &mut |_| {
            raised = Python::attach(|py| py.check_signals()).err();
            raised.is_none()
        })
    });
    if let Some(error) = raised {
        return Err(error);
    }
    let recording = found.map_err(|error| match error {
        RideError::Setup(error) => errors::setup(error),
        other => errors::ride(other),
    })?;
    let columns = PyDict::new(py);
    for name in recording.names() {
        if let Some(values) = recording.column(name) {
            columns.set_item(name, values.to_vec().into_pyarray(py))?;
        }
    }
    let summary = serde_json::to_string(&recording.summary).map_err(errors::input)?;
    Ok((columns, summary))
}
