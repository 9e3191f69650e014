//! `twinhub experiment`: what rides like these could show, and what they could not tell apart.

use crate::exit::bad_input;
use clap::Args;
use std::path::PathBuf;
use std::process::ExitCode;
use twinhub_diagnose::data::{DataFolders, RideData, read_ride};
use twinhub_diagnose::search::experiment::experiment;
use twinhub_diagnose::study::Study;

/// Say which causes the rides of a study could show at all, from which size on, which pairs they
/// could not tell apart, and which experiment would.
#[derive(Args, Debug)]
pub struct ExperimentArgs {
    /// Study file, or the name of one that ships (`twinhub list studies`)
    #[arg(value_name = "STUDY.toml")]
    study: String,
    /// Folder that holds the rides, after the study's own folder and before $TWINHUB_DATA
    #[arg(long, value_name = "DIR")]
    data: Option<PathBuf>,
    /// Change a key of the study; repeatable
    #[arg(long, value_name = "PATH=VALUE")]
    set: Vec<String>,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// Runs the command.
///
/// # Errors
/// If the study or a ride is wrong (exit code 2).
pub fn run(args: &ExperimentArgs) -> anyhow::Result<ExitCode> {
    let study = Study::read(&args.study, &args.set).map_err(bad_input)?;
    let folders = DataFolders::new(&study, args.data.as_deref());
    let data: Vec<RideData> = study
        .rides
        .iter()
        .map(|r| read_ride(r, &folders))
        .collect::<Result<_, _>>()
        .map_err(bad_input)?;
    // Draws on a terminal only.
    let bar = indicatif::ProgressBar::new_spinner();
    let found = experiment(&study, &data, &mut |text| {
        bar.set_message(text.to_owned());
        bar.tick();
    })
    .map_err(bad_input)?;
    bar.finish_and_clear();
    if args.json {
        println!("{}", serde_json::to_string_pretty(&found)?);
        return Ok(ExitCode::SUCCESS);
    }
    println!(
        "{}\n\nsmallest size that these rides would show",
        found.study
    );
    for v in &found.visible {
        println!("{:28} {} {:.3e}", v.mechanism, v.parameter, v.smallest);
    }
    println!("\npairs that these rides can hardly tell apart");
    for pair in &found.pairs {
        println!(
            "{:.3}  {} and {}",
            pair.correlation, pair.mechanisms[0], pair.mechanisms[1]
        );
    }
    println!("\nexperiments that would");
    for proposal in &found.proposals {
        let pairs: Vec<String> = proposal.separates.iter().map(|p| p.join(" / ")).collect();
        println!("{}: {}", proposal.what, pairs.join(", "));
    }
    println!();
    for n in &found.not_testable {
        println!("not testable: {}: {}", n.mechanism, n.why);
    }
    Ok(ExitCode::SUCCESS)
}
