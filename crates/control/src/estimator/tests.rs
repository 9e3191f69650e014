//! Synthetic rides with known roll.

use super::*;
use crate::clock::Clock;
use crate::config::Config;
use crate::senses::Senses;
use twinhub_types::{Instant, Measurement, RiderIntent, WheelSample};

/// Rides `roll_rad(t)` at `speed_m_s` with yaw rate `yaw_rad_s(t, roll)` and returns the
/// largest error of roll after `settle_s`, and the last estimate.
fn ride(
    estimator: &mut Estimator,
    end_s: f64,
    settle_s: f64,
    speed_m_s: f64,
    roll_rad: impl Fn(f64) -> f64,
    yaw_rad_s: impl Fn(f64, f64) -> f64,
    change: impl Fn(&mut Measurement),
) -> (f64, Estimate) {
    let (mut clock, mut senses) = (Clock::default(), Senses::default());
    let mut worst_rad = 0f64;
    let mut x = Estimate::default();
    for tick in 0..(end_s * 1e3) as u64 {
        let t = tick as f64 * 1e-3;
        let phi = roll_rad(t);
        let rate = (roll_rad(t + 1e-5) - roll_rad(t - 1e-5)) / 2e-5;
        let yaw = yaw_rad_s(t, phi);
        let stamp_ns = tick * 1_000_000;
        let mut meas = Measurement::default();
        meas.imu.stamp_ns = stamp_ns;
        meas.imu.gyro_rad_s = [
            rate as f32,
            (yaw * libm::sin(phi)) as f32,
            (yaw * libm::cos(phi)) as f32,
        ];
        let a_y = speed_m_s * yaw * libm::cos(phi) - 9.81 * libm::sin(phi);
        let a_z = -speed_m_s * yaw * libm::sin(phi) - 9.81 * libm::cos(phi);
        meas.imu.accel_m_s2 = [0.0, a_y as f32, a_z as f32];
        let wheel_rad_s = (speed_m_s / 0.34) as f32;
        meas.wheels = WheelSample {
            stamp_ns,
            front_rad_s: wheel_rad_s,
            rear_rad_s: wheel_rad_s,
            speed_m_s: speed_m_s as f32,
            reserved: 0,
        };
        change(&mut meas);
        let now = Instant::from_nanos(stamp_ns);
        let seen = senses.read(now, &meas, &RiderIntent::default());
        x = estimator.update(&clock.tick(now), &seen);
        if t >= settle_s {
            worst_rad = worst_rad.max((x.roll_rad as f64 - phi).abs());
        }
    }
    (worst_rad, x)
}

fn fresh() -> Estimator {
    Estimator::new(&Config::NO_TORQUE.bicycle)
}

fn slalom(t: f64) -> f64 {
    0.3 * libm::sin(core::f64::consts::TAU * 0.2 * t)
}

/// Yaw rate of a bicycle that balances at a roll that is steady.
fn coordinated(speed_m_s: f64) -> impl Fn(f64, f64) -> f64 {
    move |_, phi| 9.81 * libm::tan(phi) / speed_m_s
}

/// Yaw rate of a bicycle that balances through the slalom: `h phi'' = g sin(phi) - v psi' cos(phi)`.
fn balanced(speed_m_s: f64) -> impl Fn(f64, f64) -> f64 {
    let bicycle = Config::NO_TORQUE.bicycle;
    let height_m = f64::from(ROLL_HEIGHT_RATIO * bicycle.com_height_m);
    let rate = core::f64::consts::TAU * 0.2;
    move |_, phi| {
        let accel = -rate * rate * phi;
        (9.81 * libm::sin(phi) - height_m * accel) / (speed_m_s * libm::cos(phi))
    }
}

#[test]
fn a_coordinated_turn_is_seen_although_the_accelerometer_feels_nothing() {
    let (worst_rad, x) = ride(&mut fresh(), 60.0, 5.0, 6.0, slalom, balanced(6.0), |_| {});
    assert!(worst_rad < 0.01, "{worst_rad} rad");
    assert!((x.speed_m_s - 6.0).abs() < 1e-3 && x.speed_sd_m_s < 0.06);
    // A steady turn of a minute: the gyro alone would keep it, a plumb line would not.
    let (worst_rad, x) = ride(
        &mut fresh(),
        60.0,
        20.0,
        6.0,
        |_| 0.25,
        coordinated(6.0),
        |_| {},
    );
    assert!(worst_rad < 0.01, "{worst_rad} rad");
    assert!((x.yaw_rate_rad_s as f64 - 9.81 * libm::tan(0.25) / 6.0).abs() < 0.01);
}

#[test]
fn leaning_right_at_rest_is_positive_roll() {
    let (worst_rad, _) = ride(&mut fresh(), 30.0, 20.0, 0.0, |_| 0.2, |_, _| 0.0, |_| {});
    assert!(worst_rad < 0.01, "{worst_rad} rad");
}

#[test]
fn a_bicycle_that_lies_is_seen_to_lie_while_its_wheels_turn() {
    // Down within a second, then half a minute on its side; all wheels say 5 m/s.
    let fall = |t: f64| 1.4 * ((t - 2.0).clamp(0.0, 1.0));
    let mut estimator = fresh();
    for end_s in [3.5, 10.0, 30.0] {
        let (_, x) = ride(&mut estimator, end_s, 0.0, 5.0, fall, |_, _| 0.0, |_| {});
        // Gravity alone cannot tell 80 degrees from 100.
        assert!(
            (1.1..2.05).contains(&x.roll_rad),
            "{} rad after {end_s} s",
            x.roll_rad
        );
        estimator = fresh();
    }
}

#[test]
fn a_gyro_bias_is_learnt() {
    let biased = |meas: &mut Measurement| meas.imu.gyro_rad_s[0] += 0.02;
    let mut estimator = fresh();
    let (worst_rad, x) = ride(
        &mut estimator,
        120.0,
        60.0,
        6.0,
        slalom,
        balanced(6.0),
        biased,
    );
    assert!(worst_rad < 0.01, "{worst_rad} rad");
    assert!(
        (estimator.bias_rad_s - 0.02).abs() < 0.002,
        "{}",
        estimator.bias_rad_s
    );
    assert!((x.roll_sd_rad as f64) < 0.03);
}

#[test]
fn measured_roll_wins_over_a_lying_accelerometer_and_works_alone() {
    let stamp = |meas: &mut Measurement| {
        meas.roll.stamp_ns = meas.imu.stamp_ns;
        meas.roll.roll_rad = slalom(meas.imu.stamp_ns as f64 * 1e-9) as f32;
        meas.roll.roll_rate_rad_s = f32::NAN;
    };
    let lying = |meas: &mut Measurement| {
        stamp(meas);
        meas.imu.accel_m_s2[1] += 2.0;
    };
    let (worst_rad, _) = ride(&mut fresh(), 20.0, 1.0, 6.0, slalom, balanced(6.0), lying);
    assert!(worst_rad < 0.01, "{worst_rad} rad");
    let alone = |meas: &mut Measurement| {
        stamp(meas);
        meas.imu.stamp_ns = NEVER_NS;
    };
    let (worst_rad, x) = ride(&mut fresh(), 20.0, 1.0, 6.0, slalom, balanced(6.0), alone);
    assert!(worst_rad < 0.005, "{worst_rad} rad");
    let rate = 0.3 * core::f64::consts::TAU * 0.2 * libm::cos(core::f64::consts::TAU * 4.0);
    assert!(
        (x.roll_rate_rad_s as f64 - rate).abs() < 0.01,
        "differentiated where not given"
    );
}

#[test]
fn the_steer_rate_is_differentiated_where_the_encoder_gives_none() {
    let steer = |meas: &mut Measurement| {
        let t = meas.imu.stamp_ns as f64 * 1e-9;
        meas.steer.stamp_ns = meas.imu.stamp_ns;
        meas.steer.steer_rad = (0.3 * t - 0.5) as f32;
        meas.steer.steer_rate_rad_s = f32::NAN;
    };
    let (_, x) = ride(&mut fresh(), 2.0, 1.0, 3.0, |_| 0.0, |_, _| 0.0, steer);
    assert!(
        (x.steer_rate_rad_s - 0.3).abs() < 0.01,
        "{}",
        x.steer_rate_rad_s
    );
}

#[test]
fn without_a_gyro_yaw_follows_from_steer_and_the_median_bears_a_locked_wheel() {
    let change = |meas: &mut Measurement| {
        meas.steer.stamp_ns = meas.imu.stamp_ns;
        meas.steer.steer_rad = 0.1;
        meas.imu.stamp_ns = NEVER_NS;
        meas.wheels.front_rad_s = 0.0;
    };
    let (_, x) = ride(&mut fresh(), 1.0, 0.5, 5.0, |_| 0.0, |_, _| 0.0, change);
    let yaw = 5.0 * libm::tan(0.1 * libm::cos(0.35)) / 1.1;
    assert!((x.yaw_rate_rad_s as f64 - yaw).abs() < 1e-3);
    assert!(
        (x.speed_m_s - 5.0).abs() < 1e-3 && x.speed_sd_m_s > 2.0,
        "and says so"
    );
}

#[test]
fn uncertainty_grows_while_nothing_is_measured() {
    let mut estimator = fresh();
    let (_, before) = ride(&mut estimator, 20.0, 1.0, 5.0, |_| 0.0, |_, _| 0.0, |_| {});
    let mut clock = Clock::default();
    let nothing = Senses::default().read(
        Instant::START,
        &Measurement::default(),
        &RiderIntent::default(),
    );
    let mut x = before;
    for ms in 0..500 {
        x = estimator.update(&clock.tick(Instant::from_nanos(ms * 1_000_000)), &nothing);
    }
    assert!(x.roll_sd_rad > before.roll_sd_rad + 0.1 && x.speed_sd_m_s > before.speed_sd_m_s + 0.9);
    assert_eq!(x.speed_m_s, before.speed_m_s, "held");
}
