//! `twinhub rider`: does a rider keep a bicycle up, which gains do, and riders made for it.

use crate::exit::bad_input;
use anyhow::{Context, anyhow};
use clap::{Args, Subcommand};
use serde_json::json;
use std::path::PathBuf;
use std::process::ExitCode;
use twinhub_plant::bicycles;
use twinhub_plant::multibody::Multibody;
use twinhub_plant::rider::LateralBicycle;
use twinhub_plant::rider::closed_loop::{StabilityAt, stability};
use twinhub_plant::rider::design::{Goal, Hands, design};
use twinhub_plant::rider::presets::{BICYCLE, PRESETS, preset};
use twinhub_plant::rider::windows::windows;

/// Arguments of `twinhub rider`.
#[derive(Args)]
pub struct RiderArgs {
    #[command(subcommand)]
    what: What,
}

#[derive(Subcommand)]
enum What {
    /// Growth rate of the closed loop over speed: negative keeps the bicycle up
    Check(CheckArgs),
    /// Proportional gains of a torque rider that keep the bicycle up, by speed, delay and pair
    Windows(WindowsArgs),
    /// Gains that keep the bicycle up without and with the pair; prints the rider file
    Design(DesignArgs),
}

/// The bicycle, for all of them.
#[derive(Args)]
struct BicycleChoice {
    /// A multibody set that ships (`twinhub list bicycles`), or a file
    #[arg(long, value_name = "NAME_OR_FILE", default_value = BICYCLE)]
    bicycle: String,
    /// Changes a parameter, as tyre.front.twisting_gain=0.1
    #[arg(long = "set", value_name = "KEY=VALUE")]
    set: Vec<String>,
}

#[derive(Args)]
struct CheckArgs {
    /// A rider that ships (`twinhub list riders`), or a rider file
    rider: String,
    #[command(flatten)]
    bicycle: BicycleChoice,
    /// Speeds from A to B by STEP, m/s
    #[arg(long, value_name = "A:B:STEP", default_value = "3:8:0.5")]
    speeds_m_s: String,
    /// Pairs of motor torques, Nm
    #[arg(
        long,
        value_name = "T,T,..",
        value_delimiter = ',',
        default_value = "0,20,40"
    )]
    pairs_nm: Vec<f64>,
    /// Prints the result as JSON
    #[arg(long)]
    json: bool,
}

#[derive(Args)]
struct WindowsArgs {
    #[command(flatten)]
    bicycle: BicycleChoice,
    /// Speeds from A to B by STEP, m/s
    #[arg(long, value_name = "A:B:STEP", default_value = "3:7:1")]
    speeds_m_s: String,
    /// Delays of the rider, s
    #[arg(
        long,
        value_name = "S,S,..",
        value_delimiter = ',',
        default_value = "0.12,0.21"
    )]
    delays_s: Vec<f64>,
    /// Pairs of motor torques, Nm
    #[arg(
        long,
        value_name = "T,T,..",
        value_delimiter = ',',
        default_value = "0,20,40,80"
    )]
    pairs_nm: Vec<f64>,
    /// Smallest proportional gain looked at, Nm/rad; positive steers out of the lean
    #[arg(long, default_value_t = -10.0, allow_hyphen_values = true)]
    from_nm_rad: f64,
    /// Largest proportional gain looked at, Nm/rad
    #[arg(long, default_value_t = 40.0)]
    to_nm_rad: f64,
    /// Prints the result as JSON
    #[arg(long)]
    json: bool,
}

#[derive(Args)]
struct DesignArgs {
    /// The kind of rider: young, older, young_firm or older_firm
    #[arg(default_value = "older")]
    like: String,
    #[command(flatten)]
    bicycle: BicycleChoice,
    /// Another delay, s
    #[arg(long)]
    delay_s: Option<f64>,
    /// Speeds of the gain table from A to B by STEP, m/s
    #[arg(long, value_name = "A:B:STEP")]
    speeds_m_s: Option<String>,
    /// Pairs with which the same gains have to ride, Nm
    #[arg(long, value_name = "T,T,..", value_delimiter = ',')]
    pairs_nm: Vec<f64>,
    /// Roll alone is fed back to torque, not steer
    #[arg(long)]
    roll_only: bool,
    /// Write the rider file here instead of to standard output
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Prints the rider and the growth rates as JSON
    #[arg(long)]
    json: bool,
}

/// Runs the command.
///
/// # Errors
/// Bad input.
pub fn run(args: &RiderArgs) -> anyhow::Result<ExitCode> {
    match &args.what {
        What::Check(args) => check(args),
        What::Windows(args) => print_windows(args),
        What::Design(args) => print_design(args),
    }
    .map(|()| ExitCode::SUCCESS)
}

impl BicycleChoice {
    fn model(&self) -> anyhow::Result<Multibody> {
        let parameters = bicycles::load_multibody(&self.bicycle, &self.set).map_err(bad_input)?;
        Multibody::new(&parameters).map_err(bad_input)
    }
}

fn check(args: &CheckArgs) -> anyhow::Result<()> {
    let model = args.bicycle.model()?;
    let speeds =
        crate::span::numbers("--speeds-m-s", &args.speeds_m_s, "m/s", 0.1).map_err(bad_input)?;
    let rider = twinhub_sim::setup::load_rider(&args.rider).map_err(bad_input)?;
    let joints = &model.parameters().joints;
    rider
        .fits(twinhub_plant::rider::Limbs {
            trunk: joints.trunk_lean.free,
            legs: joints.legs.free,
        })
        .map_err(bad_input)?;
    let mut all = Vec::new();
    for &pair_nm in &args.pairs_nm {
        all.push(stability(&model, &rider, pair_nm, &speeds).map_err(bad_input)?);
    }
    if args.json {
        let points: Vec<_> = all.iter().flatten().map(point).collect();
        let answer = json!({
            "schema_version": 1,
            "rider": args.rider,
            "bicycle": args.bicycle.bicycle,
            "stays_up": all.iter().flatten().all(StabilityAt::is_stable),
            "points": points,
        });
        println!("{}", serde_json::to_string_pretty(&answer)?);
        return Ok(());
    }
    println!("growth rate, 1/s (negative: stays up), and swing, rad/s");
    print_growth(&speeds, &args.pairs_nm, &all);
    Ok(())
}

/// Whether a rider that ships keeps the reference bicycle up, computed.
pub fn growth_in_words(name: &str) -> Option<String> {
    let rider = twinhub_sim::setup::load_rider(name).ok()?;
    let none: [&str; 0] = [];
    let model = Multibody::new(&bicycles::load_multibody(BICYCLE, &none).ok()?).ok()?;
    let speeds: Vec<f64> = (3..=8).map(f64::from).collect();
    let mut text =
        format!("Growth rate of the closed loop on {BICYCLE}, 1/s (negative: stays up):");
    for pair_nm in [0.0, 40.0] {
        let at = stability(&model, &rider, pair_nm, &speeds).ok()?;
        let words: Vec<String> = at
            .iter()
            .map(|s| format!("{:+.2} at {} m/s", s.growth_per_s, s.speed_m_s))
            .collect();
        text += &format!("\n  {pair_nm:>2} Nm: {}", words.join(", "));
    }
    Some(text)
}

fn point(at: &StabilityAt) -> serde_json::Value {
    json!({
        "speed_m_s": at.speed_m_s,
        "pair_nm": at.pair_nm,
        "growth_per_s": at.growth_per_s,
        "frequency_rad_s": at.frequency_rad_s,
        "stays_up": at.is_stable(),
    })
}

/// A row for each speed, a column for each pair.
fn print_growth(speeds: &[f64], pairs: &[f64], columns: &[Vec<StabilityAt>]) {
    print!("{:>8}", "m/s");
    for pair in pairs {
        print!("{:>18}", format!("{pair} Nm"));
    }
    println!();
    for (i, speed) in speeds.iter().enumerate() {
        print!("{speed:>8.2}");
        for column in columns {
            let at = &column[i];
            let cell = format!("{:+.2} at {:.1}", at.growth_per_s, at.frequency_rad_s);
            print!("{cell:>18}");
        }
        println!();
    }
}

fn print_windows(args: &WindowsArgs) -> anyhow::Result<()> {
    let model = args.bicycle.model()?;
    let speeds =
        crate::span::numbers("--speeds-m-s", &args.speeds_m_s, "m/s", 0.1).map_err(bad_input)?;
    let (from, to) = (args.from_nm_rad, args.to_nm_rad);
    if !(from < to && from >= -1000.0 && to <= 1000.0) {
        return Err(bad_input(anyhow!(
            "--from-nm-rad {from} --to-nm-rad {to}: accepted: rising, -1000 to 1000 Nm/rad"
        )));
    }
    if let Some(delay) = args.delays_s.iter().find(|d| !(**d >= 0.0 && **d <= 1.0)) {
        return Err(bad_input(anyhow!("--delays-s {delay}: accepted: 0 to 1 s")));
    }
    let mut cells = Vec::new();
    if !args.json {
        print!("{:>6} {:>7}", "m/s", "delay");
        for pair in &args.pairs_nm {
            print!("{:>18}", format!("{pair} Nm"));
        }
        println!();
    }
    for &speed_m_s in &speeds {
        for &delay_s in &args.delays_s {
            let mut row = format!("{speed_m_s:>6} {:>7}", format!("{delay_s} s"));
            for &pair_nm in &args.pairs_nm {
                let at = LateralBicycle::new(&model, speed_m_s, pair_nm).map_err(bad_input)?;
                let found = windows(&at, delay_s, from, to);
                let words: Vec<String> = found
                    .iter()
                    .map(|w| format!("{:.1} to {:.1}", w.from_nm_rad, w.to_nm_rad))
                    .collect();
                let words = if words.is_empty() {
                    "none".to_owned()
                } else {
                    words.join(", ")
                };
                row += &format!("{words:>18}");
                let windows: Vec<_> = found.iter().map(|w| [w.from_nm_rad, w.to_nm_rad]).collect();
                cells.push(json!({
                    "speed_m_s": speed_m_s,
                    "delay_s": delay_s,
                    "pair_nm": pair_nm,
                    "windows_nm_rad": windows,
                }));
            }
            if !args.json {
                println!("{row}");
            }
        }
    }
    if args.json {
        let answer = json!({
            "schema_version": 1,
            "bicycle": args.bicycle.bicycle,
            "cells": cells,
        });
        println!("{}", serde_json::to_string_pretty(&answer)?);
    } else {
        println!(
            "k_p in Nm/rad of T = -k_p roll(t - delay) - k_d roll rate(t - delay), any k_d; k_p > 0 \
             steers out of the lean"
        );
    }
    Ok(())
}

fn print_design(args: &DesignArgs) -> anyhow::Result<()> {
    let model = args.bicycle.model()?;
    let mut like = preset(&args.like).ok_or_else(|| {
        let names: Vec<&str> = PRESETS.iter().map(|p| p.name).collect();
        bad_input(anyhow!(
            "no rider to design like `{}`; accepted: {}",
            args.like,
            names.join(", ")
        ))
    })?;
    if let Some(delay_s) = args.delay_s {
        if !(0.0..=1.0).contains(&delay_s) {
            return Err(bad_input(anyhow!(
                "--delay-s {delay_s}: accepted: 0 to 1 s"
            )));
        }
        (like.delay_s, like.delay_source) = (delay_s, "given by the user");
    }
    let mut goal = like.goal();
    if let Some(text) = &args.speeds_m_s {
        let speeds = crate::span::numbers("--speeds-m-s", text, "m/s", 0.1).map_err(bad_input)?;
        let pairs = goal.at[0].pairs_nm.clone();
        goal = Goal::everywhere(goal.hands, &speeds, &pairs);
    }
    if !args.pairs_nm.is_empty() {
        for at in &mut goal.at {
            at.pairs_nm.clone_from(&args.pairs_nm);
        }
    }
    if let Hands::Torque { feels_steer, .. } = &mut goal.hands {
        *feels_steer = !args.roll_only;
    }
    let designed = design(&model, &goal).map_err(bad_input)?;
    let file = like.file(&designed, &args.bicycle.bicycle);
    file.validate().map_err(bad_input)?;
    let text = toml::to_string(&file)?;
    if let Some(out) = &args.out {
        std::fs::write(out, &text)
            .with_context(|| format!("{}: cannot be written", out.display()))
            .map_err(bad_input)?;
    }
    if args.json {
        let points: Vec<_> = designed.stability.iter().map(point).collect();
        let answer = json!({
            "schema_version": 1,
            "bicycle": args.bicycle.bicycle,
            "stays_up": designed.stability.iter().all(StabilityAt::is_stable),
            "points": points,
            "rider": file,
        });
        println!("{}", serde_json::to_string_pretty(&answer)?);
        return Ok(());
    }
    if args.out.is_none() {
        print!("{text}");
    }
    for at in &designed.stability {
        eprintln!(
            "{:5.2} m/s, {:3} Nm: growth {:+.2} 1/s at {:.1} rad/s{}",
            at.speed_m_s,
            at.pair_nm,
            at.growth_per_s,
            at.frequency_rad_s,
            if at.is_stable() { "" } else { "  FALLS" }
        );
    }
    Ok(())
}
