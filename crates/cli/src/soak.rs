//! `twinhub soak`: one long ride in two processes, and whether speed and memory stay what they are.
//!
//! The ride has no log: an hour in lockstep is some hundred hours of riding. Each window gives the
//! time ridden per time passed, the processor time per tick of either process, and their memory.
//! Processor time is what tells a leak or a slowdown from a busy machine.

use crate::exit;
use crate::interrupt::on_ctrl_c;
use crate::link_args::LinkArgs;
use crate::processes::{CONTROLLER, Job, PLANT, Report, reports, spawn, wait};
use anyhow::{Context, anyhow};
use clap::Args;
use indicatif::{ProgressBar, ProgressStyle};
use serde::Serialize;
use serde_json::json;
use std::process::{ExitCode, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::RecvTimeoutError;
use std::time::{Duration, Instant};
use twinhub_link::{Pacing, Timing};
use twinhub_sim::Ride;

/// Windows that the time is divided into.
const WINDOWS: u32 = 12;
/// Largest growth of memory from the first window on that counts as flat, kB.
const FLAT_KB: u64 = 1024;

/// Arguments of `twinhub soak`.
#[derive(Args)]
pub struct SoakArgs {
    /// How long.
    #[arg(long, default_value_t = 60.0)]
    minutes: f64,
    #[command(flatten)]
    link: LinkArgs,
    /// Print the result as JSON.
    #[arg(long)]
    json: bool,
}

/// What a process has used so far.
#[derive(Clone, Copy, Debug, Default)]
struct Used {
    cpu_s: f64,
    memory_kb: u64,
}

impl Used {
    /// Of the process `pid`, as the kernel tells.
    fn of(pid: u32) -> Option<Self> {
        let stat = std::fs::read_to_string(format!("/proc/{pid}/stat")).ok()?;
        let words: Vec<&str> = stat.rsplit(')').next()?.split_whitespace().collect();
        let number = |i: usize| words.get(i)?.parse::<f64>().ok();
        // SAFETY: asks for two constants of the system.
        let (per_s, page) = unsafe {
            (
                libc::sysconf(libc::_SC_CLK_TCK),
                libc::sysconf(libc::_SC_PAGESIZE),
            )
        };
        Some(Self {
            cpu_s: (number(11)? + number(12)?) / per_s as f64,
            memory_kb: (number(21)? * page as f64) as u64 >> 10,
        })
    }
}

/// One window.
#[derive(Clone, Debug, Serialize)]
struct Window {
    elapsed_s: f64,
    real_time_factor: f64,
    plant_cpu_us_per_tick: f64,
    controller_cpu_us_per_tick: f64,
    plant_memory_kb: u64,
    controller_memory_kb: u64,
}

/// Runs the command: exit code 0 if memory stayed flat, 1 if not. Speed is reported only: a
/// machine that others use as well cannot hold it.
///
/// # Errors
/// An environment without shared memory, a process that died.
pub fn run(args: &SoakArgs) -> anyhow::Result<ExitCode> {
    if !(args.minutes > 0.0 && args.minutes <= 10_000.0) {
        return Err(exit::bad_input(anyhow!(
            "--minutes {}: accepted is above 0, at most 10000",
            args.minutes
        )));
    }
    let mut ride = Ride::load("first_ride", &[]).map_err(exit::bad_input)?;
    // Longer than any soak: the clock ends it. The speed stays that of the last point.
    ride.course.duration_s = 1e9;
    ride.course.disturbance.clear();
    let stop = on_ctrl_c()?;
    let job = serde_json::to_string(&Job {
        link: format!("soak{}", std::process::id()),
        pacing: args.link.pacing().name().to_owned(),
        waiting: args.link.waiting().name().to_owned(),
        ride_toml: ride.to_toml(),
        log: None,
        report_every: 1000,
        run_dir: None,
    })?;
    let (mut plant, plant_in) = spawn(PLANT, &job, Stdio::inherit())?;
    let (mut controller, controller_in) = spawn(CONTROLLER, &job, Stdio::inherit())?;
    let told = reports(&mut plant);
    let _heard = reports(&mut controller);
    let (windows, fell) = watch(args, &told, plant.id(), controller.id(), &stop);
    drop(plant_in);
    let timing = told.iter().find_map(|report| match report {
        Report::Done { timing, .. } => Some(*timing),
        _ => None,
    });
    wait(&mut plant);
    wait(&mut controller);
    drop(controller_in);
    let timing = timing
        .filter(|_| !fell)
        .context("the ride broke off")
        .map_err(exit::environment)?;
    report(args, &windows, &timing, stop.load(Ordering::Relaxed))
}

/// Fills the windows; true if the ride ended before its time.
fn watch(
    args: &SoakArgs,
    told: &std::sync::mpsc::Receiver<Report>,
    plant: u32,
    controller: u32,
    stop: &AtomicBool,
) -> (Vec<Window>, bool) {
    let window = Duration::from_secs_f64(args.minutes * 60.0 / f64::from(WINDOWS));
    let bar = ProgressBar::new(WINDOWS.into());
    bar.set_style(
        ProgressStyle::with_template("{bar:40} {pos}/{len} windows  {elapsed}  {msg}")
            .unwrap_or_else(|_| ProgressStyle::default_bar()),
    );
    let mut windows = Vec::new();
    let mut tick = 0;
    let mut start: Option<(Instant, u64, Used, Used)> = None;
    while windows.len() < WINDOWS as usize && !stop.load(Ordering::Relaxed) {
        match told.recv_timeout(Duration::from_millis(50)) {
            Ok(Report::Tick(now)) => tick = now,
            Ok(Report::Done { .. }) | Err(RecvTimeoutError::Disconnected) => {
                return (windows, true);
            }
            Ok(_) => {}
            Err(RecvTimeoutError::Timeout) => continue,
        }
        let used = |pid| Used::of(pid).unwrap_or_default();
        // Start-up is no part of the first window.
        let Some((begin, first, plant_0, controller_0)) = start else {
            if tick > 1000 {
                start = Some((Instant::now(), tick, used(plant), used(controller)));
            }
            continue;
        };
        if begin.elapsed() < window {
            continue;
        }
        let (now, plant_1, controller_1) = (Instant::now(), used(plant), used(controller));
        let ticks = (tick - first).max(1) as f64;
        let found = Window {
            elapsed_s: (now - begin).as_secs_f64(),
            real_time_factor: ticks * 1e-3 / (now - begin).as_secs_f64(),
            plant_cpu_us_per_tick: (plant_1.cpu_s - plant_0.cpu_s) * 1e6 / ticks,
            controller_cpu_us_per_tick: (controller_1.cpu_s - controller_0.cpu_s) * 1e6 / ticks,
            plant_memory_kb: plant_1.memory_kb,
            controller_memory_kb: controller_1.memory_kb,
        };
        bar.set_message(format!("real-time factor {:.1}", found.real_time_factor));
        bar.inc(1);
        windows.push(found);
        start = Some((now, tick, plant_1, controller_1));
    }
    bar.finish_and_clear();
    (windows, false)
}

/// Largest difference from the mean, as a share of it.
fn spread(values: impl Iterator<Item = f64> + Clone) -> f64 {
    let count = values.clone().count().max(1) as f64;
    let mean = values.clone().sum::<f64>() / count;
    values.map(|v| (v - mean).abs() / mean).fold(0.0, f64::max)
}

fn report(
    args: &SoakArgs,
    windows: &[Window],
    timing: &Timing,
    stopped: bool,
) -> anyhow::Result<ExitCode> {
    let growth = |memory: fn(&Window) -> u64| {
        let first = windows.first().map_or(0, memory);
        let most = windows.iter().map(memory).max().unwrap_or(0);
        most.saturating_sub(first)
    };
    let plant_growth_kb = growth(|w| w.plant_memory_kb);
    let controller_growth_kb = growth(|w| w.controller_memory_kb);
    let flat = plant_growth_kb <= FLAT_KB && controller_growth_kb <= FLAT_KB;
    let speed_spread = spread(windows.iter().map(|w| w.real_time_factor));
    let cpu_spread = spread(windows.iter().map(|w| w.plant_cpu_us_per_tick));
    if args.json {
        let text = json!({
            "schema_version": 1,
            "passed": flat && !stopped,
            "minutes": args.minutes,
            "ticks": timing.round_trip_us.count + timing.missed_answers,
            "speed_spread_ratio": speed_spread,
            "plant_cpu_spread_ratio": cpu_spread,
            "plant_memory_growth_kb": plant_growth_kb,
            "controller_memory_growth_kb": controller_growth_kb,
            "windows": windows,
            "timing": timing,
        });
        println!("{}", serde_json::to_string_pretty(&text)?);
    } else {
        println!(
            "  time s  real-time factor  CPU us/tick plant, controller  memory kB plant, controller"
        );
        for w in windows {
            println!(
                "{:8.1} {:17.2} {:18.2} {:11.2} {:17} {:11}",
                w.elapsed_s,
                w.real_time_factor,
                w.plant_cpu_us_per_tick,
                w.controller_cpu_us_per_tick,
                w.plant_memory_kb,
                w.controller_memory_kb
            );
        }
        println!(
            "speed within {:.1} % of its mean, the plant's processor time within {:.1} %; memory grew by {plant_growth_kb} and {controller_growth_kb} kB after the first window",
            1e2 * speed_spread,
            1e2 * cpu_spread
        );
        if args.link.pacing() == Pacing::RealTime {
            let q = &timing.lateness_us;
            println!(
                "lateness, us: p50 {:.0}, p99 {:.0}, p99.9 {:.0}, max {:.0}; overruns {}, slipped ticks {}, missed answers {}, late answers {} of {} ticks",
                q.p50,
                q.p99,
                q.p999,
                q.max,
                timing.overruns,
                timing.slipped_ticks,
                timing.missed_answers,
                timing.late_answers,
                q.count
            );
        }
    }
    Ok(match (stopped, flat) {
        (true, _) => ExitCode::from(exit::INTERRUPTED),
        (false, true) => ExitCode::SUCCESS,
        (false, false) => ExitCode::from(exit::FELL),
    })
}
