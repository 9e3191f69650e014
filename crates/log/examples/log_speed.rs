//! How long the tick waits for the log, and how long a log takes to read.
//!
//! `cargo run --release -p twinhub-log --example log_speed -- [FILE]`

use std::time::Instant as Wall;

use twinhub_log::{Digest, Metadata, RideLog, ScenePose, read, row};
use twinhub_types::{Instant, Measurement, Output, RiderIntent};

row! {
    /// Twenty columns, as many as the truth of the plant has.
    struct TruthRow {
        a_rad, b_rad, c_rad, d_rad, e_rad, f_rad, g_rad, h_rad, i_rad, j_rad,
        k_rad, l_rad, m_rad, n_rad, o_rad, p_rad, q_rad, r_rad, s_rad, t_rad,
    }
}
row! { struct RiderRow { steer_torque_nm, pedal_force_n, wanted_speed_m_s } }
row! { struct TimingRow { round_trip_us } }

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let given = std::env::args().nth(1);
    let path = given.clone().unwrap_or_else(|| {
        std::env::temp_dir()
            .join(format!("log_speed.{}.mcap", std::process::id()))
            .display()
            .to_string()
    });
    let ticks = 170_000u64;
    let mut log = RideLog::create(path.as_ref(), &Metadata::default(), "")?;
    let truth = log.topic::<TruthRow>("/plant/truth", Digest::Digested)?;
    let rider = log.topic::<RiderRow>("/rider/state", Digest::Digested)?;
    let sensor = log.topic::<Measurement>("/sensor/measurement", Digest::Digested)?;
    let intent = log.topic::<RiderIntent>("/rider/intent", Digest::Digested)?;
    let output = log.topic::<Output>("/control/output", Digest::Digested)?;
    let timing = log.topic::<TimingRow>("/link/timing", Digest::Left)?;
    log.scene_topic(twinhub_log::BicycleShape {
        wheelbase_m: 1.02,
        steer_axis_tilt_rad: 0.314,
        trail_m: 0.08,
        rear_radius_m: 0.3,
        front_radius_m: 0.35,
    })?;
    let mut in_log_ns = Vec::with_capacity(ticks as usize);
    let start = Wall::now();
    for tick in 0..ticks {
        let now = Instant::from_nanos(tick * 1_000_000);
        let row = TruthRow {
            a_rad: tick as f64,
            ..TruthRow::default()
        };
        let mut measurement = Measurement::default();
        measurement.imu.stamp_ns = now.as_nanos();
        measurement.imu.gyro_rad_s = [0.25, -1.0, tick as f32];
        measurement.motors.winding_celsius = 40.0;
        let mut answer = Output {
            demand_nm: 3.0,
            health: 5,
            ..Output::default()
        };
        answer.estimate.speed_m_s = 6.5;
        answer.estimate.roll_rad = tick as f32;
        let before = Wall::now();
        log.write(truth, now, &row)?;
        log.write(rider, now, &RiderRow::default())?;
        log.write(sensor, now, &measurement)?;
        log.write(intent, now, &RiderIntent::default())?;
        log.write(output, now, &answer)?;
        log.write(timing, now, &TimingRow::default())?;
        in_log_ns.push(before.elapsed().as_nanos() as u64);
        if tick % 50 == 0 {
            let roll_rad = 0.2 * libm::sin(tick as f64 * 1e-3);
            log.scene(
                now,
                &ScenePose {
                    x_m: tick as f64 * 6e-3,
                    roll_rad,
                    ..ScenePose::default()
                },
            )?;
        }
    }
    let summary = log.finish()?;
    let elapsed = start.elapsed();
    let sum: u64 = in_log_ns.iter().sum();
    in_log_ns.sort_unstable();
    println!(
        "{ticks} ticks, {} messages, {} bytes: {:?} in all",
        summary.messages, summary.bytes, elapsed
    );
    println!(
        "ns per tick in the log, six topics: mean {}, median {}, p99 {}, longest {}",
        sum / ticks,
        in_log_ns[ticks as usize / 2],
        in_log_ns[ticks as usize * 99 / 100],
        in_log_ns[ticks as usize - 1]
    );
    let start = Wall::now();
    let back = read(&path)?;
    let records: usize = back.tables.values().map(twinhub_log::Table::len).sum();
    println!(
        "read, {records} records into columns: {:?}",
        start.elapsed()
    );
    back.verify()?;
    if given.is_none() {
        std::fs::remove_file(&path)?;
    }
    Ok(())
}
