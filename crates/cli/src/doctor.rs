//! `twinhub doctor`: what the machine allows a ride, and how to get more.

use crate::exit;
use clap::Args;
use serde_json::json;
use std::process::ExitCode;
use twinhub_link::RunDir;
use twinhub_link::doctor::{Finding, examine};

/// Arguments of `twinhub doctor`.
#[derive(Args)]
pub struct DoctorArgs {
    /// Print the findings as JSON.
    #[arg(long)]
    json: bool,
}

/// Runs the command: exit code 0 if rides work here, 3 if something is missing that they need.
///
/// # Errors
/// None so far.
pub fn run(args: &DoctorArgs) -> anyhow::Result<ExitCode> {
    let findings = examine(&RunDir::from_env());
    let rides = findings.iter().all(|f| f.ok || !f.needed);
    let real_time = findings.iter().all(|f| f.ok);
    if args.json {
        let text = json!({
            "schema_version": 1,
            "rides": rides,
            "all_as_wanted": real_time,
            "findings": findings,
        });
        println!("{}", serde_json::to_string_pretty(&text)?);
    } else {
        for finding in &findings {
            print!("{}", line(finding));
        }
        println!(
            "\n{}",
            match (rides, real_time) {
                (false, _) => "rides do not work here; see what is missing",
                (true, false) =>
                    "rides work here; real time could be better, see `could be better`",
                (true, true) => "rides work here, and real time has all that it wants",
            }
        );
    }
    Ok(if rides {
        ExitCode::SUCCESS
    } else {
        ExitCode::from(exit::ENVIRONMENT)
    })
}

fn line(finding: &Finding) -> String {
    let verdict = match (finding.ok, finding.needed) {
        (true, _) => "ok",
        (false, true) => "missing",
        (false, false) => "could be better",
    };
    let mut text = format!("{verdict:<16}{:<28}{}\n", finding.name, finding.found);
    if !finding.ok {
        text += &format!("{:44}wanted: {}\n", "", finding.wanted);
        text += &format!("{:44}how: {}\n", "", finding.how);
    }
    text
}
