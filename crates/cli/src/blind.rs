//! `twinhub blind`: sealed rides with a known answer through the diagnosis.

use crate::exit::{self, bad_input, environment};
use anyhow::{Context, anyhow};
use clap::Args;
use indicatif::{ProgressBar, ProgressStyle};
use serde_json::json;
use std::path::PathBuf;
use std::process::ExitCode;
use twinhub_blind::metrics::detection_curve;
use twinhub_blind::plan::planned;
use twinhub_blind::wrong::wrong;
use twinhub_blind::{Metric, Outcome, Product, gates, metrics, plan, suite, timing};
use twinhub_hidden::{Kind, Scenario};

/// Hide effects in rides of another simulator, have them diagnosed, and say how often the diagnosis
/// was right. Every core works; a suite that is broken off goes on where it was with --keep.
#[derive(Args, Debug)]
pub struct BlindArgs {
    /// Size of the suite; clean sets and controls come on top
    #[arg(long, value_name = "N", default_value_t = 300)]
    sets: usize,
    /// Seed of the suite
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Kinds of sets: clean, one_effect, two_effects, outside, mismatched, shifted, mixed, confounded
    /// [default: all]
    #[arg(long, value_name = "KIND", value_delimiter = ',')]
    kinds: Vec<String>,
    /// One set of each kind alone, by its own seed
    #[arg(long, value_name = "SEED")]
    set_seed: Option<u64>,
    /// Keep every outcome in this file, and do not run again what is in it
    #[arg(long, value_name = "FILE")]
    keep: Option<PathBuf>,
    /// Do not time a diagnosis of seven rides of 60 s
    #[arg(long)]
    no_timing: bool,
    /// Write the set that --kinds and --set-seed name, study, rides and answer, and run nothing
    #[arg(long, value_name = "DIR", requires = "set_seed")]
    write: Option<PathBuf>,
    /// With --write: sizes of the set's effects, from "absent"
    #[arg(long, value_name = "SIZE", value_delimiter = ',', requires = "write")]
    size: Vec<f64>,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// Runs the command: exit code 1 if a metric fails.
///
/// # Errors
/// If an argument is wrong (2) or a file cannot be used (3).
pub fn run(args: &BlindArgs) -> anyhow::Result<ExitCode> {
    let kinds = kinds(&args.kinds).map_err(bad_input)?;
    if let (Some(dir), Some(seed)) = (&args.write, args.set_seed) {
        return write(args, dir, &kinds, seed);
    }
    if args.sets == 0 {
        return Err(bad_input(anyhow!("--sets 0: accepted is 1 and more")));
    }
    let sets = match args.set_seed {
        Some(seed) => kinds.iter().map(|kind| planned(*kind, seed)).collect(),
        None => plan(args.sets, args.seed, &kinds),
    };
    let bar = ProgressBar::new(sets.len() as u64);
    bar.set_style(
        ProgressStyle::with_template("{bar:40} {pos}/{len} sets  {elapsed}, {eta} to go")
            .unwrap_or_else(|_| ProgressStyle::default_bar()),
    );
    let outcomes = suite(&Product, &sets, args.keep.as_deref(), &|done, _| {
        bar.set_position(done as u64);
    })
    .map_err(environment)?;
    bar.finish_and_clear();
    let mut done = vec![];
    let mut failed = vec![];
    for outcome in outcomes {
        match outcome {
            Ok(outcome) => done.push(outcome),
            Err(error) => failed.push(error.to_string()),
        }
    }
    let seconds = match args.no_timing || args.set_seed.is_some() {
        true => None,
        false => Some(timing(&Product, args.seed).map_err(environment)?),
    };
    let table = metrics(&done, seconds);
    report(args, &done, &failed, &table)?;
    let bad = !failed.is_empty() || table.iter().any(|m| m.verdict == "fail");
    Ok(if bad {
        ExitCode::from(exit::FELL)
    } else {
        ExitCode::SUCCESS
    })
}

fn kinds(names: &[String]) -> anyhow::Result<Vec<Kind>> {
    if names.is_empty() {
        return Ok(Kind::ALL.to_vec());
    }
    let named = |name: &String| {
        Kind::named(name).with_context(|| {
            format!(
                "--kinds {name}: no such kind; accepted: {}",
                Kind::ALL.map(Kind::name).join(", ")
            )
        })
    };
    names.iter().map(named).collect()
}

/// Writes sets for inspection.
fn write(
    args: &BlindArgs,
    dir: &std::path::Path,
    kinds: &[Kind],
    seed: u64,
) -> anyhow::Result<ExitCode> {
    for kind in kinds {
        let mut scenario = Scenario::new(*kind, seed);
        if !args.size.is_empty() {
            if args.size.len() != scenario.hidden.len() {
                return Err(bad_input(anyhow!(
                    "--size: {} sizes; this set hides {} effects",
                    args.size.len(),
                    scenario.hidden.len()
                )));
            }
            scenario = scenario.sized(&args.size);
        }
        let sealed = scenario.seal().map_err(environment)?;
        let name = format!("{}_{seed}", kind.name());
        let study = sealed.write(&dir.join(&name)).map_err(environment)?;
        let answer = dir.join(format!("{name}_answer.json"));
        sealed.write_answer(&answer).map_err(environment)?;
        println!("study   {}\nanswer  {}", study.display(), answer.display());
    }
    Ok(ExitCode::SUCCESS)
}

fn report(
    args: &BlindArgs,
    done: &[Outcome],
    failed: &[String],
    table: &[Metric],
) -> anyhow::Result<()> {
    let wrong = wrong(done);
    let curve = detection_curve(done);
    if args.json {
        let wrong: Vec<_> = wrong
            .iter()
            .map(
                |w| json!({"set": w.set, "hidden": w.hidden, "said": w.said, "command": w.command}),
            )
            .collect();
        let curve: Vec<_> = curve
            .iter()
            .map(|(multiple, found, of)| json!({"multiple": multiple, "found": found, "of": of}))
            .collect();
        println!(
            "{}",
            serde_json::to_string_pretty(&json!({
                "schema_version": 1,
                "gates": gates::hash(),
                "thresholds": twinhub_diagnose::search::thresholds::hash(),
                "seed": args.seed,
                "sets": done.len(),
                "metrics": table,
                "detection_curve": curve,
                "wrong": wrong,
                "failed": failed,
            }))?
        );
        return Ok(());
    }
    println!(
        "{} sets, seed {}, gates {}, thresholds {}\n",
        done.len(),
        args.seed,
        gates::hash(),
        twinhub_diagnose::search::thresholds::hash()
    );
    println!(
        "{:11} {:48} {:>7} {:>15} {:>5}  {:24} {:14} verdict",
        "metric", "", "value", "95 %", "sets", "pass", "moonshot"
    );
    for m in table {
        let value = m.value.map_or("-".to_owned(), |v| format!("{v:.3}"));
        let ci = m
            .ci95
            .map_or(String::new(), |[a, b]| format!("{a:.3} to {b:.3}"));
        println!(
            "{:11} {:48} {value:>7} {ci:>15} {:>5}  {:24} {:14} {}",
            m.id, m.what, m.sets, m.pass, m.moonshot, m.verdict
        );
    }
    if !curve.is_empty() {
        println!("\nfound, by size over the printed limit");
        for (multiple, found, of) in curve {
            println!("{multiple:>5.1}  {found}/{of}");
        }
    }
    if !wrong.is_empty() {
        println!("\nanswered wrongly");
        for w in &wrong {
            println!(
                "{}\n  hidden  {}\n  said    {}\n  {}",
                w.set, w.hidden, w.said, w.command
            );
        }
    }
    for text in failed {
        println!("failed: {text}");
    }
    Ok(())
}
