//! What the multibody model costs: instruction counts under callgrind as the difference of two run
//! lengths, and times.
//!
//! `multibody_cost KIND COUNT`, KIND one of rhs, rhs_bare, rk4, lanes4, lanes8, linearise, steady,
//! map. Without arguments all are timed.

use std::hint::black_box;
use twinhub_plant::integrate::rk4;
use twinhub_plant::lanes::Lanes;
use twinhub_plant::multibody::{
    BulsinkBicycle, Case, Course, Input, Multibody, Parameters, Reading, STATES, State, Steady,
    advance_lanes,
};

fn full() -> (Multibody, Steady) {
    let parameters = Parameters::bulsink2017(
        BulsinkBicycle::One,
        Case::Full,
        &Reading {
            linear_arms: true,
            ..Reading::default()
        },
    );
    let model = Multibody::new(&parameters).expect("a published set");
    let steady = model
        .steady(&Course::straight(6.0), None)
        .expect("rides straight");
    (model, steady)
}

fn lanes<const N: usize>(model: &Multibody, steady: &Steady, count: usize) -> f64 {
    let mut x: State<Lanes<N>> = core::array::from_fn(|i| Lanes([steady.state[i]; N]));
    let input: Input<Lanes<N>> = steady.input.lifted();
    advance_lanes(model, &mut x, &input, None, 1.0e-3, count);
    x[7].0[0]
}

/// Runs a kind; gives the milliseconds of ride (or pieces of work) it stands for.
fn run(kind: &str, count: usize) -> f64 {
    let (model, steady) = full();
    let mut x = steady.state;
    let mut dx = [0.0; STATES];
    match kind {
        "rhs" => {
            for _ in 0..count {
                model.rhs(black_box(&x), black_box(&steady.input), None, &mut dx);
                black_box(&mut dx);
            }
        }
        "rk4" => {
            for _ in 0..count {
                rk4(&mut x, 1.0e-3, |x, dx| {
                    model.rhs(x, &steady.input, None, dx)
                });
                model.project(&mut x);
            }
            black_box(x);
        }
        "lanes4" => {
            black_box(lanes::<4>(&model, &steady, count));
            return 4.0 * count as f64;
        }
        "lanes8" => {
            black_box(lanes::<8>(&model, &steady, count));
            return 8.0 * count as f64;
        }
        "linearise" => {
            for _ in 0..count {
                black_box(model.lateral(black_box(&steady)));
            }
        }
        "steady" => {
            for k in 0..count {
                let speed = 6.0 + 0.01 * (k % 2) as f64;
                black_box(
                    model
                        .steady(&Course::straight(speed), Some(&steady))
                        .expect("nearby"),
                );
            }
        }
        "map" => {
            let mut guess = steady.clone();
            for k in 0..count {
                let course = Course::pair(3.0 + 7.0 * k as f64 / count as f64, 20.0);
                guess = model.steady(&course, Some(&guess)).expect("nearby");
                black_box(model.lateral_eigenvalues(&guess));
            }
        }
        other => {
            eprintln!("{other}: accepted: rhs, rk4, lanes4, lanes8, linearise, steady, map");
            std::process::exit(2);
        }
    }
    count as f64
}

/// Time that this thread has spent on a processor, s; where the system does not tell, the clock.
fn processor_time_s() -> f64 {
    let told = std::fs::read_to_string("/proc/thread-self/schedstat").ok();
    let first = told.and_then(|text| text.split_whitespace().next()?.parse::<f64>().ok());
    first.map_or_else(
        || {
            std::time::UNIX_EPOCH
                .elapsed()
                .map_or(0.0, |d| d.as_secs_f64())
        },
        |ns| ns * 1e-9,
    )
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    if let [kind, count] = arguments.as_slice() {
        run(kind, count.parse().unwrap_or(1));
        return;
    }
    for (kind, count) in [
        ("rhs", 200_000),
        ("rk4", 50_000),
        ("lanes4", 50_000),
        ("lanes8", 50_000),
        ("linearise", 2000),
        ("steady", 500),
        ("map", 1000),
    ] {
        let mut best = f64::INFINITY;
        for _ in 0..5 {
            let start = processor_time_s();
            let work = run(kind, count);
            best = best.min((processor_time_s() - start) / work);
        }
        println!(
            "{kind:10} {:10.1} ns each, {:8.0} times real time at 1 ms",
            best * 1e9,
            1e-3 / best
        );
    }
}
