//! `twinhub simulate`: one open-loop run of the multibody plant.

use crate::exit::{FELL, bad_input, environment};
use anyhow::{Context, anyhow};
use indicatif::{ProgressBar, ProgressStyle};
use serde_json::json;
use std::fs::File;
use std::io::BufWriter;
use std::path::PathBuf;
use std::process::ExitCode;
use twinhub_sim::RideError;
use twinhub_sim::scenario::{Scenario, Summary, write_csv};

/// Arguments of `twinhub simulate`.
#[derive(clap::Args)]
pub struct SimulateArgs {
    /// A scenario that ships (`twinhub list scenarios`), or a scenario .toml
    scenario: String,
    /// Changes a key of the scenario by its path, as duration_s=5 or start.speed_m_s=6
    #[arg(long = "set", value_name = "PATH=VALUE")]
    set: Vec<String>,
    /// Where the rows go; without it only the summary is printed
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
    /// Prints the summary as JSON
    #[arg(long)]
    json: bool,
}

/// Runs it.
pub fn run(args: &SimulateArgs) -> anyhow::Result<ExitCode> {
    let scenario = Scenario::load(&args.scenario, &args.set).map_err(bad_input)?;
    let bar = progress(scenario.duration_s);
    let mut watch = |share: f64| {
        bar.set_position((1000.0 * share) as u64);
        true
    };
    let mut file = match &args.csv {
        Some(path) => Some(BufWriter::new(
            File::create(path)
                .with_context(|| format!("cannot write {}", path.display()))
                .map_err(bad_input)?,
        )),
        None => None,
    };
    let mut sink = std::io::sink();
    let out: &mut dyn std::io::Write = match &mut file {
        Some(file) => file,
        None => &mut sink,
    };
    let summary = write_csv(&scenario, out, &mut watch)
        .map_err(|error| match error {
            RideError::Setup(setup) => bad_input(setup),
            other => environment(other),
        })?
        .map_err(|error| environment(anyhow!("the rows cannot be written: {error}")))?;
    bar.finish_and_clear();
    let name = Scenario::name(&args.scenario);
    if args.json {
        let mut answer = json!({ "schema_version": 1, "scenario": name, "csv": args.csv });
        let parts = serde_json::to_value(&summary)?;
        for (key, value) in parts.as_object().into_iter().flatten() {
            answer[key] = value.clone();
        }
        println!("{answer}");
    } else {
        print(&name, &scenario, &summary);
        if let Some(path) = &args.csv {
            println!("rows: {} in {}", summary.rows, path.display());
        }
    }
    Ok(if summary.fell {
        ExitCode::from(FELL)
    } else {
        ExitCode::SUCCESS
    })
}

fn print(name: &str, scenario: &Scenario, s: &Summary) {
    println!("{name}: {}", scenario.about);
    println!("bicycle           {}", s.bicycle);
    match s.fall_time_s {
        Some(t) => println!("fell              at {t:.3} s"),
        None => println!("fell              no, in {:.3} s", s.duration_s),
    }
    println!(
        "roll              at most {:.3} deg, {:.3} at the end",
        s.max_roll_rad.to_degrees(),
        s.end_roll_rad.to_degrees()
    );
    println!(
        "steer             at most {:.3} deg",
        s.max_steer_rad.to_degrees()
    );
    println!(
        "at the end        {:.3} m/s, heading {:.2} deg",
        s.end_speed_m_s,
        s.end_yaw_rad.to_degrees()
    );
    if let Some(t) = s.front_wheel_locked_s {
        println!("front wheel       stood still from {t:.3} s on");
    }
    println!(
        "least load        front {:.0} N, rear {:.0} N",
        s.least_load_n[0], s.least_load_n[1]
    );
    let e = &s.energy;
    println!(
        "energy, J         {:.1} at the start, {:+.1} wheels, {:+.1} rider, {:+.1} disturbances, {:.1} lost, {:.1} at the end",
        e.start_j, e.wheels_j, e.rider_j, e.disturbances_j, e.lost_j, e.end_j
    );
}

/// A bar on a terminal; nothing elsewhere.
fn progress(duration_s: f64) -> ProgressBar {
    let bar = ProgressBar::new(1000);
    let style = ProgressStyle::with_template("{bar:40} {percent} % of {msg}");
    if let Ok(style) = style {
        bar.set_style(style);
    }
    bar.set_message(format!("{duration_s} s"));
    bar
}
