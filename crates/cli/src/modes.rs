//! `twinhub modes`: eigenvalues over speed, weave and capsize speed, stable ranges, the picture.

mod benchmark;
mod multibody;
mod print;
mod sensitivities;

use crate::exit::bad_input;
use anyhow::anyhow;
use std::path::PathBuf;
use std::process::ExitCode;
use twinhub_plant::bicycles::{self, Bicycle};

/// Most speeds in one request.
const MOST_SPEEDS: f64 = 100_000.0;

/// Arguments of `twinhub modes`.
#[derive(clap::Args)]
pub struct ModesArgs {
    /// A set that ships, with options as NAME:OPTION=VALUE (`twinhub list bicycles`), a bicycle or
    /// plant .toml, a BicycleParameters *Benchmark.txt, or BICYCLE+RIDER
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
    /// Steady turn with this roll angle instead of straight ahead, degrees (multibody only)
    #[arg(long, value_name = "DEG", allow_hyphen_values = true)]
    roll_deg: Option<f64>,
    /// Speeds from A to B by STEP, m/s; by default 0:10:0.5, multibody 0.5:10:0.5
    #[arg(long, value_name = "A:B:STEP", allow_hyphen_values = true)]
    speeds_m_s: Option<String>,
    /// Changes a parameter: a symbol of Meijaard et al. (2007) as c=0.05, or for a multibody
    /// bicycle a path of its file as tyre.front.twisting_gain=0.1 (`twinhub list parameters`)
    #[arg(long = "set", value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// Derivatives of weave speed and weave eigenvalue with respect to every parameter (multibody
    /// only)
    #[arg(long)]
    sensitivities: bool,
    /// Adds the shape of every mode to the JSON
    #[arg(long)]
    shapes: bool,
    /// Prints the result as JSON
    #[arg(long)]
    json: bool,
    /// File for the picture, .svg or .html; by default modes_BICYCLE.svg, with --json none
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

/// Computes and prints the modes.
pub fn run(args: &ModesArgs) -> anyhow::Result<ExitCode> {
    for (flag, number) in [
        ("--torque-nm", Some(args.torque_nm)),
        ("--rear-torque-nm", args.rear_torque_nm),
    ] {
        if let Some(number) = number.filter(|t| !t.is_finite()) {
            return Err(bad_input(anyhow!(
                "{flag} {number}: accepted: a finite number of newton metres"
            )));
        }
    }
    if let Some(out) = &args.out {
        print::is_page(out).map_err(bad_input)?;
    }
    match bicycles::load(&args.bicycle, &args.set).map_err(bad_input)? {
        Bicycle::Benchmark(bicycle) => benchmark::run(args, &bicycle),
        Bicycle::Multibody(parameters) => multibody::run(args, &parameters),
    }
}

impl ModesArgs {
    /// The speeds asked for, or those of `default`.
    fn speeds(&self, default: &str) -> anyhow::Result<Vec<f64>> {
        speeds(self.speeds_m_s.as_deref().unwrap_or(default))
    }

    /// The file for the picture, if there is to be one.
    fn picture(&self, name: &str) -> Option<PathBuf> {
        self.out
            .clone()
            .or_else(|| (!self.json).then(|| print::default_picture(name)))
    }
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
