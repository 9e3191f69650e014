//! The linear bicycle against published figures, an independent model, and measured bicycles.

mod data_folder;
mod files;
mod modes;
mod no_slip;
mod physics;
mod published;

use twinhub_linear::{Bicycle, Canonical};

fn built_in(name: &str) -> (Bicycle, Canonical) {
    let bicycle = Bicycle::load(name).unwrap();
    let equations = Canonical::new(&bicycle).unwrap();
    (bicycle, equations)
}
