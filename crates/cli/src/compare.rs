//! `twinhub compare`: measured rides against the model, by prediction.

use crate::exit::{bad_input, environment};
use anyhow::Context;
use clap::Args;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use twinhub_diagnose::compare::{Comparison, compare};
use twinhub_diagnose::data::{DataFolders, RideData, read_ride};
use twinhub_diagnose::study::Study;
use twinhub_report::compare::{ChannelPlot, ComparePage, RidePlot, ScoreRow, compare_page};

/// Set measured rides against the bicycle model: how well it predicts, and where it is worst.
///
/// The model's state comes from a predictor on past samples only, then it runs free for 0.1, 0.5
/// and 2 s, driven by the measured inputs.
#[derive(Args, Debug)]
pub struct CompareArgs {
    /// Study file, or the name of one that ships: davis_instrumented_105
    #[arg(value_name = "STUDY.toml")]
    study: String,
    /// Folder that holds the rides, after the study's own folder and before $TWINHUB_DATA
    #[arg(long, value_name = "DIR")]
    data: Option<PathBuf>,
    /// Change a key of the study, as bicycle.values.IBxx=9.2 or ride.0.channel.1.scale=-1; repeatable
    #[arg(long, value_name = "PATH=VALUE")]
    set: Vec<String>,
    /// Print JSON
    #[arg(long)]
    json: bool,
    /// Where to write the report [default: rides/compare_NAME.html; none with --json]
    #[arg(long, value_name = "FILE.html")]
    report: Option<PathBuf>,
}

/// Runs the command.
///
/// # Errors
/// If the study or a ride is wrong (exit code 2), or the report cannot be written (3).
pub fn run(args: &CompareArgs) -> anyhow::Result<ExitCode> {
    let study = Study::read(&args.study, &args.set).map_err(bad_input)?;
    let folders = DataFolders::new(&study, args.data.as_deref());
    let rides: Vec<RideData> = study
        .rides
        .iter()
        .map(|r| read_ride(r, &folders))
        .collect::<Result<_, _>>()
        .map_err(bad_input)?;
    // Draws on a terminal only.
    let bar = indicatif::ProgressBar::new_spinner();
    let found = compare(&study, &rides, |text| {
        bar.set_message(text.to_owned());
        bar.tick();
    })
    .map_err(bad_input)?;
    bar.finish_and_clear();
    let report = match (&args.report, args.json) {
        (Some(path), _) => Some(path.clone()),
        (None, true) => None,
        (None, false) => {
            let stem = study
                .file
                .file_stem()
                .map_or("study".into(), |s| s.to_string_lossy());
            Some(PathBuf::from(format!("rides/compare_{stem}.html")))
        }
    };
    if let Some(path) = &report {
        write_report(path, &compare_page(&page(&found))).map_err(environment)?;
    }
    match args.json {
        true => println!("{}", serde_json::to_string_pretty(&found)?),
        false => print!("{}", table(&found, report.as_deref())),
    }
    Ok(ExitCode::SUCCESS)
}

fn write_report(path: &Path, html: &str) -> anyhow::Result<()> {
    if let Some(folder) = path.parent().filter(|f| !f.as_os_str().is_empty()) {
        std::fs::create_dir_all(folder)
            .with_context(|| format!("cannot make the folder {}", folder.display()))?;
    }
    std::fs::write(path, html)
        .with_context(|| format!("cannot write the report {}", path.display()))
}

/// One row a channel, VAF and RMSE by horizon.
fn table(found: &Comparison, report: Option<&Path>) -> String {
    let mut text = format!("{}\n\n", found.study);
    let horizons: Vec<&String> = found
        .channels
        .values()
        .next()
        .map_or(vec![], |c| c.horizons.keys().collect());
    let width = found
        .channels
        .keys()
        .map(String::len)
        .max()
        .unwrap_or(0)
        .max(8);
    let _ = write!(text, "{:width$}", "");
    for horizon in &horizons {
        let _ = write!(text, "{:>26}", format!("{horizon} s ahead"));
    }
    let _ = write!(text, "\n{:width$}", "channel");
    for _ in &horizons {
        let _ = write!(text, " {:>8} {:>8} {:>7}", "VAF", "RMSE", "held");
    }
    text.push('\n');
    for (name, channel) in &found.channels {
        let _ = write!(text, "{name:width$}");
        for horizon in &horizons {
            let cell = channel.horizons.get(*horizon).and_then(Option::as_ref);
            let number = |x: Option<f64>, digits: usize| {
                x.map_or("-".to_owned(), |x| format!("{x:.digits$}"))
            };
            let (vaf, rmse) = (
                number(cell.and_then(|c| c.vaf), 2),
                number(cell.map(|c| c.rmse), 4),
            );
            let held = number(cell.and_then(|c| c.held_rmse), 4);
            let _ = write!(text, " {vaf:>8} {rmse:>8} {held:>7}");
        }
        text.push('\n');
    }
    text.push_str("RMSE in the unit of the channel; held: RMSE of holding the last reading\n\n");
    if let Some(worst) = &found.worst {
        let _ = writeln!(
            text,
            "worst: {:.2} to {:.2} s of {}, {} most ({:.1} times the channels' spread)",
            worst.start_s, worst.end_s, worst.ride, worst.channel, worst.error_ratio
        );
    }
    for statement in &found.statements {
        let _ = writeln!(text, "{statement}");
    }
    for finding in &found.findings {
        let _ = writeln!(text, "data: {}: {}", finding.column, finding.text);
    }
    if let Some(path) = report {
        let _ = writeln!(text, "report: {}", path.display());
    }
    text
}

fn page(found: &Comparison) -> ComparePage {
    let scores = found.channels.iter().flat_map(|(name, channel)| {
        channel.horizons.iter().map(move |(horizon, result)| {
            let result = result.as_ref();
            ScoreRow {
                channel: name.clone(),
                horizon_s: horizon.clone(),
                vaf: result.and_then(|r| r.vaf),
                rmse: result.map(|r| r.rmse),
                rmse_at_end: result.and_then(|r| r.rmse_at_end),
                held_vaf: result.and_then(|r| r.held_vaf),
                held_rmse: result.and_then(|r| r.held_rmse),
            }
        })
    });
    let rides = found
        .traces
        .iter()
        .enumerate()
        .map(|(index, trace)| RidePlot {
            name: trace.ride.clone(),
            worst_s: found
                .worst
                .as_ref()
                .filter(|w| w.ride_index == index)
                .map(|w| [w.start_s, w.end_s]),
            channels: trace
                .channels
                .iter()
                .map(|c| ChannelPlot {
                    quantity: c.quantity.name().to_owned(),
                    measured: c.measured.clone(),
                    predicted: c.predicted.iter().map(|p| [p[0], p[1], p[3]]).collect(),
                    free_run: c.free_run.clone(),
                })
                .collect(),
        });
    let relations = found.relations.iter().map(|r| {
        [
            format!("{} against {}", r.measured, r.expected),
            format!("{:.3}", r.slope),
            format!("{:.3}", r.r),
        ]
    });
    let mut details = format!(
        "study {}\nprocess noise: roll torque {:.3} Nm sqrt(s), steer torque {:.3} Nm sqrt(s)\n\
         mean normalised innovation squared {:.3} (1: the predictor knows how uncertain it is)\n",
        found.file,
        found.noise.roll_nm_sqrt_s,
        found.noise.steer_nm_sqrt_s,
        found.noise.consistency
    );
    for (name, channel) in &found.channels {
        let _ = writeln!(
            details,
            "{name}: column {}, sensor noise {:.2e}",
            channel.column, channel.noise_sd
        );
    }
    for level in &found.noise.at_limit {
        let _ = writeln!(details, "{level}: noise level at the end of its range");
    }
    ComparePage {
        title: found.study.clone(),
        lead: format!(
            "Measured against predicted, {:.2} m/s on average",
            found.mean_speed_m_s
        ),
        statements: found.statements.clone(),
        rides: rides.collect(),
        scores: scores.collect(),
        findings: found
            .findings
            .iter()
            .map(|f| format!("{}: {}", f.column, f.text))
            .collect(),
        relations: relations.collect(),
        details,
    }
}
