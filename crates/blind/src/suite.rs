//! The whole suite: every set on all cores, resumable, its outcomes in the order of the plan.

use crate::engine::Engine;
use crate::gates;
use crate::plan::Planned;
use crate::run::{Outcome, RunError, run, run_scenario};
use rayon::prelude::*;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use twinhub_hidden::{Kind, Scenario};

/// Why a suite stops.
#[non_exhaustive]
#[derive(Debug, thiserror::Error)]
pub enum SuiteError {
    #[error("cannot use {}: {source}", path.display())]
    File {
        path: PathBuf,
        source: std::io::Error,
    },
    #[error("{}, line {line}: {message}; accepted: outcomes that this suite has written, or a new file", path.display())]
    Line {
        path: PathBuf,
        line: usize,
        message: String,
    },
    #[error("{}: written with thresholds {found}; accepted: {}", path.display(), gates::hash())]
    Thresholds { path: PathBuf, found: String },
}

/// Runs what is planned. With a file, outcomes are kept there one a line, and those that it holds
/// are not run again. `progress` hears how many of how many are done.
///
/// # Errors
/// If the file cannot be used. A set that fails is an outcome of its own.
pub fn suite(
    engine: &impl Engine,
    sets: &[Planned],
    file: Option<&Path>,
    progress: &(impl Fn(usize, usize) + Sync),
) -> Result<Vec<Result<Outcome, RunError>>, SuiteError> {
    let known = file.map(read).transpose()?.unwrap_or_default();
    let keep = file.map(open).transpose()?.map(Mutex::new);
    let done = AtomicUsize::new(0);
    let one = |planned: &Planned| {
        let outcome = match known.iter().find(|o| o.planned == *planned) {
            Some(outcome) => Ok(outcome.clone()),
            None => run(engine, planned).inspect(|outcome| {
                if let (Some(keep), Ok(line)) = (&keep, serde_json::to_string(outcome))
                    && let Ok(mut file) = keep.lock()
                {
                    // A lost line costs one set at the next start.
                    let _ = writeln!(file, "{line}");
                }
            }),
        };
        progress(done.fetch_add(1, Ordering::Relaxed) + 1, sets.len());
        outcome
    };
    Ok(sets.par_iter().with_max_len(1).map(one).collect())
}

/// Seconds that one diagnosis of seven rides of 60 s takes, reading included, on one thread and with
/// nothing else running here.
///
/// # Errors
/// If the rides cannot be made or are refused.
pub fn timing(engine: &impl Engine, seed: u64) -> Result<f64, RunError> {
    let mut scenario = Scenario::new(Kind::Clean, seed);
    scenario.layout.duration_s = 60.0;
    let planned = Planned {
        kind: Kind::Clean.name().to_owned(),
        seed,
        multiples: vec![],
        oracle: false,
    };
    run_scenario(engine, &planned, &scenario).map(|outcome| outcome.seconds)
}

fn read(path: &Path) -> Result<Vec<Outcome>, SuiteError> {
    if !path.exists() {
        return Ok(vec![]);
    }
    let text = std::fs::read_to_string(path).map_err(|source| SuiteError::File {
        path: path.to_owned(),
        source,
    })?;
    let mut lines = text.lines().enumerate();
    match lines.next() {
        None => return Ok(vec![]),
        Some((_, first)) if first == gates::hash() => {}
        Some((_, first)) => {
            return Err(SuiteError::Thresholds {
                path: path.to_owned(),
                found: first.chars().take(16).collect(),
            });
        }
    }
    lines
        .map(|(k, line)| {
            serde_json::from_str(line).map_err(|error| SuiteError::Line {
                path: path.to_owned(),
                line: k + 1,
                message: error.to_string(),
            })
        })
        .collect()
}

fn open(path: &Path) -> Result<std::fs::File, SuiteError> {
    let wrap = |source| SuiteError::File {
        path: path.to_owned(),
        source,
    };
    let mut file = std::fs::File::options()
        .create(true)
        .append(true)
        .open(path)
        .map_err(wrap)?;
    if file.metadata().map_err(wrap)?.len() == 0 {
        writeln!(file, "{}", gates::hash()).map_err(wrap)?;
    }
    Ok(file)
}
