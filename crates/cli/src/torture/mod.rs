//! `twinhub torture`: kills, stops and continues either side of rides, and looks at what is left.
//!
//! What fails the command does not depend on the clock: a process that does not end, shared memory
//! or files that stay, a loss that nobody notices, torque later than 200 ticks after the last
//! command, a log that does not open, a next ride with another digest. How soon losses were
//! noticed is reported; `--strict` makes more than 20 ms in real time a failure too, for machines
//! that keep time.

mod blow;
mod half;
mod round;

use crate::exit;
use crate::interrupt::on_ctrl_c;
use crate::ride::program;
use anyhow::Context;
use clap::Args;
use indicatif::{ProgressBar, ProgressStyle};
use round::{Found, Round};
use serde_json::json;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use twinhub_link::timing::{Quantiles, histogram_ns};
use twinhub_link::{InProcess, RunDir, leftovers};
use twinhub_sim::Ride;

/// In real time a loss is to be noticed within this, ns.
const NOTICE_WANTED_NS: u64 = 20_000_000;
/// Rides between two checks that an undisturbed ride still gives its digest.
const CLEAN_EVERY: u64 = 50;

/// Arguments of `twinhub torture`.
#[derive(Args)]
pub struct TortureArgs {
    /// Rides, each of which ends by the kill of one side or of both; stops and continues come on
    /// top.
    #[arg(long, default_value_t = 200)]
    kills: u64,
    /// Seed of who is hit, when, and how.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Rides at once.
    #[arg(long, default_value_t = 1)]
    jobs: usize,
    /// Fail if a loss was noticed later than 20 ms in real time.
    #[arg(long)]
    strict: bool,
    /// Print the result as JSON.
    #[arg(long)]
    json: bool,
}

/// What all rides came to.
#[derive(Default)]
struct Tally {
    found: Found,
    rides: u64,
    clean_rides: u64,
}

/// Runs the command: exit code 0 if everything held, 1 if not.
///
/// # Errors
/// An environment that cannot start rides.
pub fn run(args: &TortureArgs) -> anyhow::Result<ExitCode> {
    let place = Place::new().map_err(exit::environment)?;
    let assignments = [
        "duration_s=36000",
        "law.limits.ramp_up_nm_s=50",
        "law.law.scheduled.change_nm_s=100",
    ]
    .map(str::to_owned);
    let ride = Ride::load("first_ride", &assignments).map_err(exit::bad_input)?;
    let stop = on_ctrl_c()?;
    let clean = Clean::new(&place)?;
    let bar = ProgressBar::new(args.kills);
    bar.set_style(
        ProgressStyle::with_template("{bar:40} {pos}/{len} kills  {elapsed}  {msg}")
            .unwrap_or_else(|_| ProgressStyle::default_bar()),
    );
    let next = AtomicU64::new(0);
    let tally = Mutex::new(Tally::default());
    let work = || -> anyhow::Result<()> {
        while !stop.load(Ordering::Relaxed) {
            let number = next.fetch_add(1, Ordering::Relaxed);
            if number >= args.kills {
                break;
            }
            let found = Round::new(args.seed, number, &place).ride(&ride)?;
            let digest_differs = if number % CLEAN_EVERY == CLEAN_EVERY - 1 {
                Some(clean.differs(&place)?)
            } else {
                None
            };
            let mut tally = tally.lock().expect("no panic while it was held");
            tally.rides += 1;
            tally.found.add(found);
            if let Some(differs) = digest_differs {
                tally.clean_rides += 1;
                tally.found.failures.extend(differs);
            }
            bar.inc(1);
            if !tally.found.failures.is_empty() {
                bar.set_message(format!("{} failures", tally.found.failures.len()));
            }
        }
        Ok(())
    };
    std::thread::scope(|scope| {
        let workers: Vec<_> = (0..args.jobs.max(1)).map(|_| scope.spawn(work)).collect();
        workers
            .into_iter()
            .try_for_each(|worker| worker.join().expect("workers do not panic"))
    })?;
    bar.finish_and_clear();
    let mut tally = tally.into_inner().expect("no panic while it was held");
    tally.clean_rides += 1;
    tally.found.failures.extend(clean.differs(&place)?);
    tally.found.failures.extend(place.remains());
    report(args, &tally, stop.load(Ordering::Relaxed))
}

fn report(args: &TortureArgs, tally: &Tally, stopped: bool) -> anyhow::Result<ExitCode> {
    let found = &tally.found;
    let quantiles = |times: &[u64]| {
        let mut histogram = histogram_ns();
        for ns in times {
            histogram.saturating_record(*ns);
        }
        Quantiles::of(&histogram)
    };
    let notice = quantiles(&found.noticed_ns);
    let late = found
        .noticed_ns
        .iter()
        .filter(|ns| **ns > NOTICE_WANTED_NS)
        .count();
    let held = found.failures.is_empty() && (late == 0 || !args.strict);
    if args.json {
        let text = json!({
            "schema_version": 1,
            "passed": held && !stopped,
            "kills": tally.rides,
            "seed": args.seed,
            "signals": {
                "kill": found.kills, "stop": found.stops, "continue": found.continues,
            },
            "killed": {
                "controller": found.controllers, "plant": found.plants, "both": found.both,
            },
            "rides": { "realtime": found.real_time, "lockstep": tally.rides - found.real_time },
            "deadlocks": found.deadlocks,
            "leaks": found.leaks,
            "logs_opened": found.logs,
            "clean_rides": tally.clean_rides,
            "loss_noticed_us": notice,
            "loss_noticed_late": late,
            "lockstep_end_us": quantiles(&found.lockstep_ns),
            "controller_quiet_ticks_max": found.controller_quiet_ticks,
            "drives_quiet_ticks_max": found.drives_quiet_ticks,
            "rides_with_torque": found.with_torque,
            "failures": found.failures,
        });
        println!("{}", serde_json::to_string_pretty(&text)?);
    } else {
        println!(
            "{} rides ({} in real time): {} kills ({} controllers, {} plants, {} both), {} stops, {} continues",
            tally.rides,
            found.real_time,
            found.kills,
            found.controllers,
            found.plants,
            found.both,
            found.stops,
            found.continues
        );
        println!(
            "deadlocks {}, leaks {}, logs opened {}, undisturbed rides between {}",
            found.deadlocks, found.leaks, found.logs, tally.clean_rides
        );
        println!(
            "loss noticed in real time, ms: p50 {:.2}, p99 {:.2}, max {:.2}; later than 20 ms: {late} of {}",
            notice.p50 * 1e-3,
            notice.p99 * 1e-3,
            notice.max * 1e-3,
            notice.count
        );
        println!(
            "torque zero after at most {} ticks in the controller, {} in the drives ({} rides with torque)",
            found.controller_quiet_ticks, found.drives_quiet_ticks, found.with_torque
        );
        for failure in &found.failures {
            println!("FAILED {failure}");
        }
    }
    Ok(match (stopped, held) {
        (true, _) => ExitCode::from(exit::INTERRUPTED),
        (false, true) => ExitCode::SUCCESS,
        (false, false) => ExitCode::from(exit::FELL),
    })
}

/// Directories of the torture: rides meet here, logs are written here, and all of it vanishes.
struct Place {
    dir: PathBuf,
}

impl Place {
    fn new() -> anyhow::Result<Self> {
        let dir = std::env::temp_dir().join(format!("twinhub-torture-{}", std::process::id()));
        std::fs::create_dir(&dir)
            .with_context(|| format!("{}: cannot be created", dir.display()))?;
        std::fs::set_permissions(&dir, std::fs::Permissions::from_mode(0o700))?;
        Ok(Self { dir })
    }

    fn run_dir(&self) -> RunDir {
        RunDir::at(self.dir.join("run"))
    }

    fn log(&self, name: &str) -> PathBuf {
        self.dir.join(format!("{name}.mcap"))
    }

    /// What is left in the run directory after the last ride.
    fn remains(&self) -> Option<String> {
        let left: Vec<_> = leftovers(&self.run_dir())
            .into_iter()
            .filter(|path| path.starts_with(&self.dir))
            .collect();
        (!left.is_empty()).then(|| format!("left after the last ride: {left:?}"))
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.dir);
    }
}

/// An undisturbed ride and the digest that it has to give.
struct Clean {
    ride: Ride,
    digest: String,
}

impl Clean {
    fn new(place: &Place) -> anyhow::Result<Self> {
        let ride = Ride::load("first_ride", &["duration_s=1".to_owned()])?;
        let log = place.log("clean");
        let (version, git_hash) = program();
        let settings = twinhub_sim::Settings {
            log: Some(log.clone()),
            version,
            git_hash,
        };
        let mut port = InProcess::new(twinhub_sim::in_process(&ride.law));
        let outcome = twinhub_sim::ride(&ride, &settings, &mut port, &mut |_| true)?;
        let _ = std::fs::remove_file(log);
        Ok(Self {
            ride,
            digest: outcome.digest,
        })
    }

    /// Rides it in two processes; says so if the digest is another one.
    fn differs(&self, place: &Place) -> anyhow::Result<Option<String>> {
        let digest = round::undisturbed(&self.ride, place)?;
        Ok((digest.as_deref() != Some(self.digest.as_str())).then(|| {
            format!(
                "an undisturbed ride gave {digest:?}, in process {}",
                self.digest
            )
        }))
    }
}

/// Length of a file, 0 if there is none.
fn length(path: &Path) -> u64 {
    std::fs::metadata(path).map_or(0, |meta| meta.len())
}
