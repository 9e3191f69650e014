//! Evaluates a tyre many times, for counting its instructions:
//! `valgrind --tool=callgrind target/release/examples/tyre_cost bulsink2017_ellipse 100000`
//! against the same with 0 evaluations; the difference over 100000 is the cost of one.

use twinhub_plant::tyre::{SETS, TyreInput, TyreModel, set};

fn main() {
    let mut args = std::env::args().skip(1);
    let (Some(name), Some(count)) = (args.next(), args.next().and_then(|n| n.parse().ok())) else {
        eprintln!("usage: tyre_cost SET COUNT");
        std::process::exit(2);
    };
    let Some(found) = set(&name) else {
        let names: Vec<_> = SETS.iter().map(|set| set.name).collect();
        eprintln!(
            "tyre_cost: no set called {name}; there are {}",
            names.join(", ")
        );
        std::process::exit(2);
    };
    let mut sum = 0.0;
    for i in 0u32..count {
        let phase = f64::from(i % 97) / 97.0 - 0.5;
        let input = TyreInput {
            load_n: 400.0 + 100.0 * phase,
            slip_ratio: 0.02 * phase,
            slip_angle_rad: 0.1 * phase,
            camber_rad: -0.2 * phase,
            speed_m_s: 5.0,
            friction_ratio: 1.0,
            radius_m: 0.35,
        };
        let out = found.tyre.output(std::hint::black_box(&input));
        sum += out.longitudinal_n
            + out.lateral_n
            + out.overturning_nm
            + out.rolling_resistance_nm
            + out.aligning_nm;
    }
    println!("{sum}");
}
