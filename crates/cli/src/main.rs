//! The `twinhub` command: arguments and printing only; the work is done by the crates below.

mod exit;

use clap::{Parser, Subcommand};
use std::process::ExitCode;

/// Stabilizer for e-bikes with two hub motors, and the bench that it is developed on.
#[derive(Parser)]
#[command(version, propagate_version = true)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    // One line a command: `/// what it does` and `Name(module::NameArgs)`.
}

fn run(cli: Cli) -> anyhow::Result<ExitCode> {
    match cli.command {}
}

fn main() -> ExitCode {
    match run(Cli::parse()) {
        Ok(code) => code,
        Err(error) => exit::report(&error),
    }
}
