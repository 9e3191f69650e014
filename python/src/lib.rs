//! `twinhub._twinhub`: what the Python package `twinhub` calls.
//!
//! Plain functions and two classes that give dictionaries, lists and numpy arrays; names, units, checks of types
//! and documentation are in `python/twinhub`. Long work runs without the interpreter's lock.

mod batch;
mod bicycle;
mod controller;
mod design;
mod diagnose;
mod errors;
mod league;
mod linear;
mod log;
mod map;
mod modes;
mod pictures;
mod ride;
mod stepper;
mod things;
mod watched;

/// Compiled part of `twinhub`.
#[pyo3::pymodule]
mod _twinhub {
    #[pymodule_export]
    use crate::batch::batch;
    #[pymodule_export]
    use crate::bicycle::{bicycles, parameter_units, parameters};
    #[pymodule_export]
    use crate::controller::{PyController, law_kinds, laws};
    #[pymodule_export]
    use crate::design::design;
    #[pymodule_export]
    use crate::diagnose::{diagnose, experiment};
    #[pymodule_export]
    use crate::league::{Stop, league_part, league_spec, league_table};
    #[pymodule_export]
    use crate::linear::{gradients, linearise};
    #[pymodule_export]
    use crate::log::read_log;
    #[pymodule_export]
    use crate::map::stability_map;
    #[pymodule_export]
    use crate::modes::modes;
    #[pymodule_export]
    use crate::pictures::{frontier_picture, line_chart};
    #[pymodule_export]
    use crate::ride::{courses, ride};
    #[pymodule_export]
    use crate::stepper::PyStepper;
    #[pymodule_export]
    use crate::things::{rider_growth, simulate, thing_names, thing_toml, tyre_forces};

    #[pymodule_export]
    #[allow(non_upper_case_globals)]
    const __version__: &str = crate::VERSION;
}

/// Version of the package.
pub(crate) const VERSION: &str = env!("CARGO_PKG_VERSION");
