//! `twinhub map`: stability of a multibody bicycle over speed and torque of the motor pair.

use crate::exit::bad_input;
use crate::span;
use anyhow::{Context, anyhow};
use serde_json::json;
use std::io::IsTerminal;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;
use twinhub_plant::bicycles;
use twinhub_plant::multibody::{MapPoint, Multibody, map, stable_ranges_m_s};
use twinhub_report::map_picture::{Grid, MapPicture};

/// Most points in one request.
const MOST_POINTS: usize = 2_000_000;
/// Most rows of the printed table.
const MOST_ROWS: usize = 21;
/// Slowest speed that has a steady state, m/s.
const SLOWEST_M_S: f64 = 0.05;

/// Arguments of `twinhub map`.
#[derive(clap::Args)]
pub struct MapArgs {
    /// A set that ships, with options as NAME:OPTION=VALUE (`twinhub list bicycles`), or a plant .toml;
    /// a linear bicycle is taken without slip and with a rigid rider
    #[arg(
        long,
        value_name = "NAME_OR_FILE",
        default_value = "bulsink2017_bicycle1_full"
    )]
    bicycle: String,
    /// Changes a parameter by its path, as tyre.front.twisting_gain=0.1 (`twinhub list parameters`)
    #[arg(long = "set", value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// Speeds from A to B by STEP, m/s
    #[arg(
        long,
        value_name = "A:B:STEP",
        default_value = "0.51:10.5:0.01",
        allow_hyphen_values = true
    )]
    speeds_m_s: String,
    /// Torques of the pair (front brake; the rear motor holds the speed) from A to B by STEP, Nm
    #[arg(
        long,
        value_name = "A:B:STEP",
        default_value = "0:95:5",
        allow_hyphen_values = true
    )]
    torques_nm: String,
    /// Threads; by default one per core
    #[arg(long, value_name = "N")]
    threads: Option<usize>,
    /// Prints the result as JSON
    #[arg(long)]
    json: bool,
    /// File for every point: speed, torque, growth of all, of oscillating and of slow modes
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
    /// File for the picture, .svg or .html; by default map_BICYCLE.svg, with --json none
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

/// A map with what it was asked for.
struct Answer {
    bicycle: String,
    source: String,
    speeds_m_s: Vec<f64>,
    torques_nm: Vec<f64>,
    rows: Vec<Vec<MapPoint>>,
}

/// Computes and prints the map.
pub fn run(args: &MapArgs) -> anyhow::Result<ExitCode> {
    let speeds_m_s =
        span::numbers("--speeds-m-s", &args.speeds_m_s, "m/s", SLOWEST_M_S).map_err(bad_input)?;
    let torques_nm =
        span::numbers("--torques-nm", &args.torques_nm, "Nm", 0.0).map_err(bad_input)?;
    let points = speeds_m_s.len() * torques_nm.len();
    if points > MOST_POINTS {
        return Err(bad_input(anyhow!(
            "{points} points; accepted: at most {MOST_POINTS}"
        )));
    }
    if args.threads == Some(0) {
        return Err(bad_input(anyhow!("--threads 0; accepted: 1 or more")));
    }
    let page = args
        .out
        .as_deref()
        .map(crate::modes::is_page)
        .transpose()
        .map_err(bad_input)?;
    let parameters = bicycles::load_multibody(&args.bicycle, &args.set).map_err(bad_input)?;
    let model = Multibody::new(&parameters).map_err(bad_input)?;
    let cores = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    let threads = args.threads.unwrap_or(cores);

    let bar = indicatif::ProgressBar::new(points as u64);
    if !std::io::stderr().is_terminal() {
        bar.set_draw_target(indicatif::ProgressDrawTarget::hidden());
    }
    let start = Instant::now();
    let rows = map(&model, &torques_nm, &speeds_m_s, threads, &|rows| {
        bar.set_position((rows * speeds_m_s.len()) as u64);
        true
    });
    bar.finish_and_clear();
    eprintln!(
        "{points} points in {:.2} s on {threads} thread(s)",
        start.elapsed().as_secs_f64()
    );
    let answer = Answer {
        bicycle: parameters.name.clone(),
        source: parameters.source.clone(),
        speeds_m_s,
        torques_nm,
        rows,
    };

    if let Some(file) = &args.csv {
        write(file, &answer.csv())?;
    }
    let picture = args
        .out
        .clone()
        .or_else(|| (!args.json).then(|| crate::modes::picture_name("map", &answer.bicycle)));
    if let Some(file) = &picture {
        write(file, &answer.picture(page.unwrap_or(false)))?;
    }
    if args.json {
        println!("{}", answer.json());
    } else {
        answer.print();
        for file in picture.iter().chain(&args.csv) {
            println!("written: {}", file.display());
        }
    }
    Ok(ExitCode::SUCCESS)
}

fn write(file: &Path, text: &str) -> anyhow::Result<()> {
    std::fs::write(file, text)
        .with_context(|| format!("cannot write {}", file.display()))
        .map_err(bad_input)
}

impl Answer {
    fn grid(&self, growth: impl Fn(&MapPoint) -> Option<f64>) -> Grid {
        let row = |row: &Vec<MapPoint>| row.iter().map(&growth).collect();
        self.rows.iter().map(row).collect()
    }

    /// The stable ranges of a row in words.
    fn ranges(row: &[MapPoint]) -> String {
        let ranges = stable_ranges_m_s(row);
        if row.iter().all(|p| p.eigenvalues.is_empty()) {
            return "no steady state: the tyres cannot carry it".to_owned();
        }
        if ranges.is_empty() {
            return "nowhere".to_owned();
        }
        let words: Vec<String> = ranges
            .iter()
            .map(|[a, b]| format!("{a:.2} to {b:.2}"))
            .collect();
        words.join(", ")
    }

    fn csv(&self) -> String {
        let mut text =
            "speed_m_s,torque_nm,growth_1_s,oscillating_growth_1_s,slow_growth_1_s\n".to_owned();
        let cell = |v: Option<f64>| v.map_or(String::new(), |v| v.to_string());
        for point in self.rows.iter().flatten() {
            text.push_str(&format!(
                "{},{},{},{},{}\n",
                point.speed_m_s,
                point.torque_nm,
                cell(point.growth_rad_s()),
                cell(point.oscillating_growth_rad_s()),
                cell(point.slow_growth_rad_s()),
            ));
        }
        text
    }

    fn json(&self) -> serde_json::Value {
        let ranges: Vec<_> = self.rows.iter().map(|row| stable_ranges_m_s(row)).collect();
        json!({
            "schema_version": 1,
            "bicycle": self.bicycle,
            "source": self.source,
            "speeds_m_s": self.speeds_m_s,
            "torques_nm": self.torques_nm,
            "growth_1_s": self.grid(MapPoint::growth_rad_s),
            "oscillating_growth_1_s": self.grid(MapPoint::oscillating_growth_rad_s),
            "slow_growth_1_s": self.grid(MapPoint::slow_growth_rad_s),
            "stable_ranges_m_s": ranges,
        })
    }

    fn picture(&self, page: bool) -> String {
        let picture = MapPicture {
            title: &self.bicycle,
            subtitle: "growth of small disturbances over speed and torque of the motor pair",
            speeds_m_s: &self.speeds_m_s,
            torques_nm: &self.torques_nm,
            growth_1_s: &self.grid(MapPoint::growth_rad_s),
            oscillating_1_s: &self.grid(MapPoint::oscillating_growth_rad_s),
            slow_1_s: &self.grid(MapPoint::slow_growth_rad_s),
        };
        if !page {
            return picture.svg();
        }
        let row = |k: usize| {
            format!(
                "at {} Nm {}",
                self.torques_nm[k],
                Self::ranges(&self.rows[k])
            )
        };
        let last = self.rows.len() - 1;
        picture.html(&format!(
            "Stable by itself, m/s: {}; {}.",
            row(0),
            row(last)
        ))
    }

    fn print(&self) {
        println!(
            "{}: speeds at which it is stable by itself, m/s",
            self.bicycle
        );
        println!("torque, Nm   from, to");
        let every = self.rows.len().div_ceil(MOST_ROWS);
        for (row, torque) in self.rows.iter().zip(&self.torques_nm).step_by(every) {
            println!("{torque:10}   {}", Self::ranges(row));
        }
        if every > 1 {
            eprintln!("note: one of {every} torques is shown; --json and --csv have all");
        }
    }
}
