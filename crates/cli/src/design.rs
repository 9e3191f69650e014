//! `twinhub design`: schedules with their proof.

use crate::design_print::{page, print};
use crate::exit::{bad_input, environment, interrupted};
use crate::interrupt::on_ctrl_c;
use crate::span::numbers;
use anyhow::anyhow;
use clap::Args;
use indicatif::{ProgressBar, ProgressStyle};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::atomic::Ordering;
use twinhub_design::ask::Ask;
use twinhub_design::plan::{Progress, run as design};
use twinhub_design::program::Cones;
use twinhub_design::summary::summary;
use twinhub_design::{DesignError, law};
use twinhub_plant::bicycles::load_multibody;
use twinhub_plant::multibody::Parameters;
use twinhub_report::design::design_page;

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
    let plan = ask(args).map_err(bad_input)?.plan().map_err(kind)?;
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
        println!("{}", serde_json::to_string_pretty(&summary(&certificate))?);
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

fn ask(args: &DesignArgs) -> anyhow::Result<Ask> {
    let twisting: Vec<f64> = (args.twisting.split(':'))
        .filter_map(|p| p.trim().parse().ok())
        .collect();
    let [from, to] = twisting[..] else {
        return Err(anyhow!(
            "--twisting `{}`: accepted: A:B, for instance 0.5:2",
            args.twisting
        ));
    };
    Ok(Ask {
        bicycle: args.bicycle.clone(),
        riders: args.riders.clone(),
        mass: args.mass,
        load: args.load,
        twisting: [from, to],
        boxes: args.boxes.as_deref().map(parts).transpose()?,
        speeds_m_s: numbers("--speeds-m-s", &args.speeds_m_s, "m/s", 0.5)?,
        torque_nm: args.torque_nm,
        half_width_nm: args.half_width_nm,
        rate_m_s2: args.rate_m_s2,
        slope_nm_per_m_s: args.slope,
        loss_growth_per_s: args.loss_growth_per_s,
        friction: args.friction,
        free_joints: args.free_joints,
        cones: cones(&args.cones)?,
    })
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
