//! Many rides, on all cores.

use crate::errors;
use numpy::IntoPyArray;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use rayon::prelude::*;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;
use twinhub_link::InProcess;
use twinhub_sim::{Metrics, Ride, RideError, Settings};

/// Wall time between two looks at signals and progress.
const LOOK_EVERY: Duration = Duration::from_millis(100);
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
    let found = py.detach(|| run(&pool, &rides, progress.as_ref()))?;
    columns(py, &found)
}

fn run(
    pool: &rayon::ThreadPool,
    rides: &[Wanted],
    progress: Option<&Py<PyAny>>,
) -> PyResult<Vec<Metrics>> {
    let stop = AtomicBool::new(false);
    let done = AtomicUsize::new(0);
    let failed: Mutex<Option<(usize, Failure)>> = Mutex::new(None);
    let (finished, when_finished) = channel::<()>();
    let raised: Mutex<Option<PyErr>> = Mutex::new(None);
    let mut results: Vec<Option<Metrics>> = Vec::new();
    std::thread::scope(|scope| {
        let work = scope.spawn(|| {
            let found = pool.install(|| {
                let one = |(index, wanted): (usize, &Wanted)| match ride(wanted, &stop) {
                    Ok(metrics) => {
                        done.fetch_add(1, Ordering::Relaxed);
                        Some(metrics)
                    }
                    Err(Failure::Stopped) => None,
                    Err(failure) => {
                        stop.store(true, Ordering::Relaxed);
                        if let Ok(mut failed) = failed.lock()
                            && failed.as_ref().is_none_or(|(first, _)| index < *first)
                        {
                            *failed = Some((index, failure));
                        }
                        None
                    }
                };
                rides.par_iter().enumerate().with_max_len(1).map(one).collect()
            });
            drop(finished);
            found
        });
        let mut told = 0;
        loop {
            let over = !matches!(
                when_finished.recv_timeout(LOOK_EVERY),
                Err(RecvTimeoutError::Timeout)
            );
            let now = done.load(Ordering::Relaxed);
            // Once it has raised, nothing is told any more.
            let stopped = stop.load(Ordering::Relaxed);
            let looked = Python::attach(|py| -> PyResult<()> {
                py.check_signals()?;
                match progress {
                    Some(progress) if now > told && !stopped => {
                        progress.call1(py, (now, rides.len()))?;
                    }
                    _ => {}
                }
                Ok(())
            });
            told = now;
            if let Err(error) = looked {
                stop.store(true, Ordering::Relaxed);
                if let Ok(mut raised) = raised.lock() {
                    raised.get_or_insert(error);
                }
            }
            if over {
                break;
            }
        }
        match work.join() {
            Ok(found) => results = found,
            Err(panic) => {
                if let Ok(mut raised) = raised.lock() {
                    raised.get_or_insert(crate::watched::panicked(&*panic));
                }
            }
        }
    });
    if let Ok(Some(error)) = raised.into_inner() {
        return Err(error);
    }
    match failed.into_inner() {
        Ok(Some((index, Failure::Setup(error)))) => {
            let error = errors::setup(error);
            return Err(errors::input(format!("ride {index}: {error}")));
        }
        Ok(Some((index, Failure::Ride(error)))) => {
            return Err(errors::python::RideError::new_err(format!(
                "ride {index}: {error}"
            )));
        }
        _ => {}
    }
    Ok(results.into_iter().flatten().collect())
}

fn ride(wanted: &Wanted, stop: &AtomicBool) -> Result<Metrics, Failure> {
    if stop.load(Ordering::Relaxed) {
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
    let mut watch = |progress: twinhub_sim::Progress| {
        !progress.tick.is_multiple_of(STOP_EVERY) || !stop.load(Ordering::Relaxed)
    };
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
