//! Modes of a multibody bicycle.

use super::{ModesArgs, print, sensitivities};
use crate::exit::bad_input;
use anyhow::anyhow;
use serde_json::{Value, json};
use std::process::ExitCode;
use twinhub_linear::{Modes, Point};
use twinhub_plant::multibody::{Course, Multibody, NamedModes, Parameters, Rear, Steady};

/// Least speed of the picture: below, tyre slip means nothing, m/s.
const PICTURE_FROM_M_S: f64 = 0.3;

/// Computes and prints them.
pub fn run(args: &ModesArgs, parameters: &Parameters) -> anyhow::Result<ExitCode> {
    let speeds = args.speeds("0.5:10:0.5").map_err(bad_input)?;
    let model = Multibody::new(parameters).map_err(bad_input)?;
    let course = course(args).map_err(bad_input)?;
    let found = model.named_modes(&course, &speeds).map_err(bad_input)?;
    let picture = args.picture(&parameters.name);
    if let Some(out) = &picture {
        let fine = print::fine_speeds(&speeds, PICTURE_FROM_M_S);
        let fine = model.named_modes(&course, &fine).map_err(bad_input)?.modes;
        let subtitle = format!("{}; {}", torques(args), wheels(&model));
        print::write_picture(out, &parameters.name, &subtitle, &with_modes(fine))?;
    }
    let sensitivities = args
        .sensitivities
        .then(|| sensitivities::compute(&model, &course, &found.modes))
        .transpose()
        .map_err(bad_input)?;
    if args.json {
        let mut answer = answer(args, parameters, &found);
        if let Some(sensitivities) = &sensitivities {
            answer["sensitivities"] = sensitivities.json();
        }
        println!("{answer}");
    } else {
        print::table(&found.modes, &found.states);
        println!();
        println!(
            "{}",
            print::sentence(&parameters.name, &torques(args), &found.modes)
        );
        if let Some(sensitivities) = &sensitivities {
            println!();
            sensitivities.print();
        }
        if let Some(out) = &picture {
            println!("picture: {}", out.display());
        }
    }
    for (speed_m_s, why) in &found.missing {
        eprintln!("note: no modes at {speed_m_s} m/s: {why}");
    }
    let accelerates = |s: &&Steady| s.acceleration_m_s2 != 0.0;
    if let Some(steady) = found.steady.iter().flatten().find(accelerates) {
        eprintln!(
            "note: these torques accelerate the bicycle, by {:.3} m/s^2 at {} m/s: modes of the moment at each speed",
            steady.acceleration_m_s2, steady.course.speed_m_s
        );
    }
    Ok(ExitCode::SUCCESS)
}

/// What the bicycle does at each speed.
fn course(args: &ModesArgs) -> anyhow::Result<Course> {
    let roll_deg = args.roll_deg.unwrap_or(0.0);
    if !(-60.0..=60.0).contains(&roll_deg) {
        return Err(anyhow!("--roll-deg {roll_deg}: accepted: -60 to 60"));
    }
    Ok(Course {
        speed_m_s: 1.0,
        roll_rad: roll_deg.to_radians(),
        front_brake_nm: args.torque_nm,
        rear: args.rear_torque_nm.map_or(Rear::HoldSpeed, Rear::Torque),
    })
}

/// The points that have modes: what a picture can show.
fn with_modes(modes: Modes) -> Modes {
    let points: Vec<Point> = modes.points;
    Modes {
        points: points.into_iter().filter(|p| !p.modes.is_empty()).collect(),
        ..modes
    }
}

fn wheels(model: &Multibody) -> &'static str {
    if model.is_no_slip() {
        "no tyre slip"
    } else {
        "on tyres"
    }
}

fn torques(args: &ModesArgs) -> String {
    let turn = match args.roll_deg {
        Some(roll) if roll != 0.0 => format!(", steady turn at {roll} deg of roll"),
        _ => String::new(),
    };
    let front = print::trimmed(args.torque_nm);
    match args.rear_torque_nm {
        Some(rear) => format!(
            "front brake {front} Nm, rear traction {} Nm{turn}",
            print::trimmed(rear)
        ),
        None if args.torque_nm == 0.0 => {
            format!("front motor off, rear traction holding the speed{turn}")
        }
        None => format!("front brake {front} Nm, rear traction holding the speed{turn}"),
    }
}

fn answer(args: &ModesArgs, parameters: &Parameters, found: &NamedModes) -> Value {
    let mut answer = print::answer(&parameters.name, &parameters.source, &found.modes);
    answer["states"] = found.states.clone().into();
    answer["roll_rad"] = args.roll_deg.unwrap_or(0.0).to_radians().into();
    let points = found.modes.points.iter().zip(&found.steady);
    answer["points"] = points
        .map(|(point, steady)| {
            let mut point = print::point(point, args.torque_nm, &found.states, args.shapes);
            if let Some(steady) = steady {
                point["front_brake_nm"] = steady.input.front_brake_nm.into();
                point["rear_traction_nm"] = steady.input.rear_traction_nm.into();
                point["longitudinal_accel_m_s2"] = steady.acceleration_m_s2.into();
                point["steer_rad"] = steady.steer_rad().into();
                point["steer_torque_nm"] = steady.input.steer_torque_nm.into();
            }
            point
        })
        .collect();
    answer["missing"] = found
        .missing
        .iter()
        .map(|(speed_m_s, why)| json!({ "speed_m_s": speed_m_s, "why": why.to_string() }))
        .collect();
    answer
}
