//! Many rides, on all cores.

use crate::errors;
use crate::watched::{Teller, watched};
use numpy::IntoPyArray;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use rayon::prelude::*;
use std::sync::atomic::{AtomicBool, Ordering};
use twinhub_link::InProcess;
use twinhub_sim::{Metrics, Ride, RideError, Settings};

/// Ticks between two looks at whether to stop.
const STOP_EVERY: u64 = 256;

/// One ride of a batch: course, stabilizer, assignments.
type Wanted = (String, bool, Vec<String>);

enum Failure {
    Setup(twinhub_sim::SetupError),
    Ride(RideError),
    /// Somebody else's failure, or Ctrl-C, ended the batch.
    Stopped,
}

/// Rides them all; a column for every number, in the order of `rides`.
#[pyfunction]
pub fn batch<'py>(
    py: Python<'py>,
    rides: Vec<Wanted>,
    workers: Option<usize>,
    progress: Option<Py<PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    let mut pool = rayon::ThreadPoolBuilder::new();
    if let Some(workers) = workers {
        pool = pool.num_threads(workers);
    }
    let pool = pool.build().map_err(errors::input)?;
    let (mut done, total) = (0, rides.len());
    let hear = |py: Python<'_>, (): ()| {
        done += 1;
        match &progress {
            Some(progress) => progress.call1(py, (done, total)).map(|_| ()),
            None => Ok(()),
        }
    };
    let found = watched(py, hear, move |teller| pool.install(|| run(&rides, teller)))?;
    let mut metrics = Vec::with_capacity(found.len());
    for (index, result) in found.into_iter().enumerate() {
        match result {
            Ok(one) => metrics.push(one),
            Err(Failure::Setup(error)) => {
                let error = errors::setup(error);
                return Err(errors::input(format!("ride {index}: {error}")));
            }
            Err(Failure::Ride(error)) => {
                return Err(errors::python::RideError::new_err(format!(
                    "ride {index}: {error}"
                )));
            }
            // Another one's failure, which follows.
            Err(Failure::Stopped) => {}
        }
    }
    columns(py, &metrics)
}

/// Every ride, in order; the first failure ends the others.
fn run(rides: &[Wanted], teller: &Teller<()>) -> Vec<Result<Metrics, Failure>> {
    let failed = AtomicBool::new(false);
    let go_on = || teller.go_on() && !failed.load(Ordering::Relaxed);
    let one = |wanted: &Wanted| {
        let result = ride(wanted, &go_on);
        match &result {
            Ok(_) => teller.tell(()),
            Err(_) => failed.store(true, Ordering::Relaxed),
        }
        result
    };
    rides.par_iter().with_max_len(1).map(one).collect()
}

fn ride(wanted: &Wanted, go_on: &dyn Fn() -> bool) -> Result<Metrics, Failure> {
    if !go_on() {
        return Err(Failure::Stopped);
    }
    let (course, stabilizer, assignments) = wanted;
    let ride = Ride::load(course, assignments)
        .map_err(Failure::Setup)?
        .with_stabilizer(*stabilizer);
    let settings = Settings {
        log: None,
        version: String::new(),
        git_hash: String::new(),
    };
    let mut port = InProcess::new(twinhub_sim::in_process(&ride.law));
    let mut watch =
        |progress: twinhub_sim::Progress| !progress.tick.is_multiple_of(STOP_EVERY) || go_on();
    let outcome =
        twinhub_sim::ride(&ride, &settings, &mut port, &mut watch).map_err(Failure::Ride)?;
    if outcome.ending == twinhub_sim::Ending::Stopped {
        return Err(Failure::Stopped);
    }
    Ok(outcome.metrics)
}

fn columns<'py>(py: Python<'py>, rides: &[Metrics]) -> PyResult<Bound<'py, PyDict>> {
    let columns = PyDict::new(py);
    let fell: Vec<bool> = rides.iter().map(|m| m.fell).collect();
    columns.set_item("fell", fell.into_pyarray(py))?;
    let numbers: [(&str, fn(&Metrics) -> f64); 8] = [
        ("roll_rms_rad", |m| m.roll_rms_rad),
        ("steer_rms_rad", |m| m.steer_rms_rad),
        ("steer_rate_rms_rad_s", |m| m.steer_rate_rms_rad_s),
        ("roll_max_rad", |m| m.roll_max_rad),
        ("swing_hz", |m| m.swing_hz),
        ("rider_effort_rms_nm", |m| m.rider_effort_rms_nm),
        ("energy_j", |m| m.energy_j),
        ("distance_m", |m| m.distance_m),
    ];
    for (name, number) in numbers {
        let values: Vec<f64> = rides.iter().map(number).collect();
        columns.set_item(name, values.into_pyarray(py))?;
    }
    let counts: [(&str, fn(&Metrics) -> u64); 2] = [
        ("front_locked_ticks", |m| m.front_locked_ticks),
        ("ticks", |m| m.ticks),
    ];
    for (name, count) in counts {
        let values: Vec<i64> = rides.iter().map(|m| count(m) as i64).collect();
        columns.set_item(name, values.into_pyarray(py))?;
    }
    Ok(columns)
}
