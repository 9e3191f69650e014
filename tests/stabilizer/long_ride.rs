//! Ordinary use raises no flag: a flag that comes without a cause teaches riders to ignore it.

use twinhub_sim::{Ride, Stepper};
use twinhub_types::Health;

/// Length of one ride, s.
const RIDE_S: f64 = 600.0;

/// A ride over a rough road in gusty wind, with sensors as bought, speeding up and braking.
fn ride(seed: u64) {
    let speed: Vec<String> = (0..20u64)
        .map(|n| {
            // 4.8 to 7.2 m/s, a new speed every half minute, reached within 6 s.
            let level = |n: u64| 4.8 + 0.4 * ((n * 5 + seed) % 7) as f64;
            let t_s = 30.0 * n as f64;
            format!(
                "{{t_s={t_s:?},speed_m_s={:?}}},{{t_s={:?},speed_m_s={:?}}}",
                level(n),
                t_s + 24.0,
                level(n)
            )
        })
        .collect();
    let set = [
        "law=\"scheduled\"".to_owned(),
        "rider=\"young\"".to_owned(),
        "sensors=\"as_bought\"".to_owned(),
        "plant.multibody.road=\"rough\"".to_owned(),
        "plant.multibody.wind=\"gusty\"".to_owned(),
        format!("duration_s={RIDE_S:?}"),
        format!("seed={seed}"),
        format!("speed=[{}]", speed.join(",")),
    ];
    let ride = Ride::load("three_to_eight", &set).expect("a ride");
    let mut stepper = Stepper::new(&ride).expect("starts");
    let mut pair_s = 0.0;
    while let Some(step) = stepper.step(None) {
        // Until the first sample of each sensor and a second more, flags are right.
        if stepper.time_s() > 2.0 {
            let health = Health::from_bits(step.output.health);
            assert!(
                health.is_ok(),
                "seed {seed}, {} s: {health:?}, {:?}",
                stepper.time_s(),
                step.truth
            );
        }
        pair_s += if step.truth.front_brake_nm > 5.0 {
            1e-3
        } else {
            0.0
        };
    }
    assert!(
        !stepper.fell(),
        "seed {seed} fell at {} s",
        stepper.time_s()
    );
    assert!(
        pair_s > 0.8 * RIDE_S,
        "seed {seed}: a pair for {pair_s} s alone"
    );
}

/// `TWINHUB_RIDE_HOURS=100` makes it a long run.
#[test]
fn hours_of_ordinary_use_raise_no_flag() {
    let asked = std::env::var("TWINHUB_RIDE_HOURS").ok();
    let hours: f64 = asked.and_then(|text| text.parse().ok()).unwrap_or(0.5);
    let rides = (hours * 3600.0 / RIDE_S).ceil() as u64;
    let next = std::sync::atomic::AtomicU64::new(1);
    std::thread::scope(|scope| {
        for _ in 0..std::thread::available_parallelism().map_or(1, usize::from) {
            scope.spawn(|| {
                loop {
                    let seed = next.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
                    if seed > rides {
                        return;
                    }
                    ride(seed);
                    if seed.is_multiple_of(60) {
                        println!("{} of {hours} hours", seed as f64 * RIDE_S / 3600.0);
                    }
                }
            });
        }
    });
}
