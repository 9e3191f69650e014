//! Errors of the crates as the exceptions of `twinhub.errors`.

/// The exceptions, as the Python package defines them.
pub mod python {
    pyo3::import_exception!(twinhub.errors, InputError);
    pyo3::import_exception!(twinhub.errors, LogError);
    pyo3::import_exception!(twinhub.errors, RideError);
}

use pyo3::PyErr;
use std::sync::Mutex;

/// Input that the caller can mend.
pub fn input(error: impl std::fmt::Display) -> PyErr {
    python::InputError::new_err(error.to_string())
}

/// A log that cannot be written or read.
pub fn log(error: &twinhub_log::LogError) -> PyErr {
    python::LogError::new_err(error.to_string())
}

/// A ride that cannot be set up.
pub fn setup(error: twinhub_sim::SetupError) -> PyErr {
    match error {
        // Its message names the flag of the command line.
        twinhub_sim::SetupError::Override { assignment, detail } => input(format!(
            "set {}: {detail}",
            assignment.replace(" --set ", ", ")
        )),
        other => input(other),
    }
}

/// A ride that had begun.
pub fn ride(error: twinhub_sim::RideError) -> PyErr {
    match error {
        twinhub_sim::RideError::Setup(error) => setup(error),
        twinhub_sim::RideError::Log(error) => log(&error),
        other => python::RideError::new_err(other.to_string()),
    }
}

/// Keeps what the caller's own code raised; what it raised first counts.
pub fn keep(raised: &Mutex<Option<PyErr>>, error: PyErr) {
    if let Ok(mut raised) = raised.lock() {
        raised.get_or_insert(error);
    }
}
