//! Modes of a linear bicycle.

use super::{ModesArgs, print};
use crate::exit::bad_input;
use anyhow::anyhow;
use std::process::ExitCode;
use twinhub_linear::{Bicycle, Canonical, Modes, MotorPair};

/// Names of the states in the shapes.
const STATES: [&str; 4] = [
    "roll_rad",
    "steer_rad",
    "roll_rate_rad_s",
    "steer_rate_rad_s",
];

/// Computes and prints them.
pub fn run(args: &ModesArgs, bicycle: &Bicycle) -> anyhow::Result<ExitCode> {
    if args.roll_deg.is_some() || args.sensitivities {
        return Err(bad_input(anyhow!(
            "`{}` is a linear bicycle about straight running; --roll-deg and --sensitivities need a \
             multibody one (`twinhub list bicycles`)",
            bicycle.name
        )));
    }
    let speeds = args.speeds("0:10:0.5").map_err(bad_input)?;
    let equations = Canonical::new(bicycle).map_err(bad_input)?;
    let pair = pair(args, bicycle).map_err(bad_input)?;
    let modes = Modes::over(&equations, pair, &speeds);
    let remarks = remarks(bicycle).map_err(bad_input)?;
    for remark in &remarks {
        eprintln!("note: {remark}");
    }
    let picture = args.picture(&bicycle.name);
    if let Some(out) = &picture {
        let fine = Modes::over(&equations, pair, &print::fine_speeds(&speeds, 0.0));
        let subtitle = format!("{}; no tyre slip", torques(pair));
        print::write_picture(out, &bicycle.name, &subtitle, &fine)?;
    }
    if args.json {
        let mut answer = answer(args, bicycle, &equations, pair, &modes);
        answer["remarks"] = remarks.into();
        println!("{answer}");
    } else {
        print::table(&modes, &STATES);
        println!();
        println!("{}", print::sentence(&bicycle.name, &torques(pair), &modes));
        if let Some(out) = &picture {
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

/// The bicycle's remarks, and which causes of its file the matrices cannot hold.
fn remarks(bicycle: &Bicycle) -> anyhow::Result<Vec<String>> {
    let pushing = twinhub_mechanism::extended::pushing(bicycle)?;
    let without = pushing.iter().map(|(mechanism, _)| {
        let name = mechanism.card().name;
        format!("{name} acts in rides; these eigenvalues are without it")
    });
    Ok(bicycle.remarks.iter().cloned().chain(without).collect())
}

fn pair(args: &ModesArgs, bicycle: &Bicycle) -> anyhow::Result<MotorPair> {
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

fn torques(pair: MotorPair) -> String {
    if pair == MotorPair::OFF {
        return "motors off".to_owned();
    }
    format!(
        "front brake {} Nm, rear traction {} Nm",
        print::trimmed(pair.front_brake_nm),
        print::trimmed(pair.rear_traction_nm)
    )
}

fn answer(
    args: &ModesArgs,
    bicycle: &Bicycle,
    equations: &Canonical,
    pair: MotorPair,
    modes: &Modes,
) -> serde_json::Value {
    let mut answer = print::answer(&bicycle.name, &bicycle.source, modes);
    answer["front_brake_nm"] = pair.front_brake_nm.into();
    answer["rear_traction_nm"] = pair.rear_traction_nm.into();
    answer["longitudinal_accel_m_s2"] = equations.longitudinal_accel_m_s2(pair).into();
    let points = modes
        .points
        .iter()
        .map(|point| print::point(point, args.torque_nm, &STATES, args.shapes));
    answer["points"] = points.collect();
    answer["states"] = STATES.to_vec().into();
    answer
}
