//! `twinhub bicycle`: the file of a bicycle, to keep, to read, to edit.

use crate::exit::bad_input;
use std::process::ExitCode;
use twinhub_plant::bicycles;

/// Arguments of `twinhub bicycle`.
#[derive(clap::Args)]
pub struct BicycleArgs {
    /// A set that ships, with options as NAME:OPTION=VALUE (`twinhub list bicycles`), or a file
    name: String,
    /// Changes a parameter, as tyre.front.twisting_gain=0.1 or (linear bicycles) c=0.05
    #[arg(long = "set", value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// Of a linear bicycle, the multibody one without slip and with a rigid rider
    #[arg(long)]
    multibody: bool,
}

/// Prints the file; every command that takes a bicycle takes it.
pub fn run(args: &BicycleArgs) -> anyhow::Result<ExitCode> {
    let text = if args.multibody {
        bicycles::load_multibody(&args.name, &args.set)
            .map_err(bad_input)?
            .to_toml()
    } else {
        bicycles::load(&args.name, &args.set)
            .map_err(bad_input)?
            .to_toml()
    };
    print!("{text}");
    Ok(ExitCode::SUCCESS)
}
