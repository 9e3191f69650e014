//! Stability over speed and motor torque.

use crate::errors;
use crate::watched::{texts, watched};
use numpy::{IntoPyArray, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use twinhub_plant::bicycles;
use twinhub_plant::multibody::{MapPoint, Multibody, map};
use twinhub_report::map_picture::{Grid, MapPicture};

/// Growth rates on a grid, one row per torque, and the picture. NaN where there is no steady state.
#[pyfunction]
pub fn stability_map<'py>(
    py: Python<'py>,
    bicycle: &str,
    speeds_m_s: Vec<f64>,
    torques_nm: Vec<f64>,
    assignments: Vec<String>,
    workers: usize,
) -> PyResult<Bound<'py, PyDict>> {
    let parameters = bicycles::load_multibody(bicycle, &assignments).map_err(errors::input)?;
    let model = Multibody::new(&parameters).map_err(errors::input)?;
    let (torques, speeds) = (torques_nm.clone(), speeds_m_s.clone());
    let rows = watched(py, texts(None), move |teller| {
        map(&model, &torques, &speeds, workers, &|_| teller.go_on())
    })?;
    let grid = |growth: fn(&MapPoint) -> Option<f64>| -> Grid {
        rows.iter()
            .map(|row| row.iter().map(growth).collect())
            .collect()
    };
    let (growth, oscillating, slow) = (
        grid(MapPoint::growth_rad_s),
        grid(MapPoint::oscillating_growth_rad_s),
        grid(MapPoint::slow_growth_rad_s),
    );
    let picture = MapPicture {
        title: &parameters.name,
        subtitle: "growth of small disturbances over speed and torque of the motor pair",
        speeds_m_s: &speeds_m_s,
        torques_nm: &torques_nm,
        growth_1_s: &growth,
        oscillating_1_s: &oscillating,
        slow_1_s: &slow,
    };
    let answer = PyDict::new(py);
    answer.set_item("bicycle", &parameters.name)?;
    answer.set_item("svg", picture.svg())?;
    for (name, grid) in [
        ("growth_1_s", &growth),
        ("oscillating_growth_1_s", &oscillating),
        ("slow_growth_1_s", &slow),
    ] {
        let values: Vec<f64> = grid
            .iter()
            .flatten()
            .map(|g| g.unwrap_or(f64::NAN))
            .collect();
        let shape = [torques_nm.len(), speeds_m_s.len()];
        answer.set_item(name, values.into_pyarray(py).reshape(shape)?)?;
    }
    Ok(answer)
}
