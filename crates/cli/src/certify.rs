//! `twinhub certify`: a schedule's proof, checked.

use crate::design::{beside, bicycle, kind, told};
use crate::exit::{self, bad_input};
use crate::interrupt::on_ctrl_c;
use anyhow::anyhow;
use clap::Args;
use indicatif::ProgressBar;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::atomic::Ordering;
use twinhub_control::Config;
use twinhub_design::certificate::Certificate;
use twinhub_design::{check, law};

/// Checks a certificate without a solver, with a bound on every rounding.
#[derive(Args, Debug)]
pub struct CertifyArgs {
    /// A law file of `twinhub design` with its proof beside it, or the proof itself
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// Runs `twinhub certify`: exit code 1 if the certificate does not hold.
///
/// # Errors
/// If the file is none (2), or the user stops it (130).
pub fn run(args: &CertifyArgs) -> anyhow::Result<ExitCode> {
    let is_law = args.file.extension().is_some_and(|e| e == "toml");
    let path = if is_law {
        beside(&args.file)
    } else {
        args.file.clone()
    };
    let read = |path: &Path| {
        std::fs::read_to_string(path).map_err(|e| {
            bad_input(anyhow!(
                "{}: {e}; accepted: a law file of `twinhub design --out` with its proof beside it, or the proof",
                path.display()
            ))
        })
    };
    let certificate: Certificate = serde_json::from_str(&read(&path)?).map_err(|e| {
        bad_input(anyhow!(
            "{}: {e}; accepted: a proof of `twinhub design`",
            path.display()
        ))
    })?;
    let parameters = bicycle(&certificate.plan.bicycle)?;
    let stop = on_ctrl_c()?;
    let bar = ProgressBar::new(certificate.pieces.len() as u64);
    let mut checked = check::check(&certificate, &parameters, &|done, _| {
        bar.set_position(done as u64);
        !stop.load(Ordering::Relaxed)
    })
    .map_err(kind)?;
    bar.finish_and_clear();
    if is_law && checked.holds {
        let config: Config = toml::from_str(&read(&args.file)?)
            .map_err(|e| bad_input(anyhow!("{}: {e}", args.file.display())))?;
        let proved = law::config(&certificate, &told(&parameters)).map_err(kind)?;
        let broken = config.check().err().map(|e| e.to_string());
        let same = config.certificate == proved.certificate && config.bicycle == proved.bicycle;
        let moved = (!same).then(|| "tube or bicycle are not those of the proof".to_owned());
        for wrong in broken.into_iter().chain(moved) {
            checked
                .wrong
                .push(format!("{}: {wrong}", args.file.display()));
        }
        checked.holds = checked.wrong.is_empty();
    }
    let schedule = &certificate.schedule;
    if args.json {
        let column = |value: fn(&twinhub_design::certificate::Point) -> f64| -> Vec<f64> {
            schedule.iter().map(value).collect()
        };
        let json = serde_json::json!({
            "verdict": if checked.holds { "holds" } else { "fails" },
            "speeds_m_s": column(|p| p.speed_m_s),
            "torque_nm": column(|p| p.torque_nm),
            "from_nm": column(|p| p.from_nm),
            "to_nm": column(|p| p.to_nm),
            "proved_m_s": checked.proved_m_s,
            "wrong": checked.wrong,
            "inequalities": checked.inequalities,
            "interpolation_ratio": checked.interpolation_ratio,
        });
        println!("{}", serde_json::to_string_pretty(&json)?);
    } else if checked.holds {
        println!(
            "holds: {} inequalities, proved {}",
            checked.inequalities,
            check::in_words(&checked.proved_m_s)
        );
        println!(
            "  for {} ({} riders and boxes); between corners and nodes the bicycle is within {:.1e} of what was proved",
            certificate.plan.bicycle,
            certificate.pieces.len(),
            checked.interpolation_ratio
        );
    } else {
        println!("fails");
        for wrong in &checked.wrong {
            println!("  {wrong}");
        }
    }
    Ok(if checked.holds {
        ExitCode::SUCCESS
    } else {
        ExitCode::from(exit::FELL)
    })
}
