//! `firmware_sim`: the controller process by itself, for any plant that speaks the services.

use clap::Parser;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;
use twinhub_link::{RideName, RunDir, Settings, Waiting};

/// The stabilizer's controller as a process: joins a ride and answers its plant tick by tick.
#[derive(Parser)]
#[command(version)]
struct Arguments {
    /// Name of the ride to join.
    #[arg(long)]
    ride: RideName,
    /// Law file (TOML): bicycle, limits and law of the stabilizer.
    #[arg(long)]
    law: PathBuf,
    /// Way of waiting for the plant: `spin` (fastest, takes a core) or `block`.
    #[arg(long, default_value = "spin")]
    waiting: Waiting,
    /// How long to wait for a plant to offer the ride, s; without limit unless given.
    #[arg(long)]
    wait_s: Option<f64>,
    /// Directory of the rides; `$TWINHUB_RUN_DIR` or `/tmp/twinhub-<uid>` unless given.
    #[arg(long)]
    run_dir: Option<PathBuf>,
    /// Print the summary as JSON on standard output.
    #[arg(long)]
    json: bool,
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    match run(&arguments) {
        Ok(code) => ExitCode::from(code),
        Err((code, error)) => {
            eprintln!("error: {error:#}");
            ExitCode::from(code)
        }
    }
}

fn run(arguments: &Arguments) -> Result<u8, (u8, anyhow::Error)> {
    let config = firmware_sim::read_law(&arguments.law).map_err(|e| (2, e.into()))?;
    let patience = match arguments.wait_s.map(Duration::try_from_secs_f64) {
        None => None,
        Some(Ok(patience)) => Some(patience),
        Some(Err(e)) => return Err((2, anyhow::anyhow!("--wait-s: {e}"))),
    };
    let stop = Arc::new(AtomicBool::new(false));
    let flag = stop.clone();
    ctrlc::set_handler(move || flag.store(true, Ordering::Relaxed)).map_err(|e| (3, e.into()))?;
    let mut settings = Settings::new(arguments.ride.clone());
    settings.waiting = arguments.waiting;
    settings.patience = patience;
    settings.stop = stop;
    settings.identity.tool = concat!("firmware_sim ", env!("CARGO_PKG_VERSION")).to_owned();
    if let Some(path) = &arguments.run_dir {
        settings.run_dir = RunDir::at(path);
    }
    let summary = firmware_sim::run(firmware_sim::Options {
        settings,
        config,
        on_loss: Box::new(|_| {}),
    })
    .map_err(|e| (e.exit_code(), e.into()))?;
    if arguments.json {
        println!(
            "{}",
            serde_json::to_string(&summary).map_err(|e| (3, e.into()))?
        );
    } else {
        eprint!("{summary}");
    }
    Ok(summary.ended.exit_code())
}
