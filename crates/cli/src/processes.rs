//! A ride in two processes: this program starts itself twice, as plant and as controller.
//!
//! A child reads its job from standard input (one line of JSON), which then stays open: when it
//! closes, the plant brings the ride to an orderly end and the controller with it; so both also
//! end when this process dies. A child tells its progress and its result on standard output, a
//! line of JSON each. Children have a process group of their own: Ctrl-C reaches this process
//! only.

use crate::exit;
use crate::ride::{coded, program};
use anyhow::{Context, anyhow};
use indicatif::ProgressBar;
use serde::{Deserialize, Serialize};
use std::io::{BufRead, BufReader, Read, Write};
use std::os::unix::process::{CommandExt, ExitStatusExt};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, Command, ExitCode, ExitStatus, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::{Duration, Instant};
use twinhub_link::ipc::PlantOffer;
use twinhub_link::{LinkError, RideName};
use twinhub_sim::{Ending, Metrics, Outcome, Progress, Ride, Settings};

/// The hidden command of the plant's process.
pub const PLANT: &str = "plant-process";
/// The hidden command of the controller's process.
pub const CONTROLLER: &str = "controller-process";

/// How long a child may take to end after its peer has.
const LAST_WORDS: Duration = Duration::from_secs(10);
/// Progress lines per ride.
const PROGRESS_LINES: u64 = 200;

/// What a child is told. The ride is TOML: it keeps every bit of a number.
#[derive(Serialize, Deserialize)]
struct Job {
    link: String,
    ride_toml: String,
    log: PathBuf,
}

/// What the plant's process tells.
#[derive(Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
enum Report {
    Tick(u64),
    Done {
        stopped: bool,
        metrics: Metrics,
        digest: String,
    },
}

/// Rides `ride` in two processes.
///
/// # Errors
/// If a process cannot be started or did not come to its end; what it said is on standard error.
pub fn ride(
    ride: &Ride,
    log: &Path,
    stop: &AtomicBool,
    bar: &ProgressBar,
) -> anyhow::Result<Outcome> {
    let job = serde_json::to_string(&Job {
        link: format!(
            "ride{}-{}",
            std::process::id(),
            if ride.stabilizer_on { "on" } else { "off" }
        ),
        ride_toml: ride.to_toml(),
        log: log.to_owned(),
    })?;
    let (mut plant, plant_in) = spawn(PLANT, &job)?;
    let (mut controller, controller_in) = match spawn(CONTROLLER, &job) {
        Ok(started) => started,
        Err(e) => {
            drop(plant_in);
            wait(&mut plant);
            return Err(e);
        }
    };
    let done = follow(reports(&mut plant), stop, plant_in, bar);
    let plant_end = wait(&mut plant);
    let controller_end = wait(&mut controller);
    drop(controller_in);
    if let Some((stopped, metrics, digest)) = done {
        let ending = match (stopped, metrics.fell) {
            (true, _) => Ending::Stopped,
            (false, true) => Ending::Fell,
            (false, false) => Ending::Finished,
        };
        return Ok(Outcome {
            ending,
            metrics,
            digest,
            log: Some(log.to_owned()),
        });
    }
    let what = anyhow!(
        "the ride broke off at {:.1} s: the plant's process {}, the controller's process {}; the log so far is {}",
        bar.position() as f64 * 1e-3,
        fate(plant_end),
        fate(controller_end),
        log.display()
    );
    Err(if stop.load(Ordering::Relaxed) {
        exit::interrupted(what)
    } else {
        exit::environment(what)
    })
}

fn spawn(role: &str, job: &str) -> anyhow::Result<(Child, ChildStdin)> {
    let program = std::env::current_exe().context("this program does not know where it is")?;
    let mut child = Command::new(program)
        .arg(role)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .process_group(0)
        .spawn()
        .with_context(|| format!("the {role} cannot be started"))
        .map_err(exit::environment)?;
    let mut input = child.stdin.take().context("a child has a standard input")?;
    writeln!(input, "{job}").with_context(|| format!("the {role} does not take its job"))?;
    Ok((child, input))
}

/// The plant's reports, read by a thread of their own.
fn reports(plant: &mut Child) -> Receiver<Report> {
    let (send, receive) = channel();
    if let Some(output) = plant.stdout.take() {
        std::thread::spawn(move || {
            for line in BufReader::new(output).lines().map_while(Result::ok) {
                let Ok(report) = serde_json::from_str(&line) else {
                    break;
                };
                if send.send(report).is_err() {
                    break;
                }
            }
        });
    }
    receive
}

/// Follows the ride to its end; `None` if there is no result.
fn follow(
    reports: Receiver<Report>,
    stop: &AtomicBool,
    plant_in: ChildStdin,
    bar: &ProgressBar,
) -> Option<(bool, Metrics, String)> {
    let mut plant_in = Some(plant_in);
    loop {
        if stop.load(Ordering::Relaxed) {
            plant_in = None;
        }
        match reports.recv_timeout(Duration::from_millis(20)) {
            Ok(Report::Tick(tick)) => bar.set_position(tick),
            Ok(Report::Done {
                stopped,
                metrics,
                digest,
            }) => return Some((stopped, metrics, digest)),
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => {
                drop(plant_in);
                return None;
            }
        }
    }
}

/// Waits for a child to end; one that does not end in time is killed.
fn wait(child: &mut Child) -> Option<ExitStatus> {
    let deadline = Instant::now() + LAST_WORDS;
    loop {
        match child.try_wait() {
            Ok(Some(status)) => return Some(status),
            Ok(None) if Instant::now() < deadline => std::thread::sleep(Duration::from_millis(2)),
            _ => {
                let _ = child.kill();
                return child.wait().ok();
            }
        }
    }
}

fn fate(status: Option<ExitStatus>) -> String {
    match status.map(|s| (s.code(), s.signal())) {
        Some((Some(0), _)) => "ended in order".into(),
        Some((Some(code), _)) => format!("ended with exit code {code}"),
        Some((None, Some(signal))) => format!("was killed by signal {signal}"),
        _ => "is lost".into(),
    }
}

/// Reads the job; from then on, the end of standard input raises the stop flag.
fn take_job() -> anyhow::Result<(Job, Ride, Arc<AtomicBool>)> {
    let mut line = String::new();
    std::io::stdin().read_line(&mut line)?;
    let job: Job = serde_json::from_str(&line)
        .context("this command is for `twinhub ride`, which tells it what to do on standard input")
        .map_err(exit::bad_input)?;
    let ride: Ride = toml::from_str(&job.ride_toml).map_err(exit::bad_input)?;
    let stop = Arc::new(AtomicBool::new(false));
    let flag = Arc::clone(&stop);
    std::thread::spawn(move || {
        let _ = std::io::stdin().read_to_end(&mut Vec::new());
        flag.store(true, Ordering::Relaxed);
    });
    Ok((job, ride, stop))
}

fn link_settings(job: &Job, stop: &Arc<AtomicBool>) -> Result<twinhub_link::Settings, LinkError> {
    let mut settings = twinhub_link::Settings::new(RideName::new(&job.link)?);
    settings.stop = Arc::clone(stop);
    settings.identity.tool = concat!("twinhub ", env!("CARGO_PKG_VERSION")).to_owned();
    Ok(settings)
}

fn tell(report: &Report) {
    // A parent that no longer listens has closed our standard input too.
    if let Ok(text) = serde_json::to_string(report) {
        let _ = writeln!(std::io::stdout().lock(), "{text}");
    }
}

/// The plant's process.
///
/// # Errors
/// As [`twinhub_sim::ride`].
pub fn plant() -> anyhow::Result<ExitCode> {
    let (job, ride, stop) = take_job()?;
    let settings = link_settings(&job, &stop).map_err(exit::environment)?;
    let mut port = PlantOffer::open(settings)
        .and_then(PlantOffer::accept)
        .map_err(exit::environment)?;
    let (version, git_hash) = program();
    let settings = Settings {
        log: Some(job.log),
        version,
        git_hash,
    };
    let every = (ride.ticks() / PROGRESS_LINES).max(1);
    let mut watch = |p: Progress| {
        if p.tick.is_multiple_of(every) {
            tell(&Report::Tick(p.tick));
        }
        !stop.load(Ordering::Relaxed)
    };
    let outcome = twinhub_sim::ride(&ride, &settings, &mut port, &mut watch).map_err(coded)?;
    let stopped = outcome.ending == Ending::Stopped;
    tell(&Report::Done {
        stopped,
        metrics: outcome.metrics,
        digest: outcome.digest,
    });
    Ok(ExitCode::SUCCESS)
}

/// The controller's process.
///
/// # Errors
/// As [`firmware_sim::run`].
pub fn controller() -> anyhow::Result<ExitCode> {
    let (job, ride, stop) = take_job()?;
    let settings = link_settings(&job, &stop).map_err(exit::environment)?;
    let options = firmware_sim::Options {
        settings,
        config: ride.law,
    };
    firmware_sim::run(options).map_err(|e| match e {
        LinkError::Interrupted => exit::interrupted(e),
        other => exit::environment(other),
    })?;
    Ok(ExitCode::SUCCESS)
}
