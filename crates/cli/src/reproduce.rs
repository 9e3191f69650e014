//! `twinhub reproduce`: the thesis's figures beside ours.

use crate::exit::{bad_input, environment};
use anyhow::{Context, Result, anyhow};
use clap::Args;
use serde_json::json;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use twinhub_report::reproduce::{Plot, ReproducePage};
use twinhub_reproduce::{Assumed, IDS, Reproduction, figures, markdown, readings, reproduce};

/// Every figure of Bulsink (2017) beside that of the multibody model, with one set of assumptions.
///
/// For each miss it says which assumption moves it, and the value that would meet it.
#[derive(Args, Debug)]
pub struct ReproduceArgs {
    /// Only this row; repeatable
    #[arg(long, value_name = "ID")]
    only: Vec<String>,
    /// Do not search for what would meet the misses
    #[arg(long)]
    quick: bool,
    /// Count the rows that agree under every named set of assumptions instead
    #[arg(long, conflicts_with_all = ["only", "quick", "markdown", "out"])]
    readings: bool,
    /// Print JSON
    #[arg(long, conflicts_with = "markdown")]
    json: bool,
    /// Print markdown
    #[arg(long)]
    markdown: bool,
    /// Also write the page with figures 3.4 to 3.10 and 7.3 to 7.5: FILE.html, or a folder, which
    /// then gets the table and each picture as files of their own too
    #[arg(long, value_name = "PATH")]
    out: Option<PathBuf>,
}

/// Runs `twinhub reproduce`.
pub fn run(args: &ReproduceArgs) -> Result<ExitCode> {
    if let Some(unknown) = args.only.iter().find(|id| !IDS.contains(&id.as_str())) {
        return Err(bad_input(anyhow!(
            "--only {unknown}: accepted: {}",
            IDS.join(", ")
        )));
    }
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let bar = indicatif::ProgressBar::new(1);
    let progress = |done: usize, of: usize| {
        bar.set_length(of as u64);
        bar.set_position(done as u64);
    };
    if args.readings {
        let counts = readings(threads, &progress)?;
        bar.finish_and_clear();
        print_readings(&counts, args.json);
        return Ok(ExitCode::SUCCESS);
    }
    let assumed = Assumed {
        explain_misses: !args.quick,
        ..Assumed::default()
    };
    let found = reproduce(&assumed, &args.only, threads, &progress)?;
    bar.finish_and_clear();
    if let Some(path) = &args.out {
        let bar = indicatif::ProgressBar::new(1);
        let plots = figures::all(&assumed, &|done, of| {
            bar.set_length(of as u64);
            bar.set_position(done as u64);
        })?;
        bar.finish_and_clear();
        write(path, &found, plots)?;
    }
    if args.json {
        let text = json!({
            "schema_version": 1,
            "assumptions": found.assumed.to_string(),
            "agreeing": found.agreeing(),
            "rows": found.rows,
            "method": found.method,
        });
        println!("{}", serde_json::to_string_pretty(&text)?);
    } else if args.markdown {
        print!("{}", found.markdown());
    } else {
        print!("{}", found.text());
    }
    Ok(ExitCode::SUCCESS)
}

fn print_readings(counts: &[(Assumed, usize)], as_json: bool) {
    if as_json {
        let entries: Vec<_> = counts
            .iter()
            .map(|(assumed, agreeing)| json!({"assumptions": assumed.to_string(), "agreeing": agreeing}))
            .collect();
        println!(
            "{}",
            json!({"schema_version": 1, "rows": IDS.len(), "readings": entries})
        );
        return;
    }
    for (assumed, agreeing) in counts {
        let used = if *assumed == Assumed::default() {
            "  (used)"
        } else {
            ""
        };
        println!("{agreeing:3} of {}  {assumed}{used}", IDS.len());
    }
}

/// The page at FILE.html, or page, table and pictures in a folder.
fn write(path: &Path, found: &Reproduction, plots: Vec<Plot>) -> Result<()> {
    let put = |path: &Path, text: &str| {
        std::fs::write(path, text)
            .with_context(|| format!("writing {}", path.display()))
            .map_err(environment)
    };
    let page = ReproducePage {
        assumed: found.assumed.to_string(),
        agree: [found.agreeing(), found.rows.len()],
        rows: found
            .rows
            .iter()
            .map(|row| {
                let [id, thesis, ours, unit, ratio, verdict] = markdown::cells(row);
                [id, thesis, ours, unit, ratio, verdict, row.note.clone()]
            })
            .collect(),
        method: found
            .method
            .iter()
            .map(twinhub_reproduce::Method::cells)
            .collect(),
        plots,
    };
    if path.extension().is_some_and(|e| e == "html") {
        put(path, &page.html())?;
        eprintln!("page: {}", path.display());
        return Ok(());
    }
    std::fs::create_dir_all(path)
        .with_context(|| format!("creating {}", path.display()))
        .map_err(environment)?;
    put(&path.join("reproduction.html"), &page.html())?;
    put(&path.join("reproduction.md"), &found.markdown())?;
    for plot in &page.plots {
        put(&path.join(format!("{}.svg", plot.name)), &plot.picture())?;
    }
    eprintln!("page: {}", path.join("reproduction.html").display());
    Ok(())
}
