//! The `twinhub` command: arguments and printing only; the work is done by the crates below.

mod bicycle;
mod blind;
mod catalogue;
mod certify;
mod children;
mod compare;
mod design;
mod design_print;
mod diagnose;
mod diagnose_page;
mod doctor;
mod exit;
mod experiment;
mod faults;
mod interrupt;
mod league;
mod league_print;
mod link_args;
mod map;
mod modes;
mod processes;
mod registries;
mod replay;
mod reproduce;
mod ride;
mod ride_report;
mod rider;
mod simulate;
mod soak;
mod span;
mod streams;
mod torture;
mod tyre;

use clap::{CommandFactory, Parser, Subcommand};
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
    /// Ride a course twice, stabilizer off and on; logs, table and report
    Ride(ride::RideArgs),
    /// Riders: do they keep a bicycle up, and which would
    Rider(rider::RiderArgs),
    /// What a ride's controller was told, told again: to the log, to the firmware in QEMU
    Replay(replay::ReplayArgs),
    /// Eigenvalues over speed, weave and capsize speed, stable ranges, and their picture
    Modes(modes::ModesArgs),
    /// Stability of a multibody bicycle over speed and motor torque, and its picture
    Map(map::MapArgs),
    /// One open-loop run of the multibody plant: a scenario file in, rows as CSV out
    Simulate(simulate::SimulateArgs),
    /// Measured rides against the model: how wrong it is, and where
    Compare(compare::CompareArgs),
    /// What the model gets wrong about measured rides, why, and what mending it gains
    Diagnose(diagnose::DiagnoseArgs),
    /// What rides like these could show, and what they could not tell apart
    Experiment(experiment::ExperimentArgs),
    /// Sealed rides with a known answer through the diagnosis, and its metrics
    Blind(blind::BlindArgs),
    /// Controllers against each other over a population of riders
    League(league::LeagueArgs),
    /// Files of a league's shards, put together
    Merge(league::MergeArgs),
    /// The schedule of a pair for a bicycle, with a proof that its riders stay up
    Design(design::DesignArgs),
    /// A schedule's proof, checked without a solver
    Certify(certify::CertifyArgs),
    /// What each fault of a sensor or of the link does to a ride
    Faults(faults::FaultsArgs),
    /// The figures of Bulsink (2017) beside those of the multibody model
    Reproduce(reproduce::ReproduceArgs),
    /// Forces and torques of a tyre
    Tyre(tyre::TyreArgs),
    /// The file of a bicycle, to keep, to read, to edit
    Bicycle(bicycle::BicycleArgs),
    /// What this machine allows a ride, and how to get more
    Doctor(doctor::DoctorArgs),
    /// One long ride: whether speed and memory stay what they are
    Soak(soak::SoakArgs),
    /// Kill, stop and continue either side of rides, and look at what is left
    Torture(torture::TortureArgs),
    /// Names of everything that ships
    List(catalogue::ListArgs),
    /// What a name means: equation, source, values
    Explain(catalogue::ExplainArgs),
    /// Completions for a shell
    Completions {
        /// The shell.
        shell: clap_complete::Shell,
    },
    /// The plant's side of a ride; started by `ride`
    #[command(name = processes::PLANT, hide = true)]
    PlantProcess,
    /// The controller's side of a ride; started by `ride`
    #[command(name = processes::CONTROLLER, hide = true)]
    ControllerProcess,
}

/// Lets the reader of our output hang up (`twinhub list | head`) without a panic.
fn end_quietly_on_a_closed_pipe() {
    // SAFETY: no other thread runs yet, and the default action is always valid.
    unsafe { libc::signal(libc::SIGPIPE, libc::SIG_DFL) };
}

fn run(cli: Cli) -> anyhow::Result<ExitCode> {
    // A ride writes to its own children, whose death it has to survive.
    if !matches!(
        cli.command,
        Command::Ride(_)
            | Command::Soak(_)
            | Command::League(_)
            | Command::Replay(_)
            | Command::Torture(_)
            | Command::PlantProcess
            | Command::ControllerProcess
    ) {
        end_quietly_on_a_closed_pipe();
    }
    match cli.command {
        Command::Ride(args) => ride::run(&args),
        Command::Rider(args) => rider::run(&args),
        Command::Replay(args) => replay::run(&args),
        Command::Modes(args) => modes::run(&args),
        Command::Map(args) => map::run(&args),
        Command::Simulate(args) => simulate::run(&args),
        Command::Reproduce(args) => reproduce::run(&args),
        Command::Tyre(args) => tyre::run(&args),
        Command::Compare(args) => compare::run(&args),
        Command::Bicycle(args) => bicycle::run(&args),
        Command::Soak(args) => soak::run(&args),
        Command::Torture(args) => torture::run(&args),
        Command::Doctor(args) => doctor::run(&args),
        Command::Diagnose(args) => diagnose::run(&args),
        Command::Experiment(args) => experiment::run(&args),
        Command::Blind(args) => blind::run(&args),
        Command::Design(args) => design::run(&args),
        Command::Certify(args) => certify::run(&args),
        Command::Faults(args) => faults::run(&args),
        Command::League(args) => league::run(&args),
        Command::Merge(args) => league::run_merge(&args),
        Command::List(args) => catalogue::list(&args),
        Command::Explain(args) => catalogue::explain(&args),
        Command::Completions { shell } => {
            clap_complete::generate(
                shell,
                &mut Cli::command(),
                "twinhub",
                &mut std::io::stdout(),
            );
            Ok(ExitCode::SUCCESS)
        }
        Command::PlantProcess => children::plant(),
        Command::ControllerProcess => children::controller(),
    }
}

fn main() -> ExitCode {
    match run(Cli::parse()) {
        Ok(code) => code,
        Err(error) => exit::report(&error),
    }
}
