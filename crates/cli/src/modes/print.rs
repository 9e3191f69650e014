//! What all bicycles' modes are printed with.

use crate::exit::bad_input;
use anyhow::{Context, anyhow};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use twinhub_linear::{Mode, ModeName, Modes, Point, Verdict};
use twinhub_plant::multibody::dominant_state;
use twinhub_report::modes_picture::ModesPicture;

/// Most rows of the printed table.
const MOST_ROWS: usize = 26;
/// Speeds in the picture.
const PICTURE_SPEEDS: usize = 401;

/// Whether the picture becomes a page (else an SVG), by the file's ending.
pub fn is_page(out: &Path) -> anyhow::Result<bool> {
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

/// `WHAT_NAME.svg` in the working folder.
pub fn picture_name(what: &str, name: &str) -> PathBuf {
    let safe = |c: char| {
        if c.is_alphanumeric() || "_-+".contains(c) {
            c
        } else {
            '_'
        }
    };
    format!("{what}_{}.svg", name.chars().map(safe).collect::<String>()).into()
}

/// Speeds of the picture: close to each other, over the range of `speeds`, from `least` up.
pub fn fine_speeds(speeds: &[f64], least: f64) -> Vec<f64> {
    let (low, high) = (speeds[0], speeds[speeds.len() - 1]);
    let (low, high) = if high > low {
        (low, high)
    } else {
        (low - 1.0, high + 1.0)
    };
    let low = low.max(least);
    (0..PICTURE_SPEEDS)
        .map(|i| low + (high - low) * i as f64 / (PICTURE_SPEEDS - 1) as f64)
        .collect()
}

/// Writes the picture.
pub fn write_picture(out: &Path, title: &str, subtitle: &str, fine: &Modes) -> anyhow::Result<()> {
    let picture = ModesPicture {
        title,
        subtitle,
        modes: fine,
    };
    let page = is_page(out).map_err(bad_input)?;
    let text = if page { picture.html() } else { picture.svg() };
    std::fs::write(out, text)
        .with_context(|| format!("cannot write the picture {}", out.display()))
        .map_err(bad_input)
}

/// Two decimals at most.
pub fn trimmed(value: f64) -> String {
    let text = format!("{value:.2}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// What every answer has.
pub fn answer(name: &str, source: &str, modes: &Modes) -> Value {
    json!({
        "schema_version": 1,
        "bicycle": name,
        "source": source,
        "weave_speed_m_s": modes.weave_speed_m_s(),
        "capsize_speed_m_s": modes.capsize_speed_m_s(),
        "weave": modes.weave.as_str(),
        "capsize": modes.capsize.as_str(),
        "stable_ranges_m_s": modes.stable_ranges_m_s,
        "crossings": modes.criticals,
    })
}

/// One speed.
pub fn point(point: &Point, torque_nm: f64, states: &[&'static str], shapes: bool) -> Value {
    let modes = || point.modes.iter();
    let values: Vec<_> = modes()
        .map(|m| [m.pair.value.re, m.pair.value.im])
        .collect();
    let names: Vec<_> = modes().map(|m| m.name.as_str()).collect();
    let dominant: Vec<_> = modes().map(|m| dominant_state(&m.pair, states)).collect();
    let mut answer = json!({
        "speed_m_s": point.speed_m_s,
        "torque_nm": torque_nm,
        "eigenvalues": values,
        "modes": names,
        "dominant_states": dominant,
    });
    if shapes {
        let shape = |m: &Mode| -> Value { m.pair.shape.iter().map(|z| [z.re, z.im]).collect() };
        answer["shapes"] = modes().map(shape).collect();
    }
    answer
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

/// The table of a terminal.
pub fn table(modes: &Modes, states: &[&'static str]) {
    let every = modes.points.len().div_ceil(MOST_ROWS);
    println!("  speed                  weave         capsize      caster   grows or decays");
    println!("    m/s             1/s, rad/s             1/s         1/s   e-fold in, s");
    for point in modes.points.iter().step_by(every) {
        let worst = point
            .modes
            .iter()
            .max_by(|a, b| a.pair.value.re.total_cmp(&b.pair.value.re));
        let time = worst.map_or_else(
            || "no steady state".to_owned(),
            |mode| {
                let growth = mode.pair.value.re;
                // A mode without a column is told by what moves most in it.
                let which = match mode.name {
                    ModeName::Other => format!(" ({})", dominant_state(&mode.pair, states)),
                    _ => String::new(),
                };
                if growth == 0.0 {
                    return format!("neither{which}");
                }
                let verb = if growth > 0.0 { "grows" } else { "decays" };
                format!("{verb} {:.2}{which}", 1.0 / growth.abs())
            },
        );
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

/// The result in words.
pub fn sentence(bicycle: &str, torques: &str, modes: &Modes) -> String {
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
        bicycle,
        torques,
        mode(ModeName::Weave, modes.weave, modes.weave_speed_m_s()),
        mode(ModeName::Capsize, modes.capsize, modes.capsize_speed_m_s()),
    )
}
