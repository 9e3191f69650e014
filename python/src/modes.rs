//! Modes over speed.

use crate::{bicycle, errors};
use numpy::{IntoPyArray, PyArrayMethods, PyReadonlyArray1};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use twinhub_linear::{Bicycle, Canonical, Crossing, Modes, MotorPair};

/// Modes at `speeds_m_s` (finite, at least 0, not empty: the caller has checked).
#[pyfunction]
pub fn modes<'py>(
    py: Python<'py>,
    bicycle: &str,
    torque_nm: f64,
    speeds_m_s: PyReadonlyArray1<'py, f64>,
    rear_torque_nm: Option<f64>,
    assignments: Vec<String>,
) -> PyResult<Bound<'py, PyDict>> {
    let bicycle = bicycle::load(bicycle, &assignments)?;
    let pair = pair(&bicycle, torque_nm, rear_torque_nm)?;
    let equations = Canonical::new(&bicycle).map_err(errors::input)?;
    let speeds: Vec<f64> = speeds_m_s.as_array().iter().copied().collect();
    let modes = py.detach(|| Modes::over(&equations, pair, &speeds));

    let all = || modes.points.iter().flat_map(|point| &point.modes);
    let values: Vec<_> = all().map(|mode| mode.pair.value).collect();
    if let Some(i) = values
        .iter()
        .position(|s| !(s.re.is_finite() && s.im.is_finite()))
    {
        let speed_m_s = modes.points[i / 4].speed_m_s;
        return Err(errors::input(format!(
            "the modes of `{}` are not finite at {speed_m_s} m/s with {} Nm front and {} Nm rear; \
             accepted: torques and parameters of a bicycle",
            bicycle.name, pair.front_brake_nm, pair.rear_traction_nm
        )));
    }
    let names: Vec<_> = all().map(|mode| mode.name.as_str()).collect();
    let ranges: Vec<f64> = modes.stable_ranges_m_s.iter().flatten().copied().collect();
    let crossings: Vec<_> = modes
        .criticals
        .iter()
        .map(|c| {
            let kind = match c.crossing {
                Crossing::Divergence => "divergence",
                Crossing::Oscillation => "oscillation",
            };
            (c.speed_m_s, c.mode.as_str(), kind, c.stable_above)
        })
        .collect();

    let answer = PyDict::new(py);
    answer.set_item(
        "eigenvalues",
        values.into_pyarray(py).reshape([speeds.len(), 4])?,
    )?;
    answer.set_item("names", names)?;
    answer.set_item(
        "stable_ranges_m_s",
        ranges
            .into_pyarray(py)
            .reshape([modes.stable_ranges_m_s.len(), 2])?,
    )?;
    answer.set_item("speed_m_s", speeds.into_pyarray(py))?;
    answer.set_item("weave_speed_m_s", modes.weave_speed_m_s())?;
    answer.set_item("capsize_speed_m_s", modes.capsize_speed_m_s())?;
    answer.set_item("weave", modes.weave.as_str())?;
    answer.set_item("capsize", modes.capsize.as_str())?;
    answer.set_item("crossings", crossings)?;
    answer.set_item("front_brake_nm", pair.front_brake_nm)?;
    answer.set_item("rear_traction_nm", pair.rear_traction_nm)?;
    answer.set_item(
        "longitudinal_accel_m_s2",
        equations.longitudinal_accel_m_s2(pair),
    )?;
    answer.set_item("bicycle", bicycle.name)?;
    answer.set_item("source", bicycle.source)?;
    answer.set_item("remarks", bicycle.remarks)?;
    Ok(answer)
}

fn pair(bicycle: &Bicycle, torque_nm: f64, rear_torque_nm: Option<f64>) -> PyResult<MotorPair> {
    let p = &bicycle.parameters;
    let rear = rear_torque_nm.unwrap_or(torque_nm);
    if torque_nm != 0.0 && p.rF == 0.0 || rear != 0.0 && p.rR == 0.0 {
        return Err(errors::input(format!(
            "`{}` has a skate (wheel radius 0), which no motor can turn; accepted: torque_nm=0",
            bicycle.name
        )));
    }
    let balanced = MotorPair::balanced(torque_nm, bicycle);
    Ok(MotorPair {
        rear_traction_nm: rear_torque_nm.unwrap_or(balanced.rear_traction_nm),
        ..balanced
    })
}
