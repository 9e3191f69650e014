//! `twinhub ride`: the same course twice, stabilizer off and on.

use crate::exit;
use crate::interrupt::on_ctrl_c;
use crate::link_args::{LinkArgs, Target};
use crate::processes;
use crate::streams::{self, Controller, CortexMArgs};
use clap::Args;
use firmware_sim::cortex_m::Cost;
use indicatif::{ProgressBar, ProgressStyle};
use serde_json::json;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, Ordering};
use twinhub_link::{ControllerPort, InProcess, Pacing, Rights, Timed, Timing, Waiting};
use twinhub_sim::{Ending, Outcome, Progress, Ride, RideError, Settings};

/// Arguments of `twinhub ride`.
#[derive(Args)]
pub struct RideArgs {
    /// A course that ships (see `twinhub list`), or a course file.
    #[arg(default_value = twinhub_sim::shipped::DEFAULT_COURSE)]
    course: String,
    /// Change one value: `duration_s=20`, `seed=3`, `rider=young`, `law=off`, `motors=FILE`,
    /// `motors.front.lag_s=0.02`, `plant.multibody.road=wet`,
    /// `plant.multibody.set.tyre.front.twisting_gain=0.1`, `law.limits.torque_max_nm=30`,
    /// `rider.rider.steer_torque.delay_s=0.12`. May be given several times.
    #[arg(long = "set", value_name = "PATH=VALUE")]
    assignments: Vec<String>,
    /// Seed of everything random; the course's own if not given.
    #[arg(long)]
    seed: Option<u64>,
    #[command(flatten)]
    link: LinkArgs,
    #[command(flatten)]
    cortex_m: CortexMArgs,
    /// Ride with a controller of your own: a shell command that speaks the byte stream
    /// (`crates/link/STREAM.md`) on its standard input and output. Lockstep only.
    #[arg(long, value_name = "COMMAND", conflicts_with_all = ["in_process", "target", "listen"])]
    controller: Option<String>,
    /// Ride with a controller of your own that joins on this new Unix socket. Lockstep only.
    #[arg(long, value_name = "SOCKET", conflicts_with_all = ["in_process", "target"])]
    listen: Option<PathBuf>,
    /// Directory for logs and reports; each ride gets a directory of its own in it.
    #[arg(long, default_value = "rides")]
    out: PathBuf,
    /// Write no log, and so no page and no digest: what the closed loop costs by itself.
    #[arg(long, conflicts_with = "out")]
    no_log: bool,
    /// Print the result as JSON.
    #[arg(long)]
    json: bool,
}

/// One of the two rides, for the table and the report.
pub struct Run {
    /// Stabilizer on.
    pub on: bool,
    /// What came out.
    pub outcome: Outcome,
    /// How long the exchanges took.
    pub timing: Timing,
    /// What the controller cost its target, where that counts.
    pub cost: Option<Cost>,
}

/// Version and commit of this program.
pub fn program() -> (String, String) {
    (
        env!("CARGO_PKG_VERSION").to_owned(),
        env!("TWINHUB_GIT_HASH").to_owned(),
    )
}

/// Runs the command.
///
/// # Errors
/// Bad input, an environment without shared memory, a process that died.
pub fn run(args: &RideArgs) -> anyhow::Result<ExitCode> {
    let mut assignments = args.assignments.clone();
    assignments.extend(args.seed.map(|seed| format!("seed={seed}")));
    let mut ride = Ride::load(&args.course, &assignments).map_err(exit::bad_input)?;
    ride.course.link_fault.extend(&args.link.faults);
    let dir = match args.no_log {
        true => None,
        false => Some(new_directory(&args.out, &ride.name).map_err(exit::environment)?),
    };
    let stop = on_ctrl_c()?;

    let controller = controller(args)?;
    let mut runs = Vec::new();
    for on in [false, true] {
        let ride = ride.with_stabilizer(on);
        let name = if on { "on" } else { "off" };
        let bar = progress_bar(ride.ticks(), name);
        let log = dir.as_ref().map(|dir| dir.join(format!("{name}.mcap")));
        let log = log.as_deref();
        let done = match &controller {
            Some(controller) => streams::ride(controller, &ride, log, &args.link, &stop, &bar),
            None if args.link.target() == Target::InProcess => {
                let mut port = InProcess::new(twinhub_sim::in_process(&ride.law));
                with_port(&ride, log, &args.link, &stop, &bar, &mut port).map(without_cost)
            }
            None => processes::ride(&ride, log, &args.link, &stop, &bar).map(without_cost),
        };
        bar.finish_and_clear();
        let (outcome, timing, cost) = done?;
        if outcome.ending == Ending::Stopped {
            eprintln!(
                "stopped after {:.1} s{}",
                outcome.metrics.ticks as f64 * 1e-3,
                log.map_or(String::new(), |log| format!(
                    "; the log is {}",
                    log.display()
                ))
            );
            return Ok(ExitCode::from(exit::INTERRUPTED));
        }
        runs.push(Run {
            on,
            outcome,
            timing,
            cost,
        });
    }
    let page = dir.map(|dir| dir.join("report.html"));
    if let Some(page) = &page {
        crate::ride_report::write(page, &ride, &runs).map_err(exit::environment)?;
    }
    if args.json {
        println!(
            "{}",
            serde_json::to_string_pretty(&as_json(&runs, page.as_deref()))?
        );
    } else {
        print!("{}", crate::ride_report::table(&ride, &runs));
        print!("{}", crate::ride_report::punctuality(&runs));
        print!("{}", crate::ride_report::footer(page.as_deref()));
    }
    let fell = runs.iter().any(|run| run.outcome.metrics.fell);
    Ok(if fell {
        ExitCode::from(exit::FELL)
    } else {
        ExitCode::SUCCESS
    })
}

/// Who answers over a byte stream, if anybody does.
fn controller(args: &RideArgs) -> anyhow::Result<Option<Controller>> {
    let over_a_stream =
        args.controller.is_some() || args.listen.is_some() || args.link.target() == Target::CortexM;
    if over_a_stream && args.link.pacing() == Pacing::RealTime {
        let words = "a controller over a byte stream (cortex-m, --controller, --listen) rides with `--pacing lockstep`";
        return Err(exit::bad_input(anyhow::anyhow!(words)));
    }
    Ok(match (&args.controller, &args.listen) {
        (Some(command), _) => Some(Controller::Command(command.clone())),
        (_, Some(path)) => Some(Controller::listen(path)?),
        _ if over_a_stream => Some(Controller::CortexM(args.cortex_m.find()?)),
        _ => None,
    })
}

fn without_cost((outcome, timing): (Outcome, Timing)) -> (Outcome, Timing, Option<Cost>) {
    (outcome, timing, None)
}

/// Rides in this process with the controller behind `port`.
///
/// # Errors
/// As [`twinhub_sim::ride`].
pub fn with_port(
    ride: &Ride,
    log: Option<&Path>,
    link: &LinkArgs,
    stop: &AtomicBool,
    bar: &ProgressBar,
    port: &mut impl ControllerPort,
) -> anyhow::Result<(Outcome, Timing)> {
    let (version, git_hash) = program();
    let settings = Settings {
        log: log.map(Path::to_owned),
        version,
        git_hash,
    };
    let rights = (link.pacing() == Pacing::RealTime).then(Rights::acquire);
    let spin = link.waiting() == Waiting::Spin;
    let mut port = Timed::new(port, link.pacing(), spin).with_rights(rights);
    let mut watch = |p: Progress| {
        if p.tick.is_multiple_of(500) {
            bar.set_position(p.tick);
        }
        !stop.load(Ordering::Relaxed)
    };
    let outcome = twinhub_sim::ride(ride, &settings, &mut port, &mut watch).map_err(coded)?;
    Ok((outcome, port.timing().unwrap_or_default()))
}

/// The error with its exit code.
pub fn coded(error: RideError) -> anyhow::Error {
    match error {
        RideError::Setup(e) => exit::bad_input(e),
        RideError::Link(twinhub_link::LinkError::Interrupted) => exit::interrupted(error),
        other => exit::environment(other),
    }
}

/// A directory that no other ride writes to: `three_to_eight`, `three_to_eight-2`, ...
fn new_directory(out: &Path, name: &str) -> anyhow::Result<PathBuf> {
    let cannot = |path: &Path, e: std::io::Error| {
        anyhow::anyhow!(
            "{}: cannot be created: {e}; choose another place with --out DIR",
            path.display()
        )
    };
    std::fs::create_dir_all(out).map_err(|e| cannot(out, e))?;
    for n in 1u32.. {
        let dir = out.join(if n == 1 {
            name.to_owned()
        } else {
            format!("{name}-{n}")
        });
        match std::fs::create_dir(&dir) {
            Ok(()) => return Ok(dir),
            Err(e) if e.kind() == std::io::ErrorKind::AlreadyExists => {}
            Err(e) => return Err(cannot(&dir, e)),
        }
    }
    anyhow::bail!("{}: too many rides called {name}", out.display())
}

fn progress_bar(ticks: u64, name: &str) -> ProgressBar {
    let style = "stabilizer {msg:3} {bar:40} {percent:>3} %  {elapsed}";
    let bar = ProgressBar::new(ticks).with_message(name.to_owned());
    bar.set_style(
        ProgressStyle::with_template(style).unwrap_or_else(|_| ProgressStyle::default_bar()),
    );
    bar
}

fn as_json(runs: &[Run], page: Option<&Path>) -> serde_json::Value {
    let runs: Vec<_> = runs
        .iter()
        .map(|run| {
            let m = &run.outcome.metrics;
            json!({
                "stabilizer": if run.on { "on" } else { "off" },
                "fell": m.fell,
                "roll_rms_rad": m.roll_rms_rad,
                "steer_rms_rad": m.steer_rms_rad,
                "rider_effort_rms_nm": m.rider_effort_rms_nm,
                "energy_j": m.energy_j,
                "distance_m": m.distance_m,
                "ticks": m.ticks,
                "missed_ticks": m.missed_ticks,
                "digest": run.outcome.digest,
                "timing": run.timing,
                "log": run.outcome.log,
                "cost": run.cost,
            })
        })
        .collect();
    json!({ "schema_version": 1, "runs": runs, "report": page })
}
