//! `twinhub modes`: eigenvalues over speed, weave and capsize speed, stable ranges, the picture.

use crate::exit::bad_input;
use anyhow::{Context, anyhow};
use serde_json::json;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use twinhub_linear::{Bicycle, Canonical, Mode, ModeName, Modes, MotorPair, Point, Verdict};
use twinhub_report::modes_picture::ModesPicture;

/// Most speeds in one request.
const MOST_SPEEDS: f64 = 100_000.0;
/// Most rows of the printed table.
const MOST_ROWS: usize = 26;
/// Speeds in the picture.
const PICTURE_SPEEDS: usize = 401;

/// Arguments of `twinhub modes`.
#[derive(clap::Args)]
pub struct ModesArgs {
    /// Built-in set, bicycle .toml, BicycleParameters *Benchmark.txt, or BICYCLE+RIDER
    #[arg(
        long,
        value_name = "NAME_OR_FILE",
        default_value = "meijaard2007_benchmark"
    )]
    bicycle: String,
    /// Front brake torque of the motor pair, N m; the rear motor balances it
    #[arg(
        long,
        value_name = "T",
        default_value_t = 0.0,
        allow_hyphen_values = true
    )]
    torque_nm: f64,
    /// Rear traction torque, N m, instead of the balancing one
    #[arg(long, value_name = "R", allow_hyphen_values = true)]
    rear_torque_nm: Option<f64>,
    /// Speeds from A to B by STEP, m/s
    #[arg(
        long,
        value_name = "A:B:STEP",
        default_value = "0:10:0.5",
        allow_hyphen_values = true
    )]
    speeds_m_s: String,
    /// Changes a parameter by its symbol (Meijaard et al. 2007, SI), for instance c=0.05
    #[arg(long = "set", value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// Prints the result as JSON
    #[arg(long)]
    json: bool,
    /// File for the picture, .svg or .html; by default modes_BICYCLE.svg, with --json none
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

/// Computes and prints the modes.
pub fn run(args: &ModesArgs) -> anyhow::Result<ExitCode> {
    let speeds = speeds(&args.speeds_m_s).map_err(bad_input)?;
    if let Some(out) = &args.out {
        is_page(out).map_err(bad_input)?;
    }
    let bicycle = Bicycle::load(&args.bicycle)
        .and_then(|b| b.with(&args.set))
        .map_err(bad_input)?;
    let equations = Canonical::new(&bicycle).map_err(bad_input)?;
    let pair = pair(args, &bicycle).map_err(bad_input)?;
    let modes = Modes::over(&equations, pair, &speeds);
    for remark in &bicycle.remarks {
        eprintln!("note: {remark}");
    }
    let out = args
        .out
        .clone()
        .or_else(|| (!args.json).then(|| default_picture(&bicycle.name)));
    if let Some(out) = &out {
        write_picture(out, &bicycle, &equations, pair, &speeds)?;
    }
    if args.json {
        println!(
            "{}",
            answer(args.torque_nm, &bicycle, &equations, pair, &modes)
        );
    } else {
        print_table(&modes);
        println!();
        println!("{}", sentence(&bicycle, pair, &modes));
        if let Some(out) = &out {
            println!("picture: {}", out.display());
        }
    }
    let acceleration = equations.longitudinal_accel_m_s2(pair);
    if acceleration != 0.0 {
        eprintln!(
            "note: this pair accelerates the bicycle by {acceleration:.3} m/s^2: modes of the moment at each speed"
        );
    }
    Ok(ExitCode::SUCCESS)
}

/// The speeds of `A:B:STEP`, both ends included where the step meets them.
fn speeds(text: &str) -> anyhow::Result<Vec<f64>> {
    let wrong = |why: &str| {
        anyhow!(
            "--speeds-m-s `{text}`: {why}; accepted: A:B:STEP with 0 <= A <= B and STEP > 0 in m/s, for instance 0:10:0.5"
        )
    };
    let numbers: Vec<f64> = text
        .split(':')
        .map(|s| s.trim().parse())
        .collect::<Result<_, _>>()
        .map_err(|_| wrong("not three numbers"))?;
    let [from, to, step] = numbers[..] else {
        return Err(wrong("not three numbers"));
    };
    if !numbers.iter().all(|v| v.is_finite()) {
        return Err(wrong("a number is not finite"));
    }
    if from < 0.0 || to < from || step <= 0.0 {
        return Err(wrong("out of range"));
    }
    let count = (to - from) / step + 1e-9;
    if count > MOST_SPEEDS {
        return Err(wrong("more than 100000 speeds"));
    }
    Ok((0..=count as usize)
        .map(|i| (from + i as f64 * step).min(to))
        .collect())
}

fn pair(args: &ModesArgs, bicycle: &Bicycle) -> anyhow::Result<MotorPair> {
    for (flag, torque) in [
        ("--torque-nm", Some(args.torque_nm)),
        ("--rear-torque-nm", args.rear_torque_nm),
    ] {
        if let Some(torque) = torque.filter(|t| !t.is_finite()) {
            return Err(anyhow!(
                "{flag} {torque}: accepted: a finite number of newton metres"
            ));
        }
    }
    let p = &bicycle.parameters;
    let wants = args.torque_nm != 0.0 && p.rF == 0.0
        || args.rear_torque_nm.unwrap_or(args.torque_nm) != 0.0 && p.rR == 0.0;
    if wants {
        return Err(anyhow!(
            "`{}` has a skate (wheel radius 0), which no motor can turn; accepted: --torque-nm 0",
            bicycle.name
        ));
    }
    let balanced = MotorPair::balanced(args.torque_nm, bicycle);
    Ok(MotorPair {
        rear_traction_nm: args.rear_torque_nm.unwrap_or(balanced.rear_traction_nm),
        ..balanced
    })
}

/// Whether the picture becomes a page (else an SVG), by the file's ending.
fn is_page(out: &Path) -> anyhow::Result<bool> {
    match out
        .extension()
        .and_then(|e| e.to_str())
        .map(str::to_ascii_lowercase)
        .as_deref()
    {
        Some("svg") => Ok(false),
        Some("html" | "htm") => Ok(true),
        _ => Err(anyhow!(
            "--out {}: accepted: a file ending in .svg or .html",
            out.display()
        )),
    }
}

/// `modes_NAME.svg` in the working folder.
fn default_picture(name: &str) -> PathBuf {
    let safe = |c: char| {
        if c.is_alphanumeric() || "_-+".contains(c) {
            c
        } else {
            '_'
        }
    };
    format!("modes_{}.svg", name.chars().map(safe).collect::<String>()).into()
}

fn write_picture(
    out: &Path,
    bicycle: &Bicycle,
    equations: &Canonical,
    pair: MotorPair,
    speeds: &[f64],
) -> anyhow::Result<()> {
    let (low, high) = (speeds[0], speeds[speeds.len() - 1]);
    let (low, high) = if high > low {
        (low, high)
    } else {
        ((low - 1.0).max(0.0), high + 1.0)
    };
    let fine: Vec<f64> = (0..PICTURE_SPEEDS)
        .map(|i| low + (high - low) * i as f64 / (PICTURE_SPEEDS - 1) as f64)
        .collect();
    let modes = Modes::over(equations, pair, &fine);
    let subtitle = format!("{}; no tyre slip", torques(pair));
    let picture = ModesPicture {
        title: &bicycle.name,
        subtitle: &subtitle,
        modes: &modes,
    };
    let page = is_page(out).map_err(bad_input)?;
    let text = if page { picture.html() } else { picture.svg() };
    std::fs::write(out, text)
        .with_context(|| format!("cannot write the picture {}", out.display()))
        .map_err(bad_input)
}

fn torques(pair: MotorPair) -> String {
    if pair == MotorPair::OFF {
        return "motors off".to_owned();
    }
    format!(
        "front brake {} Nm, rear traction {} Nm",
        trimmed(pair.front_brake_nm),
        trimmed(pair.rear_traction_nm)
    )
}

fn trimmed(value: f64) -> String {
    let text = format!("{value:.2}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

fn answer(
    torque_nm: f64,
    bicycle: &Bicycle,
    equations: &Canonical,
    pair: MotorPair,
    modes: &Modes,
) -> serde_json::Value {
    let points: Vec<_> = modes
        .points
        .iter()
        .map(|point| {
            let values: Vec<_> = point.modes.iter().map(|m| [m.pair.value.re, m.pair.value.im]).collect();
            let names: Vec<_> = point.modes.iter().map(|m| m.name.as_str()).collect();
            json!({ "speed_m_s": point.speed_m_s, "torque_nm": torque_nm, "eigenvalues": values, "modes": names })
        })
        .collect();
    json!({
        "schema_version": 1,
        "bicycle": bicycle.name,
        "source": bicycle.source,
        "remarks": bicycle.remarks,
        "front_brake_nm": pair.front_brake_nm,
        "rear_traction_nm": pair.rear_traction_nm,
        "longitudinal_accel_m_s2": equations.longitudinal_accel_m_s2(pair),
        "weave_speed_m_s": modes.weave_speed_m_s(),
        "capsize_speed_m_s": modes.capsize_speed_m_s(),
        "weave": modes.weave.as_str(),
        "capsize": modes.capsize.as_str(),
        "stable_ranges_m_s": modes.stable_ranges_m_s,
        "crossings": modes.criticals,
        "points": points,
    })
}

/// Whether the conjugate of a mode bears another name: two modes that swing as one.
fn shared(point: &Point, mode: &Mode) -> bool {
    let other = mode.pair.value.conj();
    mode.pair.value.im != 0.0
        && point
            .modes
            .iter()
            .any(|m| m.pair.value == other && m.name != mode.name)
}

/// One mode or, where it has split into two real ones, both. An oscillation that two modes share
/// stands with both.
fn cell(point: &Point, name: ModeName) -> String {
    let shown = |m: &&Mode| m.name == name && (m.pair.value.im >= 0.0 || shared(point, m));
    let one = |m: &Mode| {
        let s = m.pair.value;
        if s.im == 0.0 {
            format!("{:.3}", s.re)
        } else {
            format!("{:.3} \u{b1} {:.3}i", s.re, s.im.abs())
        }
    };
    let all: Vec<_> = point.modes.iter().filter(shown).map(one).collect();
    all.join(", ")
}

fn print_table(modes: &Modes) {
    let every = modes.points.len().div_ceil(MOST_ROWS);
    println!("  speed                  weave         capsize      caster   grows or decays");
    println!("    m/s             1/s, rad/s             1/s         1/s   e-fold in, s");
    for point in modes.points.iter().step_by(every) {
        let worst = point
            .modes
            .iter()
            .map(|m| m.pair.value.re)
            .fold(f64::NEG_INFINITY, f64::max);
        let time = if worst == 0.0 {
            "neither".to_owned()
        } else {
            format!(
                "{} {:.2}",
                if worst > 0.0 { "grows" } else { "decays" },
                1.0 / worst.abs()
            )
        };
        println!(
            "{:7.2} {:>22} {:>15} {:>11}   {time}",
            point.speed_m_s,
            cell(point, ModeName::Weave),
            cell(point, ModeName::Capsize),
            cell(point, ModeName::Caster),
        );
    }
    if modes
        .points
        .iter()
        .any(|p| p.modes.iter().any(|m| shared(p, m)))
    {
        eprintln!("note: an oscillation in two columns is one that both modes share at that speed");
    }
    if every > 1 {
        eprintln!(
            "note: one of {every} of the {} speeds is shown; --json has all",
            modes.points.len()
        );
    }
}

fn sentence(bicycle: &Bicycle, pair: MotorPair, modes: &Modes) -> String {
    let mode = |name: ModeName, verdict: Verdict, speed: Option<f64>| match (verdict, speed) {
        (Verdict::Crosses, Some(v)) => {
            let above = modes
                .criticals
                .iter()
                .find(|c| c.mode == name && c.speed_m_s == v)
                .is_some_and(|c| c.stable_above);
            format!(
                "{name} is {} above {v:.3} m/s",
                if above { "stable" } else { "unstable" }
            )
        }
        (Verdict::AlwaysUnstable, _) => format!("{name} is unstable throughout"),
        _ => format!("{name} is stable throughout"),
    };
    let ranges: Vec<_> = modes
        .stable_ranges_m_s
        .iter()
        .map(|[a, b]| format!("{a:.3} to {b:.3} m/s"))
        .collect();
    let stable = if ranges.is_empty() {
        "nowhere stable by itself in this range".to_owned()
    } else {
        format!("stable by itself from {}", ranges.join(" and from "))
    };
    format!(
        "{}, {}:\n{}; {};\n{stable}.",
        bicycle.name,
        torques(pair),
        mode(ModeName::Weave, modes.weave, modes.weave_speed_m_s()),
        mode(ModeName::Capsize, modes.capsize, modes.capsize_speed_m_s()),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn speeds_include_both_ends() {
        assert_eq!(speeds("0:1:0.25").unwrap(), [0.0, 0.25, 0.5, 0.75, 1.0]);
        assert_eq!(speeds("0:0.3:0.1").unwrap().len(), 4);
        assert_eq!(speeds("5:5:1").unwrap(), [5.0]);
        for bad in [
            "",
            "1:2",
            "a:b:c",
            "0:10:0",
            "3:1:0.1",
            "-1:2:1",
            "0:nan:1",
            "0:1e9:1e-3",
            "0:1:1:1",
        ] {
            let message = speeds(bad).unwrap_err().to_string();
            assert!(
                message.contains("A:B:STEP") && message.contains(bad),
                "{message}"
            );
        }
    }
}
