//! A batch of rides from Rust, to be timed beside the same batch from Python
//! (`python/bench_batch.py`): `cargo run --release -p twinhub-sim --example batch -- 1000 20`.

use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;
use twinhub_link::InProcess;
use twinhub_sim::{Ride, Settings, in_process};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let mut number = |otherwise: f64| -> Result<f64, std::num::ParseFloatError> {
        arguments.next().map_or(Ok(otherwise), |text| text.parse())
    };
    let (rides, duration_s) = (number(1000.0)? as u64, number(20.0)?);
    let begun = Instant::now();
    let next = AtomicU64::new(0);
    let work = || -> Result<f64, String> {
        let mut sum = 0.0;
        loop {
            let seed = next.fetch_add(1, Ordering::Relaxed);
            if seed >= rides {
                return Ok(sum);
            }
            let set = [
                format!("duration_s={duration_s}"),
                format!("seed={seed}"),
                "law=scheduled".to_owned(),
            ];
            let ride = Ride::load("three_to_eight", &set).map_err(|e| e.to_string())?;
            let settings = Settings {
                log: None,
                version: String::new(),
                git_hash: String::new(),
            };
            let mut port = InProcess::new(in_process(&ride.law));
            let outcome = twinhub_sim::ride(&ride, &settings, &mut port, &mut |_| true)
                .map_err(|e| e.to_string())?;
            sum += outcome.metrics.rider_effort_rms_nm;
        }
    };
    let threads = std::thread::available_parallelism()?.get();
    let effort: f64 = std::thread::scope(|scope| {
        let workers: Vec<_> = (0..threads).map(|_| scope.spawn(work)).collect();
        let sums: Result<Vec<f64>, String> = workers
            .into_iter()
            .map(|w| w.join().map_err(|_| "a worker died".to_owned())?)
            .collect();
        sums.map(|s| s.iter().sum())
    })?;
    println!(
        "{rides} rides of {duration_s} s on {threads} threads: {:.2} s; mean effort {:.4} Nm",
        begun.elapsed().as_secs_f64(),
        effort / rides as f64
    );
    Ok(())
}
