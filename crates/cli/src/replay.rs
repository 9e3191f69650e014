//! `twinhub replay`: what a ride's controller was told, told again to another one.

use crate::exit;
use crate::streams::CortexMArgs;
use anyhow::anyhow;
use clap::Args;
use firmware_sim::cortex_m::Cost;
use firmware_sim::replay::{Comparison, compare, frames};
use serde_json::{Value, json};
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use twinhub_log::{CONTROL_OUTPUT, RIDER_INTENT, SENSOR_MEASUREMENT, messages};
use twinhub_sim::Ride;
use twinhub_types::{Measurement, Output, PlantFrame, RiderIntent};

/// Arguments of `twinhub replay`.
#[derive(Args)]
pub struct ReplayArgs {
    /// Log of a ride (`rides/first_ride/on.mcap`).
    log: PathBuf,
    /// Who answers besides the controller of this program: `in-process`, whose answers are those
    /// of the log, or `cortex-m`, the firmware in QEMU.
    #[arg(long, default_value = "in-process", value_parser = ["in-process", "cortex-m"])]
    target: String,
    #[command(flatten)]
    cortex_m: CortexMArgs,
    /// The first so many recorded ticks; all unless given.
    #[arg(long, value_name = "N")]
    ticks: Option<usize>,
    /// Then so many frames that no bicycle sends: NaN, infinities, denormals, extremes, random
    /// bits, jumps of the clock, mode changes. For `--target cortex-m`.
    #[arg(long, value_name = "N", default_value_t = 0)]
    adversarial: u64,
    /// Seed of those frames.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Fail (exit code 1) if a tick takes more instructions than this on the target.
    #[arg(long, value_name = "N")]
    max_instructions: Option<u64>,
    /// Print the result as JSON.
    #[arg(long)]
    json: bool,
}

/// One comparison.
struct Trace {
    name: &'static str,
    comparison: Comparison,
    cost: Option<Cost>,
}

/// Runs the command.
///
/// # Errors
/// If the log is no log of a ride, or there is no target.
pub fn run(args: &ReplayArgs) -> anyhow::Result<ExitCode> {
    let on_target = args.target == "cortex-m";
    if args.adversarial > 0 && !on_target {
        return Err(exit::bad_input(anyhow!(
            "--adversarial needs --target cortex-m"
        )));
    }
    let log = twinhub_log::read(&args.log).map_err(exit::bad_input)?;
    let config = log.config_text().ok_or_else(|| {
        exit::bad_input(anyhow!("{}: holds no configuration", args.log.display()))
    })?;
    let ride: Ride = toml::from_str(config).map_err(exit::bad_input)?;
    let recorded = || -> Result<_, twinhub_log::LogError> {
        let times = &log.table(SENSOR_MEASUREMENT)?.publish_time_ns;
        let measurements = messages::<Measurement>(&log, SENSOR_MEASUREMENT)?;
        let intents = messages::<RiderIntent>(&log, RIDER_INTENT)?;
        let outputs = messages::<Output>(&log, CONTROL_OUTPUT)?;
        Ok((frames(times, &measurements, &intents), outputs))
    };
    let (mut trace, outputs) = recorded().map_err(exit::bad_input)?;

    trace.truncate(args.ticks.unwrap_or(usize::MAX));
    let mut traces = Vec::new();
    if on_target {
        traces.push(on_cortex_m(args, &ride, "recorded", &trace)?);
        if args.adversarial > 0 {
            let hostile = firmware_sim::adversarial::frames(args.adversarial, args.seed);
            traces.push(on_cortex_m(args, &ride, "adversarial", &hostile)?);
        }
    } else {
        let mut outputs = outputs.into_iter();
        let mut logged =
            twinhub_link::InProcess::new(|frame: &PlantFrame| twinhub_types::ControllerFrame {
                header: frame.header,
                output: outputs.next().unwrap_or_default(),
            });
        let comparison = compare(&trace, &ride.law, &mut logged).map_err(exit::environment)?;
        traces.push(Trace {
            name: "recorded",
            comparison,
            cost: None,
        });
    }
    let same = traces.iter().all(|t| t.comparison.different == 0);
    let worst = traces
        .iter()
        .filter_map(|t| t.cost.as_ref().map(|c| c.instructions_per_tick))
        .max();
    let cheap = match (args.max_instructions, worst) {
        (Some(most), Some(worst)) => worst <= most,
        (Some(_), None) => !on_target,
        (None, _) => true,
    };
    if args.json {
        let value = json!({
            "schema_version": 1,
            "target": args.target,
            "bit_identical": same,
            "instructions_per_tick": worst,
            "max_instructions": args.max_instructions,
            "passed": same && cheap,
            "traces": traces.iter().map(as_json).collect::<Vec<_>>(),
        });
        println!("{}", serde_json::to_string_pretty(&value)?);
    } else {
        traces.iter().for_each(print);
        if let (Some(most), false) = (args.max_instructions, cheap) {
            println!("more than {most} instructions in a tick");
        }
    }
    Ok(if same && cheap {
        ExitCode::SUCCESS
    } else {
        ExitCode::from(exit::FELL)
    })
}

fn on_cortex_m(
    args: &ReplayArgs,
    ride: &Ride,
    name: &'static str,
    trace: &[PlantFrame],
) -> anyhow::Result<Trace> {
    let stop = Arc::new(AtomicBool::new(false));
    let mut target = args.cortex_m.find()?.start(&ride.law, &stop)?;
    let comparison = compare(trace, &ride.law, &mut target).map_err(exit::environment)?;
    Ok(Trace {
        name,
        comparison,
        cost: target.finish(),
    })
}

fn as_json(trace: &Trace) -> Value {
    json!({
        "trace": trace.name,
        "comparison": trace.comparison,
        "cost": trace.cost,
    })
}

fn print(trace: &Trace) {
    let c = &trace.comparison;
    match &c.first_different {
        None => println!("{}: {} ticks, the same bits", trace.name, c.ticks),
        Some(first) => println!(
            "{}: {} of {} answers differ, first at tick {}\n  expected {}\n  found    {}",
            trace.name, c.different, c.ticks, first.tick, first.expected, first.found
        ),
    }
    if let Some(cost) = &trace.cost {
        println!(
            "  instructions a tick: at most {}, mean {:.0}; the controller's step alone at most {} (tick {}), mean {:.0}",
            cost.instructions_per_tick,
            cost.instructions_per_tick_mean,
            cost.step_instructions,
            cost.step_worst_tick,
            cost.step_instructions_mean
        );
        println!(
            "  {:.1} % of the 168,000 that fit into 1 ms at 168 MHz, if one took one cycle; QEMU counts instructions, not cycles",
            1e2 * cost.budget_ratio
        );
        println!(
            "  stack: at most {} of {} bytes",
            cost.stack_used_bytes, cost.stack_bytes
        );
    }
}
