//! `twinhub design`: schedules with their proof.

use crate::design_print::{page, print, to_json};
use crate::exit::{bad_input, environment, interrupted};
use crate::interrupt::on_ctrl_c;
use crate::span::numbers;
use anyhow::anyhow;
use clap::Args;
use indicatif::{ProgressBar, ProgressStyle};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::atomic::Ordering;
use twinhub_design::certificate::{Entry, Plan};
use twinhub_design::family::FactorBox;
use twinhub_design::loops::Rider;
use twinhub_design::plan::{Progress, run as design};
use twinhub_design::program::Cones;
use twinhub_design::{DesignError, law};
use twinhub_plant::bicycles::load_multibody;
use twinhub_plant::multibody::Parameters;
use twinhub_plant::rider::design::Hands;
use twinhub_plant::rider::presets::{PRESETS, preset};
use twinhub_report::design::design_page;

/// Widest box of mass and of tyre load that is tried for a quick rider.
const BOX_WIDTH: f64 = 0.1;
/// Largest ratio of twisting torque in a box that is tried for a quick rider.
const BOX_RATIO: f64 = 1.26;
/// Riders with a longer delay get boxes half as large, s.
const QUICK_DELAY_S: f64 = 0.15;

/// The schedule of a pair for a bicycle, with a certificate: riders who are used to it stay up at
/// every speed and pair of a tube, whatever mass, tyre load and twisting torque are within what is
/// declared, and survive its sudden loss. Where that cannot be proved the schedule is zero, and what
/// stops it is said.
#[derive(Args, Debug)]
pub struct DesignArgs {
    /// A multibody bicycle that ships, with options as NAME:OPTION=VALUE, or its file
    #[arg(long, value_name = "NAME_OR_FILE", default_value = twinhub_plant::rider::presets::BICYCLE)]
    bicycle: String,
    /// Riders who give torque: young, older; or NAME:DELAY_S
    #[arg(
        long,
        value_name = "RIDER,..",
        value_delimiter = ',',
        default_value = "young"
    )]
    riders: Vec<String>,
    /// Share by which the rider's mass may differ
    #[arg(long, value_name = "SHARE", default_value_t = 0.1)]
    mass: f64,
    /// Share by which side forces and moments of the tyres may differ
    #[arg(long, value_name = "SHARE", default_value_t = 0.1)]
    load: f64,
    /// Factors between which the twisting torque of the tyres may lie
    #[arg(long, value_name = "A:B", default_value = "0.5:2")]
    twisting: String,
    /// Boxes that mass, load and twisting torque are cut into; a rider is used to the bicycles of a
    /// box [default: as many as usually can be proved]
    #[arg(long, value_name = "MASS,LOAD,TWISTING")]
    boxes: Option<String>,
    /// Speeds from A to B by STEP, m/s; the schedule is zero at both ends
    #[arg(long, value_name = "A:B:STEP", default_value = "3:7.5:0.25")]
    speeds_m_s: String,
    /// Largest pair, Nm
    #[arg(long, value_name = "NM", default_value_t = 40.0)]
    torque_nm: f64,
    /// Half the width of the tube, Nm
    #[arg(long, value_name = "NM", default_value_t = 5.0)]
    half_width_nm: f64,
    /// Fastest change of speed, m/s²
    #[arg(long, value_name = "M_S2", default_value_t = 0.3)]
    rate_m_s2: f64,
    /// Steepest schedule, Nm per m/s
    #[arg(long, value_name = "NM", default_value_t = 30.0)]
    slope: f64,
    /// Largest growth rate after the pair is lost at once, 1/s
    #[arg(long, value_name = "PER_S", default_value_t = 0.7)]
    loss_growth_per_s: f64,
    /// Least friction of the road that has to carry the pair
    #[arg(long, value_name = "RATIO", default_value_t = 0.6)]
    friction: f64,
    /// The joints of the rider move; by default the rider's body is one with the frame (many times
    /// quicker)
    #[arg(long)]
    free_joints: bool,
    /// What matrices are held positive by: dominant (second-order cones), or semidefinite in a build with
    /// the feature `sdp`
    #[arg(long, value_name = "CONES", default_value = "dominant")]
    cones: String,
    /// Where to write the law file; the proof goes beside it, as .certificate.json
    #[arg(long, value_name = "FILE.toml")]
    out: Option<PathBuf>,
    /// Where to write the page with the pictures
    #[arg(long, value_name = "FILE.html")]
    report: Option<PathBuf>,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// Runs `twinhub design`.
///
/// # Errors
/// If an argument is wrong (2), a file cannot be written (3), or the user stops it (130).
pub fn run(args: &DesignArgs) -> anyhow::Result<ExitCode> {
    let plan = plan(args).map_err(bad_input)?;
    let parameters = bicycle(&plan.bicycle)?;
    let stop = on_ctrl_c()?;
    let bar = ProgressBar::new(0);
    bar.set_style(
        ProgressStyle::with_template("{msg} {bar:40} {pos}/{len}  {elapsed}")
            .unwrap_or_else(|_| ProgressStyle::default_bar()),
    );
    let watch = |progress: Progress| {
        if progress.of > 0 {
            bar.set_message(progress.doing);
            bar.set_length(progress.of as u64);
            bar.set_position(progress.done as u64);
        }
        !stop.load(Ordering::Relaxed)
    };
    let certificate = design(&plan, &parameters, &watch).map_err(kind)?;
    bar.finish_and_clear();
    if let Some(out) = &args.out {
        let text = law::file(&certificate, &told(&parameters)).map_err(kind)?;
        let proof = serde_json::to_string(&certificate)?;
        let beside = beside(out);
        std::fs::write(&beside, proof)
            .map_err(|e| environment(anyhow!("{}: {e}", beside.display())))?;
        std::fs::write(out, text).map_err(|e| environment(anyhow!("{}: {e}", out.display())))?;
    }
    if let Some(path) = &args.report {
        std::fs::write(path, design_page(&page(&certificate)))
            .map_err(|e| environment(anyhow!("{}: {e}", path.display())))?;
    }
    if args.json {
        println!("{}", serde_json::to_string_pretty(&to_json(&certificate))?);
    } else {
        print(&certificate);
        if let Some(out) = &args.out {
            println!(
                "\n{} is the law, {} its proof: twinhub certify {}",
                out.display(),
                beside(out).display(),
                out.display()
            );
        }
    }
    Ok(ExitCode::SUCCESS)
}

/// The exit code of a design's error.
pub fn kind(error: DesignError) -> anyhow::Error {
    match error {
        DesignError::Stopped => interrupted(anyhow!("stopped; nothing was written")),
        other => bad_input(other),
    }
}

/// The multibody bicycle of that name or file.
pub fn bicycle(name: &str) -> anyhow::Result<Parameters> {
    let none: [&str; 0] = [];
    load_multibody(name, &none).map_err(bad_input)
}

/// The bicycle as the bench tells the controller.
pub fn told(parameters: &Parameters) -> twinhub_control::Bicycle {
    twinhub_sim::bicycle::ResolvedBicycle::multibody(parameters.clone()).control()
}

/// `law.toml` to `law.certificate.json`.
pub fn beside(law: &Path) -> PathBuf {
    law.with_extension("certificate.json")
}

fn plan(args: &DesignArgs) -> anyhow::Result<Plan> {
    let pair = |flag: &str, text: &str| -> anyhow::Result<[f64; 2]> {
        let parts: Vec<f64> = text
            .split(':')
            .filter_map(|p| p.trim().parse().ok())
            .collect();
        match parts[..] {
            [a, b] if text.matches(':').count() == 1 => Ok([a, b]),
            _ => Err(anyhow!(
                "{flag} `{text}`: accepted: A:B, for instance 0.5:2"
            )),
        }
    };
    let around = |flag: &str, share: f64| {
        if (0.0..=0.9).contains(&share) {
            Ok([1.0 - share, 1.0 + share])
        } else {
            Err(anyhow!("{flag} {share}: accepted: 0 to 0.9"))
        }
    };
    let uncertainty = FactorBox {
        mass: around("--mass", args.mass)?,
        load: around("--load", args.load)?,
        twisting: pair("--twisting", &args.twisting)?,
    };
    let boxes = args.boxes.as_deref().map(parts).transpose()?;
    let riders: anyhow::Result<Vec<Entry>> = args
        .riders
        .iter()
        .map(|text| {
            let rider = rider(text)?;
            let parts = boxes.unwrap_or_else(|| usual(&uncertainty, &rider));
            Ok(Entry { rider, parts })
        })
        .collect();
    let plan = Plan {
        bicycle: args.bicycle.clone(),
        joints_free: args.free_joints,
        riders: riders?,
        uncertainty,
        speeds_m_s: numbers("--speeds-m-s", &args.speeds_m_s, "m/s", 0.5)?,
        torque_max_nm: args.torque_nm,
        half_width_nm: args.half_width_nm,
        rate_m_s2: args.rate_m_s2,
        slope_nm_per_m_s: args.slope,
        loss_growth_per_s: args.loss_growth_per_s,
        friction_ratio: args.friction,
        cones: cones(&args.cones)?,
    };
    plan.check()?;
    plan.cones.check()?;
    Ok(plan)
}

fn cones(text: &str) -> anyhow::Result<Cones> {
    match text {
        "dominant" => Ok(Cones::Dominant),
        "semidefinite" => Ok(Cones::Semidefinite),
        _ => Err(anyhow!(
            "--cones `{text}`; accepted: dominant, semidefinite"
        )),
    }
}

fn parts(text: &str) -> anyhow::Result<[usize; 3]> {
    let parts: Vec<usize> = text
        .split(',')
        .filter_map(|p| p.trim().parse().ok())
        .collect();
    match parts[..] {
        [a, b, c] if a * b * c > 0 && text.matches(',').count() == 2 => Ok([a, b, c]),
        _ => Err(anyhow!(
            "--boxes `{text}`: accepted: three numbers above 0, for instance 2,2,6"
        )),
    }
}

/// Boxes of a size that can be proved as a rule.
fn usual(uncertainty: &FactorBox, rider: &Rider) -> [usize; 3] {
    let finer = if rider.delay_s <= QUICK_DELAY_S {
        1.0
    } else {
        2.0
    };
    let even = |[a, b]: [f64; 2]| ((b - a) / BOX_WIDTH * finer - 1e-9).ceil().max(1.0) as usize;
    let [a, b] = uncertainty.twisting;
    let ratio = ((b / a).ln() / BOX_RATIO.ln() * finer - 1e-9)
        .ceil()
        .max(1.0) as usize;
    [even(uncertainty.mass), even(uncertainty.load), ratio]
}

fn rider(text: &str) -> anyhow::Result<Rider> {
    let names = || {
        PRESETS
            .iter()
            .filter(|p| p.arms.is_none())
            .map(|p| p.name)
            .collect::<Vec<_>>()
            .join(", ")
    };
    let of = |name: &str, delay_s: Option<f64>| -> Option<Rider> {
        let preset = preset(name).filter(|p| p.arms.is_none())?;
        let Hands::Torque { channel, .. } = preset.hands() else {
            return None;
        };
        Some(Rider {
            name: text.to_owned(),
            delay_s: delay_s.unwrap_or(channel.delay_s),
            lag_rad_s: channel.neuromuscular_rad_s,
            lag_damping_ratio: channel.neuromuscular_damping_ratio,
        })
    };
    let found = match text.split_once(':') {
        None => of(text, None),
        // Another delay, the muscles of everybody.
        Some((_, delay)) => match delay.parse::<f64>() {
            Ok(delay_s) => of("young", Some(delay_s)),
            Err(_) => None,
        },
    };
    found.ok_or_else(|| {
        anyhow!(
            "rider `{text}`: accepted: {}, or NAME:DELAY_S as somebody:0.15",
            names()
        )
    })
}
