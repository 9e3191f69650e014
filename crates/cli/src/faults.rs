//! `twinhub faults`: the fault matrix.

use crate::exit::{self, bad_input, environment};
use anyhow::anyhow;
use clap::Args;
use indicatif::{ProgressBar, ProgressStyle};
use serde_json::json;
use std::process::ExitCode;
use twinhub_league::faults::{
    Case, Finding, HARMLESS_NM, Matrix, ONSET_S, SPEED_M_S, WITHDRAWN_NM_S, cases,
};
use twinhub_sim::setup::load_law;

/// Break every sensor and the link in every way, one at a time, and say for each fault: how soon a
/// flag rises, whether a limit breaks, and who falls, beside the same riders without the fault and
/// those who were never assisted.
#[derive(Args, Debug)]
pub struct FaultsArgs {
    /// A law that ships, or a law file
    #[arg(long, value_name = "LAW", default_value = "scheduled")]
    law: String,
    /// Rides of each fault
    #[arg(long, value_name = "N", default_value_t = 4)]
    riders: u64,
    /// Only faults whose name contains this
    #[arg(long, value_name = "TEXT")]
    only: Option<String>,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// Runs the command: exit code 1 if a limit breaks or a fault is neither detected nor harmless.
///
/// # Errors
/// If an argument is wrong (2), or a ride cannot be ridden (3).
pub fn run(args: &FaultsArgs) -> anyhow::Result<ExitCode> {
    let law = load_law(&args.law, &[]).map_err(bad_input)?;
    let chosen: Vec<Case> = cases()
        .into_iter()
        .filter(|case| {
            args.only
                .as_ref()
                .is_none_or(|text| case.name.contains(text))
        })
        .collect();
    if chosen.is_empty() {
        let names: Vec<String> = cases().into_iter().map(|case| case.name).collect();
        return Err(bad_input(anyhow!(
            "--only {}: no fault has that in its name; accepted: part of {}",
            args.only.as_deref().unwrap_or_default(),
            names.join(", ")
        )));
    }
    let matrix = Matrix::new(&args.law, law, args.riders).map_err(bad_input)?;
    let bar = ProgressBar::new(chosen.len() as u64);
    bar.set_style(
        ProgressStyle::with_template("{bar:40} {pos}/{len} faults  {elapsed}, {eta} to go")
            .unwrap_or_else(|_| ProgressStyle::default_bar()),
    );
    let found = matrix
        .run(&chosen, &|done| bar.set_position(done as u64))
        .map_err(environment)?;
    bar.finish_and_clear();
    if args.json {
        println!(
            "{}",
            serde_json::to_string_pretty(&json!({
                "schema_version": 1,
                "law": args.law,
                "speed_m_s": SPEED_M_S,
                "onset_s": ONSET_S,
                "harmless_nm": HARMLESS_NM,
                "withdrawn_nm_s": WITHDRAWN_NM_S,
                "faults": found,
            }))?
        );
    } else {
        print(&found);
    }
    let bad = |f: &Finding| f.limits_broken > 0 || f.verdict == "open";
    Ok(if found.iter().any(bad) {
        ExitCode::from(exit::FELL)
    } else {
        ExitCode::SUCCESS
    })
}

fn print(found: &[Finding]) {
    let width = found.iter().map(|f| f.fault.len()).max().unwrap_or(0);
    println!(
        "{:width$}  {:>9} {:>10} {:>10} {:>10}  {:>24}  {:9} flags",
        "fault, straight at 4.5 m/s",
        "stated",
        "noticed",
        "pair more",
        "withdrawn",
        "falls: fault, none, never",
        "verdict"
    );
    for f in found {
        let time = |t: Option<f64>| t.map_or("-".to_owned(), |t| format!("{:.0} ms", t * 1e3));
        println!(
            "{:width$}  {:>9} {:>10} {:>7.1} Nm {:>5.0} Nm/s  {:>24}  {:9} {}",
            f.fault,
            time(f.stated_s),
            time(f.detected_s),
            f.pair_more_nm,
            f.withdrawn_nm_s,
            format!(
                "{}, {}, {} of {}",
                f.falls, f.falls_healthy, f.falls_never_assisted, f.rides
            ),
            f.verdict,
            f.flags.join(", ")
        );
    }
    let count = |verdict| found.iter().filter(|f| f.verdict == verdict).count();
    let broken: u64 = found.iter().map(|f| f.limits_broken).sum();
    println!(
        "\n{} faults: {} detected in time, {} harmless, {} open; limits broken in {broken} ticks",
        found.len(),
        count("detected"),
        count("harmless"),
        count("open")
    );
}
