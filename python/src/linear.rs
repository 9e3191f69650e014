//! Linear models and gradients of their modes.

use crate::errors;
use nalgebra::{Complex, Matrix2};
use numpy::{IntoPyArray, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use twinhub_linear::{Bicycle, Canonical, ModeName, MotorPair, sets};
use twinhub_plant::bicycles;
use twinhub_plant::multibody::{Course, INPUTS, Multibody};

/// Rows of a matrix, as numpy has them.
fn matrix<'py>(
    py: Python<'py>,
    rows: usize,
    columns: usize,
    at: impl Fn(usize, usize) -> f64,
) -> PyResult<Bound<'py, numpy::PyArray2<f64>>> {
    let values: Vec<f64> = (0..rows * columns)
        .map(|k| at(k / columns, k % columns))
        .collect();
    values.into_pyarray(py).reshape([rows, columns])
}

/// True for a bicycle of the benchmark model: four parameter sets, or a file of theirs.
fn is_benchmark(bicycle: &str) -> bool {
    sets::NAMES.contains(&bicycle) || Bicycle::load(bicycle).is_ok()
}

/// Lateral state space at one speed, under a balanced pair.
#[pyfunction]
pub fn linearise<'py>(
    py: Python<'py>,
    bicycle: &str,
    speed_m_s: f64,
    torque_nm: f64,
    assignments: Vec<String>,
) -> PyResult<Bound<'py, PyDict>> {
    let answer = PyDict::new(py);
    if is_benchmark(bicycle) {
        let bicycle = crate::bicycle::load(bicycle, &assignments)?;
        let equations = Canonical::new(&bicycle).map_err(errors::input)?;
        let pair = MotorPair::balanced(torque_nm, &bicycle);
        let (a, b) = (
            equations.state_matrix(speed_m_s, pair),
            equations.input_matrix(),
        );
        answer.set_item("a", matrix(py, 4, 4, |i, j| a[(i, j)])?)?;
        answer.set_item("b", matrix(py, 4, 2, |i, j| b[(i, j)])?)?;
        let states = [
            "roll_rad",
            "steer_rad",
            "roll_rate_rad_s",
            "steer_rate_rad_s",
        ];
        answer.set_item("states", states.to_vec())?;
        answer.set_item("inputs", vec!["roll_torque_nm", "steer_torque_nm"])?;
        let two = |m: Matrix2<f64>| matrix(py, 2, 2, |i, j| m[(i, j)]);
        answer.set_item("mass", two(equations.mass())?)?;
        answer.set_item("c1", two(equations.c1())?)?;
        answer.set_item("k0", two(equations.k0())?)?;
        answer.set_item("k2", two(equations.k2())?)?;
        return Ok(answer);
    }
    let model = multibody(bicycle, &assignments)?;
    let linear = model
        .linear(&Course::pair(speed_m_s, torque_nm))
        .map_err(errors::input)?
        .lateral();
    let n = linear.names.len();
    answer.set_item("a", matrix(py, n, n, |i, j| linear.a[(i, j)])?)?;
    let inputs = linear.b.ncols();
    answer.set_item("b", matrix(py, n, inputs, |i, j| linear.b[(i, j)])?)?;
    answer.set_item("states", linear.names.clone())?;
    answer.set_item("inputs", INPUTS[..inputs].to_vec())?;
    Ok(answer)
}

fn multibody(bicycle: &str, assignments: &[String]) -> PyResult<Multibody> {
    let parameters = bicycles::load_multibody(bicycle, assignments).map_err(errors::input)?;
    Multibody::new(&parameters).map_err(errors::input)
}

/// Derivatives of a mode's eigenvalue with respect to every parameter of the multibody model.
#[pyfunction]
pub fn gradients<'py>(
    py: Python<'py>,
    bicycle: &str,
    speed_m_s: f64,
    torque_nm: f64,
    mode: &str,
    assignments: Vec<String>,
) -> PyResult<Bound<'py, PyDict>> {
    let modes = [ModeName::Weave, ModeName::Capsize, ModeName::Caster];
    let name = modes
        .into_iter()
        .find(|m| m.as_str() == mode)
        .ok_or_else(|| {
            let names: Vec<&str> = modes.iter().map(|m| m.as_str()).collect();
            errors::input(format!("mode={mode:?}; accepted: {}", names.join(", ")))
        })?;
    let model = multibody(bicycle, &assignments)?;
    let course = Course::pair(speed_m_s, torque_nm);
    let found = py
        .detach(|| model.speed_sensitivities(&course, name))
        .map_err(errors::input)?;
    let answer = PyDict::new(py);
    let complex = |z: &Complex<f64>| (z.re, z.im);
    answer.set_item("eigenvalue", complex(&found.eigenvalue))?;
    answer.set_item("per_speed", complex(&found.per_speed))?;
    let parameters = PyDict::new(py);
    for one in &found.parameters {
        parameters.set_item(&one.path, (one.value, complex(&one.per_unit)))?;
    }
    answer.set_item("parameters", parameters)?;
    Ok(answer)
}
