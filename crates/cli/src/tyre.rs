//! `twinhub tyre`: forces of a tyre over slip, lean and load.

mod plot;

use crate::exit::{bad_input, environment};
use anyhow::{Context, Result, anyhow};
use clap::Args;
use serde::Serialize;
use std::fmt::Write as _;
use std::path::PathBuf;
use std::process::ExitCode;
use twinhub_plant::tyre::{SETS, Tyre, TyreInput, TyreModel, set};

/// Most points that one call evaluates.
const MOST_POINTS: usize = 1_000_000;

/// Evaluate a tyre: one point, or a sweep of load, slip and lean.
///
/// Signs: slip angle positive when the contact slides to the right, camber positive leaning right,
/// slip positive driving; forces positive forward and to the right, moments about x forward and
/// z down.
#[derive(Args, Debug)]
pub struct TyreArgs {
    /// Tyre set, or tyre model (which then takes its first set)
    #[arg(long, value_name = "NAME")]
    model: String,
    /// Load of the road on the wheel, N; A:B:STEP sweeps
    #[arg(
        long,
        value_name = "RANGE",
        default_value = "400",
        allow_hyphen_values = true
    )]
    load_n: Range,
    /// Slip angle, rad; A:B:STEP sweeps
    #[arg(
        long,
        value_name = "RANGE",
        default_value = "0",
        allow_hyphen_values = true
    )]
    slip_angle_rad: Range,
    /// Camber, rad; A:B:STEP sweeps
    #[arg(
        long,
        value_name = "RANGE",
        default_value = "0",
        allow_hyphen_values = true
    )]
    camber_rad: Range,
    /// Longitudinal slip, -1 with the wheel locked; A:B:STEP sweeps
    #[arg(
        long,
        value_name = "RANGE",
        default_value = "0",
        allow_hyphen_values = true
    )]
    slip_ratio: Range,
    /// Friction coefficient of the road
    #[arg(long, value_name = "MU", default_value_t = 1.0)]
    friction: f64,
    /// Radius of the wheel, m
    #[arg(long, value_name = "R", default_value_t = 0.35)]
    radius_m: f64,
    /// Forward speed, m/s (for the sign of rolling resistance)
    #[arg(
        long,
        value_name = "V",
        default_value_t = 5.0,
        allow_hyphen_values = true
    )]
    speed_m_s: f64,
    /// Change a parameter of the tyre, as twisting_gain=0.1 or combined=ellipse; repeatable
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// Print JSON
    #[arg(long)]
    json: bool,
    /// Write a picture of the forces over the first quantity that is swept
    #[arg(long, value_name = "FILE.svg")]
    out: Option<PathBuf>,
}

/// A number, or evenly spaced numbers A:B:STEP with both ends.
#[derive(Clone, Debug, PartialEq)]
struct Range(Vec<f64>);

impl std::str::FromStr for Range {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let numbers = text
            .split(':')
            .map(|part| match part.trim().parse::<f64>() {
                Ok(number) if number.is_finite() => Ok(number),
                _ => Err(format!("`{part}` is not a finite number")),
            })
            .collect::<Result<Vec<_>, _>>()?;
        match numbers[..] {
            [one] => Ok(Self(vec![one])),
            [from, to, step] if step != 0.0 && (to - from) / step >= 0.0 => {
                // a millionth of a step makes up for rounding at the far end
                let count = ((to - from) / step + 1e-6).floor();
                if count >= MOST_POINTS as f64 {
                    return Err(format!("`{text}` has more than {MOST_POINTS} points"));
                }
                Ok(Self(
                    (0..=count as usize)
                        .map(|i| from + i as f64 * step)
                        .collect(),
                ))
            }
            _ => Err(format!(
                "`{text}` is neither a number nor A:B:STEP with a STEP from A to B"
            )),
        }
    }
}

/// One evaluated point.
#[derive(Clone, Copy, Debug, Serialize)]
struct Point {
    load_n: f64,
    slip_angle_rad: f64,
    camber_rad: f64,
    slip_ratio: f64,
    longitudinal_n: f64,
    lateral_n: f64,
    overturning_nm: f64,
    rolling_resistance_nm: f64,
    aligning_nm: f64,
}

const COLUMNS: [&str; 9] = [
    "load_n",
    "slip_angle_rad",
    "camber_rad",
    "slip_ratio",
    "longitudinal_n",
    "lateral_n",
    "overturning_nm",
    "rolling_resistance_nm",
    "aligning_nm",
];

impl Point {
    fn values(&self) -> [f64; 9] {
        [
            self.load_n,
            self.slip_angle_rad,
            self.camber_rad,
            self.slip_ratio,
            self.longitudinal_n,
            self.lateral_n,
            self.overturning_nm,
            self.rolling_resistance_nm,
            self.aligning_nm,
        ]
    }
}

#[derive(Serialize)]
struct Report<'a> {
    schema_version: u32,
    model: &'a str,
    set: &'a str,
    parameters: &'a Tyre,
    friction_ratio: f64,
    radius_m: f64,
    points: &'a [Point],
}

/// Runs `twinhub tyre`.
pub fn run(args: &TyreArgs) -> Result<ExitCode> {
    let found = set(&args.model).ok_or_else(|| {
        let sets: Vec<_> = SETS.iter().map(|set| set.name).collect();
        bad_input(anyhow!(
            "no tyre is called `{}`; models: {}; sets: {}",
            args.model,
            Tyre::NAMES.join(", "),
            sets.join(", ")
        ))
    })?;
    let tyre = with_changes(found.tyre, &args.set).map_err(bad_input)?;
    let points = sweep(&tyre, args).map_err(bad_input)?;
    if let Some(path) = &args.out {
        let picture = plot::picture(found.name, &points).map_err(bad_input)?;
        std::fs::write(path, picture)
            .with_context(|| format!("writing {}", path.display()))
            .map_err(environment)?;
    }
    if args.json {
        let report = Report {
            schema_version: 1,
            model: tyre.name(),
            set: found.name,
            parameters: &tyre,
            friction_ratio: args.friction,
            radius_m: args.radius_m,
            points: &points,
        };
        println!("{}", serde_json::to_string(&report)?);
    } else {
        print!("{}", table(&points));
    }
    Ok(ExitCode::SUCCESS)
}

/// `tyre` with every KEY=VALUE of `changes`; a dotted key reaches into a table.
fn with_changes(tyre: Tyre, changes: &[String]) -> Result<Tyre> {
    let name = tyre.name();
    let mut whole = toml::Table::try_from(tyre)?;
    for change in changes {
        let (key, text) = change
            .split_once('=')
            .ok_or_else(|| anyhow!("--set {change}: accepted: KEY=VALUE"))?;
        let value = toml::from_str::<toml::Table>(&format!("value = {text}"))
            .ok()
            .and_then(|mut table| table.remove("value"))
            .unwrap_or_else(|| toml::Value::String(text.to_string()));
        let mut place = whole
            .get_mut(name)
            .ok_or_else(|| anyhow!("--set {change}: {name} has no parameters"))?;
        let mut parts = key.split('.').peekable();
        while let Some(part) = parts.next() {
            let table = place
                .as_table_mut()
                .ok_or_else(|| anyhow!("--set {change}: `{part}` lies inside a plain value"))?;
            if parts.peek().is_none() {
                table.insert(part.to_string(), value);
                break;
            }
            place = table
                .get_mut(part)
                .ok_or_else(|| anyhow!("--set {change}: {name} has no table `{part}`"))?;
        }
    }
    let text = toml::to_string(&whole)?;
    let changed: Tyre =
        toml::from_str(&text).map_err(|error| anyhow!("--set on {name}: {}", error.message()))?;
    changed.validate()?;
    Ok(changed)
}

fn sweep(tyre: &Tyre, args: &TyreArgs) -> Result<Vec<Point>> {
    let positive = |name: &str, value: f64| {
        if value.is_finite() && value > 0.0 {
            Ok(())
        } else {
            Err(anyhow!(
                "{name} is {value}; accepted: finite and above zero"
            ))
        }
    };
    positive("--friction", args.friction)?;
    positive("--radius-m", args.radius_m)?;
    if !args.speed_m_s.is_finite() {
        return Err(anyhow!(
            "--speed-m-s is {}; accepted: finite",
            args.speed_m_s
        ));
    }
    let ranges = [
        &args.load_n,
        &args.camber_rad,
        &args.slip_ratio,
        &args.slip_angle_rad,
    ];
    let count = ranges
        .iter()
        .try_fold(1usize, |n, range| n.checked_mul(range.0.len()));
    if count.is_none_or(|count| count > MOST_POINTS) {
        return Err(anyhow!(
            "the sweeps multiply to more than {MOST_POINTS} points"
        ));
    }
    let mut points = Vec::with_capacity(count.unwrap_or(0));
    for &load_n in &args.load_n.0 {
        for &camber_rad in &args.camber_rad.0 {
            for &slip_ratio in &args.slip_ratio.0 {
                for &slip_angle_rad in &args.slip_angle_rad.0 {
                    let out = tyre.output(&TyreInput {
                        load_n,
                        slip_ratio,
                        slip_angle_rad,
                        camber_rad,
                        speed_m_s: args.speed_m_s,
                        friction_ratio: args.friction,
                        radius_m: args.radius_m,
                    });
                    points.push(Point {
                        load_n,
                        slip_angle_rad,
                        camber_rad,
                        slip_ratio,
                        longitudinal_n: out.longitudinal_n,
                        lateral_n: out.lateral_n,
                        overturning_nm: out.overturning_nm,
                        rolling_resistance_nm: out.rolling_resistance_nm,
                        aligning_nm: out.aligning_nm,
                    });
                }
            }
        }
    }
    Ok(points)
}

fn table(points: &[Point]) -> String {
    let mut text = String::new();
    for name in COLUMNS {
        let _ = write!(text, "{name:>width$}", width = name.len().max(9) + 2);
    }
    text.push('\n');
    for point in points {
        for (name, value) in COLUMNS.into_iter().zip(point.values()) {
            // + 0.0 turns -0 into 0
            let _ = write!(
                text,
                "{:>width$.4}",
                value + 0.0,
                width = name.len().max(9) + 2
            );
        }
        text.push('\n');
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    fn range(text: &str) -> Result<Range, String> {
        text.parse()
    }

    #[test]
    fn a_range_has_both_ends_and_nonsense_is_refused() {
        assert_eq!(range("0.3"), Ok(Range(vec![0.3])));
        assert_eq!(range("-0.2:0.2:0.1").unwrap().0.len(), 5);
        assert_eq!(range("3:1:-1").unwrap().0, [3.0, 2.0, 1.0]);
        for bad in [
            "", "a", "1:2", "1:2:0", "1:2:-1", "0:1:1e-9", "nan", "0:inf:1", "1:2:3:4",
        ] {
            assert!(range(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn changes_reach_every_kind_of_parameter() {
        let tyre = set("bulsink2017").unwrap().tyre;
        let change = |changes: &[&str]| {
            with_changes(
                tyre,
                &changes.iter().map(|c| c.to_string()).collect::<Vec<_>>(),
            )
        };
        let Tyre::MagicFormula(changed) = change(&[
            "twisting_gain=2",
            "combined=ellipse",
            "load_range_n=[200, 700]",
            "vertical.stiffness_n_m=1e5",
        ])
        .unwrap() else {
            panic!("another model")
        };
        assert_eq!(changed.twisting_gain, 2.0);
        assert_eq!(changed.combined, twinhub_plant::tyre::Combined::Ellipse);
        assert_eq!(changed.load_range_n, Some([200.0, 700.0]));
        assert_eq!(changed.vertical.stiffness_n_m, 1e5);
        for (bad, word) in [
            ("twisting_gian=2", "twisting_gian"),
            ("twisting_gain", "KEY=VALUE"),
            ("twisting_gain=-2", "0 to 1000"),
            ("combined=circle", "circle"),
            ("vertical.x.y=1", "x"),
            ("nominal_load_n.x=1", "plain value"),
        ] {
            let error = format!("{:#}", change(&[bad]).unwrap_err());
            assert!(error.contains(word), "{bad}: {error}");
        }
    }
}
