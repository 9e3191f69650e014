//! `twinhub league` and `twinhub merge`: controllers against each other.

use crate::exit::{self, bad_input, environment, interrupted};
use crate::interrupt::on_ctrl_c;
use crate::league_print::{print, to_json, to_page};
use anyhow::{Context, anyhow};
use clap::Args;
use indicatif::{ProgressBar, ProgressStyle};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Mutex;
use std::sync::atomic::Ordering;
use twinhub_control::Profile;
use twinhub_league::spec::CONTROLLERS;
use twinhub_league::{Class, Kept, League, LeagueError, Part, Spec, merge};

/// Controllers against each other: riders who give torque, who hold the bar firmly, and the
/// published ones, on mixed courses; every controller rides the same riders and courses. Says what
/// each one is worth and costs, and whether anybody is harmed.
#[derive(Args, Debug)]
pub struct LeagueArgs {
    /// Riders of each class
    #[arg(long, value_name = "N", default_value_t = 40)]
    riders: u64,
    /// Seed of riders, courses and noise
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Laws that ship, or law files; `off` always rides [default: all that are compared in the README]
    #[arg(long, value_name = "LAW,LAW,..", value_delimiter = ',')]
    controllers: Vec<String>,
    /// Classes of riders: young, older, young_roll, older_roll, young_firm, older_firm, published
    /// [default: all]
    #[arg(long, value_name = "CLASS,CLASS,..", value_delimiter = ',')]
    classes: Vec<String>,
    /// Limits by name in place of those in the law files: laboratory or en15194
    #[arg(long, value_name = "PROFILE")]
    profile: Option<String>,
    /// Length of each ride, s
    #[arg(long, value_name = "S", default_value_t = 60.0)]
    duration_s: f64,
    /// Only every Nth part, beginning with the Ith: a share of the work for one of several machines
    #[arg(long, value_name = "I/N", requires = "out")]
    shard: Option<String>,
    /// Keep every part in this file, and do not run again what is in it
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Where to write the page
    #[arg(long, value_name = "FILE.html")]
    report: Option<PathBuf>,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// Puts the files of a league's shards together: exactly what one run in one piece gives.
#[derive(Args, Debug)]
pub struct MergeArgs {
    /// Files that `twinhub league --out` has written
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
    /// Keep all parts in one file
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Where to write the page
    #[arg(long, value_name = "FILE.html")]
    report: Option<PathBuf>,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// Runs `twinhub league`: exit code 1 if a controller of ours makes a class of riders fall more.
///
/// # Errors
/// If an argument is wrong (2), a file cannot be used (3), or the user stops it (130).
pub fn run(args: &LeagueArgs) -> anyhow::Result<ExitCode> {
    let spec = spec(args)?;
    let league = League::new(spec.clone()).map_err(bad_input)?;
    let numbers = match &args.shard {
        None => (0..spec.parts()).collect(),
        Some(text) => {
            let (index, count) = shard(text)?;
            spec.shard(index, count).map_err(bad_input)?
        }
    };
    let kept = match &args.out {
        Some(path) => Some(Kept::open(path, &spec).map_err(kind)?),
        None => None,
    };
    let mut parts: Vec<Part> = kept.as_ref().map_or(Vec::new(), |kept| kept.parts.clone());
    let known = |number: &u64| parts.iter().any(|part| part.part == *number);
    let left: Vec<u64> = numbers.iter().copied().filter(|n| !known(n)).collect();
    if left.len() < numbers.len() {
        eprintln!(
            "{} of {} parts are in the file already",
            numbers.len() - left.len(),
            numbers.len()
        );
    }
    let stop = on_ctrl_c()?;
    let bar = ProgressBar::new(left.len() as u64);
    bar.set_style(
        ProgressStyle::with_template("{bar:40} {pos}/{len} riders  {elapsed}, {eta} to go")
            .unwrap_or_else(|_| ProgressStyle::default_bar()),
    );
    let kept = kept.map(Mutex::new);
    let lost: Mutex<Option<LeagueError>> = Mutex::new(None);
    let done = |part: &Part, count: u64| {
        if let Some(kept) = &kept
            && let Ok(mut kept) = kept.lock()
            && let Err(error) = kept.add(part)
        {
            if let Ok(mut lost) = lost.lock() {
                lost.get_or_insert(error);
            }
            stop.store(true, Ordering::Relaxed);
        }
        bar.set_position(count);
    };
    let fresh = league.run(&left, &stop, &done).map_err(environment)?;
    bar.finish_and_clear();
    if let Ok(Some(error)) = lost.into_inner() {
        return Err(environment(error));
    }
    if stop.load(Ordering::Relaxed) {
        let hint = match &args.out {
            Some(path) => format!("; the same command goes on where {} ends", path.display()),
            None => "; with --out FILE a league goes on where it was".to_owned(),
        };
        return Err(interrupted(anyhow!(
            "stopped after {} of {} riders{hint}",
            fresh.len(),
            left.len()
        )));
    }
    parts.extend(fresh);
    parts.sort_by_key(|part| part.part);
    show(&spec, &parts, args.report.as_deref(), args.json)
}

/// Runs `twinhub merge`.
///
/// # Errors
/// If a file cannot be used (3) or is wrong (2).
pub fn run_merge(args: &MergeArgs) -> anyhow::Result<ExitCode> {
    let (spec, parts, missing) = merge(&args.files).map_err(kind)?;
    if missing > 0 {
        eprintln!(
            "{missing} of {} parts are missing: not every shard is here, or not whole",
            spec.parts()
        );
    }
    if let Some(path) = &args.out {
        if path.exists() {
            return Err(bad_input(anyhow!(
                "{}: exists already; accepted: a new file",
                path.display()
            )));
        }
        let mut kept = Kept::open(path, &spec).map_err(kind)?;
        for part in &parts {
            kept.add(part).map_err(environment)?;
        }
    }
    show(&spec, &parts, args.report.as_deref(), args.json)
}

fn show(
    spec: &Spec,
    parts: &[Part],
    report: Option<&Path>,
    json: bool,
) -> anyhow::Result<ExitCode> {
    if let Some(path) = report {
        std::fs::write(path, to_page(spec, parts))
            .with_context(|| format!("{}: cannot be written", path.display()))
            .map_err(environment)?;
    }
    if json {
        println!("{}", serde_json::to_string_pretty(&to_json(spec, parts))?);
    } else {
        print(spec, parts);
        if let Some(path) = report {
            println!("\npage  {}", path.display());
        }
    }
    let harmed = twinhub_league::harm(spec, parts)
        .iter()
        .any(|cell| cell.verdict == "worse" && crate::league_print::is_ours(&cell.controller));
    Ok(if harmed {
        ExitCode::from(exit::FELL)
    } else {
        ExitCode::SUCCESS
    })
}

/// The exit code of a league's error: the user's file or the machine's.
fn kind(error: LeagueError) -> anyhow::Error {
    match error {
        LeagueError::File { .. } => environment(error),
        _ => bad_input(error),
    }
}

fn spec(args: &LeagueArgs) -> anyhow::Result<Spec> {
    let classes: Vec<Class> = if args.classes.is_empty() {
        Class::ALL.to_vec()
    } else {
        let named = |name: &String| {
            Class::named(name).ok_or_else(|| {
                bad_input(anyhow!(
                    "--classes {name}: no such class; accepted: {}",
                    Class::ALL.map(Class::name).join(", ")
                ))
            })
        };
        args.classes.iter().map(named).collect::<Result<_, _>>()?
    };
    let controllers: Vec<String> = if args.controllers.is_empty() {
        CONTROLLERS.map(str::to_owned).to_vec()
    } else {
        args.controllers.clone()
    };
    let profile = match args.profile.as_deref() {
        None => None,
        Some("laboratory") => Some(Profile::Laboratory),
        Some("en15194") => Some(Profile::En15194),
        Some(other) => {
            return Err(bad_input(anyhow!(
                "--profile {other}: accepted: {}",
                Profile::NAMES.join(", ")
            )));
        }
    };
    Spec::new(
        args.seed,
        args.riders,
        &classes,
        args.duration_s,
        &controllers,
        profile,
    )
    .map_err(bad_input)
}

/// `I/N`.
fn shard(text: &str) -> anyhow::Result<(u64, u64)> {
    text.split_once('/')
        .and_then(|(i, n)| Some((i.parse().ok()?, n.parse().ok()?)))
        .ok_or_else(|| {
            bad_input(anyhow!(
                "--shard {text}: accepted: I/N with I from 1 to N, as 2/8"
            ))
        })
}
