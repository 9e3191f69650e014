//! A ride in this process.

use crate::{VERSION, errors, log};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};
use twinhub_link::InProcess;
use twinhub_log::{LogError, LogFile};
use twinhub_sim::{Ending, Outcome, Progress, Ride, RideError, Settings, shipped};

/// Wall time between two looks at the signals.
const SIGNALS_EVERY: Duration = Duration::from_millis(100);
/// Ticks between two looks at the clock.
const CLOCK_EVERY: u64 = 64;

/// Names of the courses that ship.
#[pyfunction]
pub fn courses() -> Vec<&'static str> {
    shipped::names(shipped::COURSES)
}

/// Rides `course`; the log goes to `log`, or to a temporary file that is read back and deleted.
#[pyfunction]
pub fn ride(
    py: Python<'_>,
    course: &str,
    stabilizer: bool,
    assignments: Vec<String>,
    log: Option<PathBuf>,
) -> PyResult<Py<PyDict>> {
    let ride = Ride::load(course, &assignments)
        .map_err(errors::setup)?
        .with_stabilizer(stabilizer);
    let (path, directory) = match log {
        Some(path) => (path, None),
        None => {
            let directory = tempfile::Builder::new()
                .prefix("twinhub-")
                .tempdir()
                .map_err(no_directory)?;
            (directory.path().join("ride.mcap"), Some(directory))
        }
    };
    let (outcome, read) = py.detach(|| ride_and_read(&ride, &path))?;
    drop(directory);

    let answer = log::to_python(py, read)?;
    let m = &outcome.metrics;
    let metrics = PyDict::new(py);
    metrics.set_item("fell", m.fell)?;
    metrics.set_item("roll_rms_rad", m.roll_rms_rad)?;
    metrics.set_item("steer_rms_rad", m.steer_rms_rad)?;
    metrics.set_item("rider_effort_rms_nm", m.rider_effort_rms_nm)?;
    metrics.set_item("energy_j", m.energy_j)?;
    metrics.set_item("distance_m", m.distance_m)?;
    metrics.set_item("ticks", m.ticks)?;
    metrics.set_item("missed_ticks", m.missed_ticks)?;
    answer.set_item("metrics", metrics)?;
    answer.set_item("course", ride.name)?;
    answer.set_item("seed", ride.course.seed)?;
    Ok(answer.unbind())
}

fn no_directory(error: std::io::Error) -> PyErr {
    errors::python::LogError::new_err(format!(
        "no temporary directory for the log: {error}; give a file with log=, or another directory in $TMPDIR"
    ))
}

/// Why there is no ride.
enum Failure {
    Ride(RideError),
    Log(LogError),
    /// What a signal handler raised: `KeyboardInterrupt`.
    Signal(PyErr),
}

impl From<Failure> for PyErr {
    fn from(failure: Failure) -> Self {
        match failure {
            Failure::Ride(error) => errors::ride(error),
            Failure::Log(error) => errors::log(&error),
            Failure::Signal(error) => error,
        }
    }
}

/// Runs without the interpreter's lock, but for a look at the signals now and then.
fn ride_and_read(ride: &Ride, path: &Path) -> Result<(Outcome, LogFile), Failure> {
    let settings = Settings {
        log: Some(path.to_owned()),
        version: VERSION.to_owned(),
        git_hash: option_env!("TWINHUB_GIT_HASH")
            .unwrap_or("unknown")
            .to_owned(),
    };
    let mut port = InProcess::new(twinhub_sim::in_process(&ride.law));
    let mut signal = None;
    let mut looked = Instant::now();
    let mut watch = |progress: Progress| {
        if progress.tick.is_multiple_of(CLOCK_EVERY) && looked.elapsed() >= SIGNALS_EVERY {
            looked = Instant::now();
            signal = Python::attach(|py| py.check_signals()).err();
        }
        signal.is_none()
    };
    let outcome = twinhub_sim::ride(ride, &settings, &mut port, &mut watch);
    if let Some(error) = signal {
        return Err(Failure::Signal(error));
    }
    let outcome = outcome.map_err(Failure::Ride)?;
    let log = twinhub_log::read(path).map_err(Failure::Log)?;
    debug_assert_ne!(outcome.ending, Ending::Stopped, "nobody else stops a ride");
    Ok((outcome, log))
}
