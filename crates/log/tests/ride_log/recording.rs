//! Rides that are recorded for the tests.

use std::path::Path;

use twinhub_log::{
    BicycleShape, CONTROL_OUTPUT, Digest, Event, LINK_TIMING, Level, LogSummary, Metadata,
    PLANT_TRUTH, RIDER_INTENT, RIDER_STATE, RideLog, SENSOR_MEASUREMENT, ScenePose, digest_text,
    row,
};
use twinhub_types::{Instant, Measurement, Output, RiderIntent};

row! {
    /// What the layouts show of the plant.
    pub struct TruthRow {
        roll_rad, steer_rad, roll_rate_rad_s, steer_rate_rad_s, yaw_rate_rad_s, speed_m_s,
        front_brake_nm, rear_traction_nm,
    }
}
row! { pub struct RiderRow { steer_torque_nm, wanted_speed_m_s } }
row! { pub struct TimingRow { round_trip_us } }

pub const SHAPE: BicycleShape = BicycleShape {
    wheelbase_m: 1.02,
    steer_axis_tilt_rad: 0.3,
    trail_m: 0.08,
    rear_radius_m: 0.3,
    front_radius_m: 0.35,
};

pub const CONFIG: &str = "seed = 7\n";

pub fn metadata() -> Metadata {
    Metadata {
        version: "1.2.3".into(),
        git_hash: "abc".into(),
        config_digest: digest_text(CONFIG),
        seed: 7,
        extra: [("course".to_string(), "first".to_string())].into(),
    }
}

/// `ticks` ticks of 1 ms with every topic; `seen` is told each tick that was handed to the log.
pub fn ride(path: &Path, ticks: u64, roll_at_3_rad: f64, timing_us: f64) -> LogSummary {
    ride_with(path, ticks, roll_at_3_rad, timing_us, |_| {})
}

pub fn ride_with(
    path: &Path,
    ticks: u64,
    roll_at_3_rad: f64,
    timing_us: f64,
    mut seen: impl FnMut(u64),
) -> LogSummary {
    let mut log = RideLog::create(path, &metadata(), CONFIG).expect("create");
    let truth = log
        .topic::<TruthRow>(PLANT_TRUTH, Digest::Digested)
        .expect("topic");
    let rider = log
        .topic::<RiderRow>(RIDER_STATE, Digest::Digested)
        .expect("topic");
    let sensor = log
        .topic::<Measurement>(SENSOR_MEASUREMENT, Digest::Digested)
        .expect("topic");
    let intent = log
        .topic::<RiderIntent>(RIDER_INTENT, Digest::Digested)
        .expect("topic");
    let output = log
        .topic::<Output>(CONTROL_OUTPUT, Digest::Digested)
        .expect("topic");
    let timing = log
        .topic::<TimingRow>(LINK_TIMING, Digest::Left)
        .expect("topic");
    log.scene_topic(SHAPE).expect("scene");
    for tick in 0..ticks {
        let now = Instant::from_nanos(tick * 1_000_000);
        let roll_rad = if tick == 3 {
            roll_at_3_rad
        } else {
            1e-3 * tick as f64
        };
        log.write(
            truth,
            now,
            &TruthRow {
                roll_rad,
                speed_m_s: 6.5,
                ..TruthRow::default()
            },
        )
        .expect("write");
        log.write(
            rider,
            now,
            &RiderRow {
                steer_torque_nm: -0.5,
                wanted_speed_m_s: 6.5,
            },
        )
        .expect("write");
        let mut measurement = Measurement::default();
        measurement.imu.stamp_ns = now.as_nanos();
        measurement.imu.gyro_rad_s = [0.25, -1.0, tick as f32];
        log.write(sensor, now, &measurement).expect("write");
        log.write(
            intent,
            now,
            &RiderIntent {
                assist_on: 1,
                ..RiderIntent::default()
            },
        )
        .expect("write");
        let mut answer = Output {
            demand_nm: 3.0,
            health: 5,
            ..Output::default()
        };
        answer.estimate.roll_rad = roll_rad as f32;
        log.write(output, now, &answer).expect("write");
        log.write(
            timing,
            now,
            &TimingRow {
                round_trip_us: timing_us,
            },
        )
        .expect("write");
        if tick % 50 == 0 {
            log.scene(
                now,
                &ScenePose {
                    roll_rad,
                    ..ScenePose::default()
                },
            )
            .expect("scene");
        }
        if tick == 10 {
            let event = Event {
                level: Level::Warning,
                code: "test.event",
                text: "it \"happened\"",
            };
            log.event(now, &event).expect("event");
        }
        seen(tick);
    }
    log.note("fell", "no");
    log.finish().expect("finish")
}
