//! A ride in this process.

use crate::controller::PythonLaw;
use crate::{VERSION, errors, log};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::time::{Duration, Instant};
use twinhub_link::InProcess;
use twinhub_log::{LogError, LogFile};
use twinhub_plant::rider::{Action, Perception};
use twinhub_sim::{Ending, Metrics, Outcome, Progress, Ride, RideError, Settings, shipped};
use twinhub_types::PlantFrame;

/// Wall time between two looks at the signals.
const SIGNALS_EVERY: Duration = Duration::from_millis(100);
/// Ticks between two looks at the clock.
const CLOCK_EVERY: u64 = 64;

/// Names of the courses that ship.
#[pyfunction]
pub fn courses() -> Vec<&'static str> {
    shipped::names(shipped::COURSES)
}

/// The numbers of a ride.
pub fn numbers<'py>(py: Python<'py>, m: &Metrics) -> PyResult<Bound<'py, PyDict>> {
    let metrics = PyDict::new(py);
    metrics.set_item("fell", m.fell)?;
    metrics.set_item("roll_rms_rad", m.roll_rms_rad)?;
    metrics.set_item("steer_rms_rad", m.steer_rms_rad)?;
    metrics.set_item("steer_rate_rms_rad_s", m.steer_rate_rms_rad_s)?;
    metrics.set_item("roll_max_rad", m.roll_max_rad)?;
    metrics.set_item("swing_hz", m.swing_hz)?;
    metrics.set_item("rider_effort_rms_nm", m.rider_effort_rms_nm)?;
    metrics.set_item("energy_j", m.energy_j)?;
    metrics.set_item("distance_m", m.distance_m)?;
    metrics.set_item("front_locked_ticks", m.front_locked_ticks)?;
    metrics.set_item("ticks", m.ticks)?;
    metrics.set_item("missed_ticks", m.missed_ticks)?;
    Ok(metrics)
}

/// Rides `course`; the log goes to `log`, or to a temporary file that is read back and deleted.
/// `law` and `rider` are callables that take the place of the course's.
#[pyfunction]
#[allow(clippy::too_many_arguments)] // the arguments of the Python function
pub fn ride(
    py: Python<'_>,
    course: &str,
    stabilizer: bool,
    assignments: Vec<String>,
    log: Option<PathBuf>,
    law: Option<Py<PyAny>>,
    rider: Option<Py<PyAny>>,
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
    let own = Own { law, rider };
    let (outcome, read) = py.detach(|| ride_and_read(&ride, &path, &own))?;
    drop(directory);

    let answer = log::to_python(py, read)?;
    answer.set_item("metrics", numbers(py, &outcome.metrics)?)?;
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

/// What the caller brings.
struct Own {
    law: Option<Py<PyAny>>,
    rider: Option<Py<PyAny>>,
}

/// Runs without the interpreter's lock, but for a look at the signals now and then and for what the
/// caller brings.
fn ride_and_read(ride: &Ride, path: &Path, own: &Own) -> Result<(Outcome, LogFile), Failure> {
    let settings = Settings {
        log: Some(path.to_owned()),
        version: VERSION.to_owned(),
        git_hash: option_env!("TWINHUB_GIT_HASH")
            .unwrap_or("unknown")
            .to_owned(),
    };
    let raised: Mutex<Option<PyErr>> = Mutex::new(None);
    let mut controller = twinhub_control::Controller::new(&ride.law);
    let answer = |frame: &PlantFrame| match &own.law {
        None => controller.answer(frame),
        Some(callable) => {
            let law = PythonLaw {
                callable,
                raised: &raised,
            };
            controller.answer_by(&mut |_, x, dt_s| law.demand(x, dt_s), frame)
        }
    };
    let mut port = InProcess::new(answer);
    let mut signal = None;
    let mut looked = Instant::now();
    let mut watch = |progress: Progress| {
        if progress.tick.is_multiple_of(CLOCK_EVERY) && looked.elapsed() >= SIGNALS_EVERY {
            looked = Instant::now();
            signal = Python::attach(|py| py.check_signals()).err();
        }
        signal.is_none() && raised.lock().is_ok_and(|raised| raised.is_none())
    };
    let mut act = own.rider.as_ref().map(|callable| {
        let rider = PythonRider {
            callable,
            raised: &raised,
        };
        move |perception: &Perception, step_s: f64| rider.act(perception, step_s)
    });
    let outcome = match &mut act {
        None => twinhub_sim::ride(ride, &settings, &mut port, &mut watch),
        Some(act) => twinhub_sim::ride_as(ride, &settings, &mut port, Some(act), &mut watch),
    };
    drop(act);
    drop(port);
    if let Some(error) = signal {
        return Err(Failure::Signal(error));
    }
    if let Ok(Some(error)) = raised.into_inner() {
        return Err(Failure::Signal(error));
    }
    let outcome = outcome.map_err(Failure::Ride)?;
    let log = twinhub_log::read(path).map_err(Failure::Log)?;
    debug_assert_ne!(outcome.ending, Ending::Stopped, "nobody else stops a ride");
    Ok((outcome, log))
}

/// A rider written in Python: what is perceived in, steer torque (and pedal force) out.
pub struct PythonRider<'a> {
    pub callable: &'a Py<PyAny>,
    pub raised: &'a Mutex<Option<PyErr>>,
}

impl PythonRider<'_> {
    /// What it does; nothing once it has raised.
    pub fn act(&self, p: &Perception, step_s: f64) -> Action {
        let asked = Python::attach(|py| -> PyResult<(f64, f64)> {
            let perceived = (
                p.roll_rad,
                p.roll_rate_rad_s,
                p.steer_rad,
                p.steer_rate_rad_s,
                p.yaw_rad,
                p.speed_m_s,
                p.wanted_speed_m_s,
            );
            let found = self.callable.bind(py).call1((perceived, step_s))?;
            let numbers = found.extract::<(f64, f64)>();
            let (torque_nm, force_n) = numbers.map_err(|_| {
                errors::input(format!(
                    "a rider gave {found}; accepted: steer_torque_nm, or (steer_torque_nm, pedal_force_n), \
                     as floats"
                ))
            })?;
            if torque_nm.is_finite() && force_n.is_finite() {
                Ok((torque_nm, force_n))
            } else {
                Err(errors::input(format!(
                    "a rider gave {torque_nm} Nm and {force_n} N; accepted: finite numbers"
                )))
            }
        });
        match asked {
            Ok((steer_torque_nm, pedal_force_n)) => Action {
                steer_torque_nm,
                pedal_force_n,
                ..Action::default()
            },
            Err(error) => {
                errors::keep(self.raised, error);
                Action::default()
            }
        }
    }
}
