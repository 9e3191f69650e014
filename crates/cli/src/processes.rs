//! A ride in two processes: this program starts itself twice, as plant and as controller.
//!
//! A child reads its job from standard input (one line of JSON), which then stays open: when it
//! closes, the plant brings the ride to an orderly end and the controller with it; so both also
//! end when this process dies. A child tells its progress and its result on standard output, a
//! line of JSON each. Children have a process group of their own: Ctrl-C reaches this process
//! only.

use crate::exit;
use crate::link_args::LinkArgs;
use anyhow::{Context, anyhow};
use indicatif::ProgressBar;
use serde::{Deserialize, Serialize};
use std::io::{BufRead, BufReader, Write};
use std::os::unix::process::{CommandExt, ExitStatusExt};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, Command, ExitStatus, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::{Duration, Instant};
use twinhub_link::Timing;
use twinhub_sim::{Ending, Metrics, Outcome, Ride};

/// The hidden command of the plant's process.
pub const PLANT: &str = "plant-process";
/// The hidden command of the controller's process.
pub const CONTROLLER: &str = "controller-process";

/// How long a child may take to end after its peer has.
const LAST_WORDS: Duration = Duration::from_secs(10);
/// Progress lines per ride.
const PROGRESS_LINES: u64 = 50;

/// What a child is told. The ride is TOML: it keeps every bit of a number.
#[derive(Serialize, Deserialize)]
pub struct Job {
    /// Name of the ride.
    pub link: String,
    /// As [`twinhub_link::Pacing`] has it.
    pub pacing: String,
    /// As [`twinhub_link::Waiting`] has it.
    pub waiting: String,
    /// The ride.
    pub ride_toml: String,
    /// Where the plant writes its log, if it does.
    pub log: Option<PathBuf>,
    /// Ticks between two [`Report::Tick`].
    pub report_every: u64,
    /// Where rides meet, if not where they usually do.
    pub run_dir: Option<PathBuf>,
}

/// What the processes tell.
#[derive(Debug, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Report {
    /// The plant has come so far.
    Tick(u64),
    /// The other side was noticed to be silent or gone.
    Lost {
        /// The monotonic clock, ns.
        at_ns: u64,
        /// Since the last sign of life, ms.
        silence_ms: f64,
    },
    /// The controller asks for no torque any more.
    Quiet {
        /// The monotonic clock, ns.
        at_ns: u64,
        /// Ticks without a frame until then.
        ticks: u64,
    },
    /// The plant's ride has come to its end.
    #[allow(missing_docs)] // as in the outcome of a ride
    Done {
        stopped: bool,
        metrics: Metrics,
        digest: String,
        timing: Box<Timing>,
    },
}

/// What came of a ride.
type Done = (Outcome, Timing);

/// Rides `ride` in two processes.
///
/// # Errors
/// If a process cannot be started or did not come to its end; what it said is on standard error.
pub fn ride(
    ride: &Ride,
    log: Option<&Path>,
    link: &LinkArgs,
    stop: &AtomicBool,
    bar: &ProgressBar,
) -> anyhow::Result<Done> {
    let job = serde_json::to_string(&Job {
        link: format!(
            "ride{}-{}",
            std::process::id(),
            if ride.stabilizer_on { "on" } else { "off" }
        ),
        pacing: link.pacing().name().to_owned(),
        waiting: link.waiting().name().to_owned(),
        ride_toml: ride.to_toml(),
        log: log.map(Path::to_owned),
        report_every: (ride.ticks() / PROGRESS_LINES).max(1),
        run_dir: None,
    })?;
    let (mut plant, plant_in) = spawn(PLANT, &job, Stdio::inherit())?;
    let (mut controller, controller_in) = match spawn(CONTROLLER, &job, Stdio::inherit()) {
        Ok(started) => started,
        Err(e) => {
            drop(plant_in);
            wait(&mut plant);
            return Err(e);
        }
    };
    // What the controller tells is for others; it is read so that it never blocks.
    let _heard = reports(&mut controller);
    let done = follow(reports(&mut plant), stop, plant_in, bar);
    let plant_end = wait(&mut plant);
    let controller_end = wait(&mut controller);
    drop(controller_in);
    if let Some(done) = done {
        return Ok(done_with(done, log));
    }
    let what = anyhow!(
        "the ride broke off at {:.1} s: the plant's process {}, the controller's process {}{}",
        bar.position() as f64 * 1e-3,
        fate(plant_end),
        fate(controller_end),
        log.map_or(String::new(), |log| format!(
            "; the log so far is {}",
            log.display()
        ))
    );
    Err(if stop.load(Ordering::Relaxed) {
        exit::interrupted(what)
    } else {
        exit::environment(what)
    })
}

/// The outcome that the plant told.
fn done_with(done: Told, log: Option<&Path>) -> Done {
    let (stopped, metrics, digest, timing) = done;
    let ending = match (stopped, metrics.fell) {
        (true, _) => Ending::Stopped,
        (false, true) => Ending::Fell,
        (false, false) => Ending::Finished,
    };
    let outcome = Outcome {
        ending,
        metrics,
        digest,
        log: log.map(Path::to_owned),
    };
    (outcome, timing)
}

/// Starts this program again as `role`.
///
/// # Errors
/// If it cannot be started.
pub fn spawn(role: &str, job: &str, errors: Stdio) -> anyhow::Result<(Child, ChildStdin)> {
    let program = std::env::current_exe().context("this program does not know where it is")?;
    let mut child = Command::new(program)
        .arg(role)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(errors)
        .process_group(0)
        .spawn()
        .with_context(|| format!("the {role} cannot be started"))
        .map_err(exit::environment)?;
    let mut input = child.stdin.take().context("a child has a standard input")?;
    writeln!(input, "{job}").with_context(|| format!("the {role} does not take its job"))?;
    Ok((child, input))
}

/// A child's reports, read by a thread of their own.
pub fn reports(child: &mut Child) -> Receiver<Report> {
    let (send, receive) = channel();
    if let Some(output) = child.stdout.take() {
        std::thread::spawn(move || {
            for line in BufReader::new(output).lines().map_while(Result::ok) {
                let Ok(report) = serde_json::from_str(&line) else {
                    break;
                };
                // Read on if nobody listens: a full pipe would stop the child.
                let _ = send.send(report);
            }
        });
    }
    receive
}

/// Stopped, metrics, digest, timing.
type Told = (bool, Metrics, String, Timing);

/// Follows the ride to its end; `None` if there is no result.
fn follow(
    reports: Receiver<Report>,
    stop: &AtomicBool,
    plant_in: ChildStdin,
    bar: &ProgressBar,
) -> Option<Told> {
    let mut plant_in = Some(plant_in);
    loop {
        if stop.load(Ordering::Relaxed) {
            plant_in = None;
        }
        match reports.recv_timeout(Duration::from_millis(20)) {
            Ok(Report::Tick(tick)) => bar.set_position(tick),
            Ok(Report::Lost { .. } | Report::Quiet { .. }) => {}
            Ok(Report::Done {
                stopped,
                metrics,
                digest,
                timing,
            }) => return Some((stopped, metrics, digest, *timing)),
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => {
                drop(plant_in);
                return None;
            }
        }
    }
}

/// Waits for a child to end; one that does not end in time is killed.
pub fn wait(child: &mut Child) -> Option<ExitStatus> {
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
