//! `twinhub modes`: eigenvalues over speed, weave and capsize speed, stable ranges, the picture.

mod benchmark;
mod multibody;
mod print;
mod sensitivities;

use crate::exit::bad_input;
use crate::span;
use anyhow::anyhow;
pub use print::{is_page, picture_name};
use std::path::PathBuf;
use std::process::ExitCode;
use twinhub_plant::bicycles::{self, Bicycle};

/// Arguments of `twinhub modes`.
#[derive(clap::Args)]
pub struct ModesArgs {
    /// A set that ships, with options as NAME:OPTION=VALUE (`twinhub list bicycles`), a bicycle or
    /// plant .toml, a BicycleParameters *Benchmark.txt, or BICYCLE+RIDER
    #[arg(
        long,
        value_name = "NAME_OR_FILE",
        default_value = "meijaard2007_benchmark"
    )]
    bicycle: String,
    /// Front brake torque of the motor pair, N m; the rear motor balances it
    #[arg(
        long,
        value_name = "T",
        default_value_t = 0.0,
        allow_hyphen_values = true
    )]
    torque_nm: f64,
    /// Rear traction torque, N m, instead of the balancing one
    #[arg(long, value_name = "R", allow_hyphen_values = true)]
    rear_torque_nm: Option<f64>,
    /// Steady turn with this roll angle instead of straight ahead, degrees (multibody only)
    #[arg(long, value_name = "DEG", allow_hyphen_values = true)]
    roll_deg: Option<f64>,
    /// Speeds from A to B by STEP, m/s; by default 0:10:0.5, multibody 0.5:10:0.5
    #[arg(long, value_name = "A:B:STEP", allow_hyphen_values = true)]
    speeds_m_s: Option<String>,
    /// Changes a parameter: a symbol of Meijaard et al. (2007) as c=0.05, or for a multibody
    /// bicycle a path of its file as tyre.front.twisting_gain=0.1 (`twinhub list parameters`)
    #[arg(long = "set", value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// Derivatives of weave speed and weave eigenvalue with respect to every parameter (multibody
    /// only)
    #[arg(long)]
    sensitivities: bool,
    /// Adds the shape of every mode to the JSON
    #[arg(long)]
    shapes: bool,
    /// Prints the result as JSON
    #[arg(long)]
    json: bool,
    /// File for the picture, .svg or .html; by default modes_BICYCLE.svg, with --json none
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

/// Computes and prints the modes.
pub fn run(args: &ModesArgs) -> anyhow::Result<ExitCode> {
    for (flag, number) in [
        ("--torque-nm", Some(args.torque_nm)),
        ("--rear-torque-nm", args.rear_torque_nm),
    ] {
        if let Some(number) = number.filter(|t| !t.is_finite()) {
            return Err(bad_input(anyhow!(
                "{flag} {number}: accepted: a finite number of newton metres"
            )));
        }
    }
    if let Some(out) = &args.out {
        is_page(out).map_err(bad_input)?;
    }
    match bicycles::load(&args.bicycle, &args.set).map_err(bad_input)? {
        Bicycle::Benchmark(bicycle) => benchmark::run(args, &bicycle),
        Bicycle::Multibody(parameters) => multibody::run(args, &parameters),
    }
}

impl ModesArgs {
    /// The speeds asked for, or those of `default`.
    fn speeds(&self, default: &str) -> anyhow::Result<Vec<f64>> {
        let text = self.speeds_m_s.as_deref().unwrap_or(default);
        span::numbers("--speeds-m-s", text, "m/s", 0.0)
    }

    /// The file for the picture, if there is to be one.
    fn picture(&self, name: &str) -> Option<PathBuf> {
        self.out
            .clone()
            .or_else(|| (!self.json).then(|| picture_name("modes", name)))
    }
}
