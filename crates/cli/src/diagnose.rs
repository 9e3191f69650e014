//! `twinhub diagnose`: what the model gets wrong, why, and what is gained by mending it.

use crate::exit::{bad_input, environment};
use anyhow::Context;
use clap::Args;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use twinhub_diagnose::data::DataFolders;
use twinhub_diagnose::study::Study;
use twinhub_diagnose::{Answer, Options, diagnose_in};
use twinhub_report::diagnose::diagnose_page;

/// Find what the bicycle model gets wrong about measured rides: where, which cause, with what it may
/// be confounded, and how much better the extended model predicts rides that were held out.
#[derive(Args, Debug)]
pub struct DiagnoseArgs {
    /// Study file, or the name of one that ships (`twinhub list studies`)
    #[arg(value_name = "STUDY.toml")]
    study: String,
    /// Folder that holds the rides, after the study's own folder and before $TWINHUB_DATA
    #[arg(long, value_name = "DIR")]
    data: Option<PathBuf>,
    /// Change a key of the study, as bicycle.values.IBxx=9.2; repeatable
    #[arg(long, value_name = "PATH=VALUE")]
    set: Vec<String>,
    /// Leave a mechanism out of the library; repeatable
    #[arg(long, value_name = "MECHANISM")]
    without: Vec<String>,
    /// Look for this mechanism only; repeatable
    #[arg(long, value_name = "MECHANISM")]
    only: Vec<String>,
    /// Print JSON
    #[arg(long)]
    json: bool,
    /// Where to write the page [default: rides/diagnose_NAME.html; none with --json]
    #[arg(long, value_name = "FILE.html")]
    out: Option<PathBuf>,
    /// Where to write the extended plant, if a cause was found
    #[arg(long, value_name = "FILE.toml")]
    extended: Option<PathBuf>,
}

/// Runs the command.
///
/// # Errors
/// If the study or its files are wrong (exit code 2), or a file cannot be written (3).
pub fn run(args: &DiagnoseArgs) -> anyhow::Result<ExitCode> {
    let study = Study::read(&args.study, &args.set).map_err(bad_input)?;
    let folders = DataFolders::new(&study, args.data.as_deref());
    let options = Options {
        without: args.without.clone(),
        only: args.only.clone(),
    };
    // Draws on a terminal only.
    let bar = indicatif::ProgressBar::new_spinner();
    let mut answer = diagnose_in(&study, &folders, &options, &mut |text| {
        bar.set_message(text.to_owned());
        bar.tick();
    })
    .map_err(bad_input)?;
    bar.finish_and_clear();
    if let (Some(path), Some(plant)) = (&args.extended, &answer.plant) {
        write(path, &plant.to_toml()).map_err(environment)?;
        answer.extended_plant = Some(path.display().to_string());
    }
    let page = match (&args.out, args.json) {
        (Some(path), _) => Some(path.clone()),
        (None, true) => None,
        (None, false) => {
            let stem = study
                .file
                .file_stem()
                .map_or("study".into(), |s| s.to_string_lossy());
            Some(PathBuf::from(format!("rides/diagnose_{stem}.html")))
        }
    };
    if let Some(path) = &page {
        write(path, &diagnose_page(&crate::diagnose_page::page(&answer))).map_err(environment)?;
    }
    match args.json {
        true => println!("{}", serde_json::to_string_pretty(&answer)?),
        false => print(&answer, page.as_deref()),
    }
    Ok(ExitCode::SUCCESS)
}

fn write(path: &Path, text: &str) -> anyhow::Result<()> {
    if let Some(folder) = path.parent().filter(|f| !f.as_os_str().is_empty()) {
        std::fs::create_dir_all(folder)
            .with_context(|| format!("cannot make the folder {}", folder.display()))?;
    }
    std::fs::write(path, text).with_context(|| format!("cannot write {}", path.display()))
}

fn print(answer: &Answer, page: Option<&Path>) {
    println!("{}\n\nverdict: {}", answer.study, answer.verdict.name());
    for statement in &answer.statements {
        println!("{statement}");
    }
    if !answer.gain.is_empty() {
        println!("\nVAF 0.5 s ahead on held-out rides");
        println!(
            "{:28} {:>8} {:>10} {:>8} {:>8}",
            "channel", "nominal", "calibrated", "extended", "ceiling"
        );
        let number = |x: Option<f64>| x.map_or("-".to_owned(), |x| format!("{x:.3}"));
        for (name, gain) in &answer.gain {
            println!(
                "{name:28} {:>8} {:>10} {:>8} {:>8}",
                number(gain.nominal_vaf),
                number(gain.calibrated_vaf),
                number(gain.extended_vaf),
                number(gain.ceiling_vaf)
            );
        }
    }
    if !answer.candidates.is_empty() {
        println!("\ncandidates refitted, gain in nats (fit, held out)");
        for c in &answer.candidates {
            let held = c
                .held_out_gain_nats
                .map_or("-".to_owned(), |g| format!("{g:.1}"));
            println!("{:28} {:>8.1} {held:>8}", c.mechanism, c.fit_gain_nats);
        }
    }
    if !answer.detection_limits.is_empty() {
        println!("\nsmallest size that these rides would show");
        for (name, limits) in &answer.detection_limits {
            for (parameter, limit) in limits {
                println!("{name:28} {parameter} {limit:.3e}");
            }
        }
    }
    for n in &answer.not_testable {
        println!("not testable: {}: {}", n.mechanism, n.why);
    }
    if let Some(plant) = &answer.extended_plant {
        println!("extended plant: {plant}");
    }
    if let Some(path) = page {
        println!("report: {}", path.display());
    }
}
