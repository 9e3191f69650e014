//! The instruction gate: fails where one right-hand side of the full model with tyres takes more
//! instructions than allowed, counted by callgrind as the difference of two run lengths. Skipped,
//! loudly, where valgrind is missing.
//!
//! `cargo bench -p twinhub-plant --bench instructions`; `peers` has the whole comparison.

#[path = "peers/measure.rs"]
#[allow(dead_code)]
mod measure;

use std::hint::black_box;
use std::process::ExitCode;
use twinhub_plant::multibody::{BulsinkBicycle, Case, Parameters, Reading, Ride};

/// Most instructions that one right-hand side may take.
const MOST: f64 = 8000.0;

/// What is counted: `count` right-hand sides.
fn repeat(count: usize) {
    let reading = Reading {
        linear_arms: true,
        ..Reading::default()
    };
    let parameters = Parameters::bulsink2017(BulsinkBicycle::One, Case::Full, &reading);
    let ride = Ride::new(&parameters, None, 5.0).expect("the published bicycle rides straight");
    for _ in 0..count {
        black_box(black_box(&ride).derivative());
    }
}

fn main() -> ExitCode {
    let words: Vec<String> = std::env::args().collect();
    if let Some(at) = words.iter().position(|w| w == "--repeat") {
        repeat(words.get(at + 2).and_then(|n| n.parse().ok()).unwrap_or(1));
        return ExitCode::SUCCESS;
    }
    if !measure::valgrind_is_there() {
        eprintln!("SKIPPED: the instruction gate needs valgrind (Debian package `valgrind`)");
        return ExitCode::SUCCESS;
    }
    match measure::instructions("rhs", 1, &[]) {
        Ok(n) if n <= MOST => {
            println!("right-hand side: {n:.0} instructions, at most {MOST:.0} allowed");
            ExitCode::SUCCESS
        }
        Ok(n) => {
            eprintln!("right-hand side: {n:.0} instructions, more than the {MOST:.0} allowed");
            ExitCode::from(1)
        }
        Err(why) => {
            eprintln!("right-hand side: cannot count instructions: {why}");
            ExitCode::from(3)
        }
    }
}
