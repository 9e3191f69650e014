//! `twinhub._twinhub`: what the Python package `twinhub` calls.
//!
//! Plain functions that give dictionaries, lists and numpy arrays; names, units, checks of types
//! and documentation are in `python/twinhub`. Long work runs without the interpreter's lock.

mod bicycle;
mod errors;
mod log;
mod modes;
mod ride;

/// Compiled part of `twinhub`.
#[pyo3::pymodule]
mod _twinhub {
    #[pymodule_export]
    use crate::bicycle::{bicycles, parameter_units, parameters};
    #[pymodule_export]
    use crate::log::read_log;
    #[pymodule_export]
    use crate::modes::modes;
    #[pymodule_export]
    use crate::ride::{courses, ride};

    #[pymodule_export]
    #[allow(non_upper_case_globals)]
    const __version__: &str = crate::VERSION;
}

/// Version of the package.
pub(crate) const VERSION: &str = env!("CARGO_PKG_VERSION");
