//! A ride that Python steps.

use crate::controller::{health, limits, numbers};
use crate::{errors, ride};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::sync::{Mutex, MutexGuard};
use twinhub_sim::{Ride, Stepped, Stepper};

/// A ride, some ticks at a time.
#[pyclass(name = "_Stepper", module = "twinhub._twinhub")]
pub struct PyStepper {
    stepper: Mutex<Stepper>,
}

impl PyStepper {
    fn stepper(&self) -> MutexGuard<'_, Stepper> {
        match self.stepper.lock() {
            Ok(guard) => guard,
            Err(poisoned) => poisoned.into_inner(),
        }
    }
}

#[pymethods]
impl PyStepper {
    #[new]
    fn new(course: &str, stabilizer: bool, assignments: Vec<String>) -> PyResult<Self> {
        let ride = Ride::load(course, &assignments)
            .map_err(errors::setup)?
            .with_stabilizer(stabilizer);
        Ok(Self {
            stepper: Mutex::new(Stepper::new(&ride).map_err(errors::setup)?),
        })
    }

    /// Goes on by `ticks` under a pair of `pair_nm`, or the law's if it is None. Gives the last tick,
    /// and sums over the ticks: rider's torque squared, roll squared, energy, ticks ridden.
    fn step<'py>(
        &self,
        py: Python<'py>,
        ticks: u32,
        pair_nm: Option<f32>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let mut stepper = self.stepper();
        let mut last: Option<Stepped> = None;
        let (mut effort, mut roll, mut energy_j, mut ridden) = (0.0, 0.0, 0.0, 0u32);
        for _ in 0..ticks {
            let Some(now) = stepper.step(pair_nm) else {
                break;
            };
            effort += now.rider.steer_torque_nm * now.rider.steer_torque_nm;
            roll += now.truth.roll_rad * now.truth.roll_rad;
            energy_j += now.truth.battery_w * twinhub_sim::TICK_S;
            ridden += 1;
            last = Some(now);
        }
        let answer = PyDict::new(py);
        answer.set_item("ridden", ridden)?;
        answer.set_item("effort_nm2", effort)?;
        answer.set_item("roll_rad2", roll)?;
        answer.set_item("energy_j", energy_j)?;
        answer.set_item("fell", stepper.fell())?;
        answer.set_item("finished", stepper.finished())?;
        answer.set_item("t_s", stepper.time_s())?;
        if let Some(last) = last {
            let command = last.output.command;
            answer.set_item("estimate", numbers(&last.output.estimate))?;
            answer.set_item("front_brake_nm", command.front_brake_nm)?;
            answer.set_item("rear_traction_nm", command.rear_traction_nm)?;
            answer.set_item("health", health(last.output.health))?;
            answer.set_item("limited_by", limits(last.output.limited_by))?;
            answer.set_item("roll_rad", last.truth.roll_rad)?;
            answer.set_item("steer_rad", last.truth.steer_rad)?;
            answer.set_item("speed_m_s", last.truth.speed_m_s)?;
        }
        Ok(answer)
    }

    /// The numbers of the ride so far.
    fn metrics<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        ride::numbers(py, &self.stepper().metrics())
    }
}
