//! Which samples can be believed: finite, in range, in time.
//!
//! A sample that fails is as good as none: the last good one stands in until it is too old, so
//! that a single corrupted frame changes nothing. Ages and ranges are those of the tables below.

use twinhub_types::{
    Duration, ImuSample, Instant, Measurement, NEVER_NS, RiderIntent, RollSample, SteerSample,
    WheelSample,
};

/// Nothing at all from the bicycle for longer than this is a lost link.
pub const LINK_MAX_AGE: Duration = Duration::from_millis(20);
/// Oldest usable inertial, roll and steer sample.
pub const MOTION_MAX_AGE: Duration = Duration::from_millis(20);
/// Oldest usable wheel-speed sample.
pub const WHEELS_MAX_AGE: Duration = Duration::from_millis(50);
/// Oldest usable reading of levers, pedals and switch.
pub const INTENT_MAX_AGE: Duration = Duration::from_millis(50);

/// Largest believable rate of a gyro and of a measured roll rate, rad/s (2000 degrees/s).
pub const RATE_MAX_RAD_S: f32 = 35.0;
/// Largest believable specific force, m/s² (16 g).
pub const ACCEL_MAX_M_S2: f32 = 157.0;
/// Largest believable roll, rad.
pub const ROLL_MAX_RAD: f32 = 3.2;
/// The steering stop, rad; no fork of a ridden bicycle turns further.
pub const STEER_MAX_RAD: f32 = 1.6;
/// Fastest believable speed of the bicycle and of a wheel's tread, m/s.
pub const SPEED_MAX_M_S: f32 = 30.0;
/// Largest believable wheel rate, rad/s.
pub const WHEEL_MAX_RAD_S: f32 = 300.0;
/// Largest believable torque at the crank, Nm.
pub const PEDAL_MAX_NM: f32 = 500.0;
/// Largest believable crank rate, rad/s.
pub const CADENCE_MAX_RAD_S: f32 = 35.0;

/// The last good samples that are still fresh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seen {
    /// Inertial measurement unit.
    pub imu: Option<ImuSample>,
    /// Measured roll.
    pub roll: Option<RollSample>,
    /// Steer encoder; its rate may be NaN.
    pub steer: Option<SteerSample>,
    /// Wheel speeds.
    pub wheels: Option<WheelSample>,
    /// Levers, pedals, switch.
    pub intent: Option<RiderIntent>,
    /// True while anything at all is fresh.
    pub link: bool,
}

/// Remembers the last good sample of each sensor.
#[derive(Clone, Copy, Debug, Default)]
pub struct Senses {
    imu: ImuSample,
    roll: RollSample,
    steer: SteerSample,
    wheels: WheelSample,
    intent: RiderIntent,
}

/// True if `value` is finite and within `±limit`.
pub fn within(value: f32, limit: f32) -> bool {
    // False for NaN.
    value.abs() <= limit
}

/// True if every field of an inertial sample is finite and in range.
pub fn plausible_imu(sample: &ImuSample) -> bool {
    let [p, q, r] = sample.gyro_rad_s;
    let [x, y, z] = sample.accel_m_s2;
    within(p, RATE_MAX_RAD_S)
        && within(q, RATE_MAX_RAD_S)
        && within(r, RATE_MAX_RAD_S)
        && within(x, ACCEL_MAX_M_S2)
        && within(y, ACCEL_MAX_M_S2)
        && within(z, ACCEL_MAX_M_S2)
}

/// True if roll is finite and in range; the rate may be anything.
pub fn plausible_roll(sample: &RollSample) -> bool {
    within(sample.roll_rad, ROLL_MAX_RAD)
}

/// True if steer is finite and inside the steering stop; the rate may be anything.
pub fn plausible_steer(sample: &SteerSample) -> bool {
    within(sample.steer_rad, STEER_MAX_RAD)
}

/// True if speed and both wheel rates are finite and in range.
pub fn plausible_wheels(sample: &WheelSample) -> bool {
    within(sample.speed_m_s, SPEED_MAX_M_S)
        && within(sample.front_rad_s, WHEEL_MAX_RAD_S)
        && within(sample.rear_rad_s, WHEEL_MAX_RAD_S)
}

/// True if the readings of levers, pedals and switch are finite and in range.
pub fn plausible_intent(intent: &RiderIntent) -> bool {
    let lever = |ratio: f32| (-0.1..=1.1).contains(&ratio);
    intent.assist_on <= 1
        && intent.pedalling <= 1
        && lever(intent.front_brake_ratio)
        && lever(intent.rear_brake_ratio)
        && within(intent.pedal_nm, PEDAL_MAX_NM)
        && within(intent.cadence_rad_s, CADENCE_MAX_RAD_S)
}

impl Senses {
    /// Takes what is good of `meas` and `intent`, and returns what can be believed `now`.
    pub fn read(&mut self, now: Instant, meas: &Measurement, intent: &RiderIntent) -> Seen {
        if now.fresh(meas.imu.stamp_ns, MOTION_MAX_AGE) && plausible_imu(&meas.imu) {
            self.imu = meas.imu;
        }
        if now.fresh(meas.roll.stamp_ns, MOTION_MAX_AGE) && plausible_roll(&meas.roll) {
            self.roll = meas.roll;
        }
        if now.fresh(meas.steer.stamp_ns, MOTION_MAX_AGE) && plausible_steer(&meas.steer) {
            self.steer = meas.steer;
        }
        if now.fresh(meas.wheels.stamp_ns, WHEELS_MAX_AGE) && plausible_wheels(&meas.wheels) {
            self.wheels = meas.wheels;
        }
        if now.fresh(intent.stamp_ns, INTENT_MAX_AGE) && plausible_intent(intent) {
            self.intent = *intent;
        }
        Seen {
            imu: now
                .fresh(self.imu.stamp_ns, MOTION_MAX_AGE)
                .then_some(self.imu),
            roll: now
                .fresh(self.roll.stamp_ns, MOTION_MAX_AGE)
                .then_some(self.roll),
            steer: now
                .fresh(self.steer.stamp_ns, MOTION_MAX_AGE)
                .then_some(self.steer),
            wheels: now
                .fresh(self.wheels.stamp_ns, WHEELS_MAX_AGE)
                .then_some(self.wheels),
            intent: now
                .fresh(self.intent.stamp_ns, INTENT_MAX_AGE)
                .then_some(self.intent),
            link: link_alive(now, meas, intent),
        }
    }
}

/// True if any sample of the frame was taken at most [`LINK_MAX_AGE`] ago, whatever its values.
pub fn link_alive(now: Instant, meas: &Measurement, intent: &RiderIntent) -> bool {
    [
        meas.imu.stamp_ns,
        meas.roll.stamp_ns,
        meas.steer.stamp_ns,
        meas.wheels.stamp_ns,
        meas.motors.stamp_ns,
        intent.stamp_ns,
    ]
    .iter()
    .any(|stamp_ns| now.fresh(*stamp_ns, LINK_MAX_AGE))
}

/// Nanoseconds from stamp `earlier` to stamp `later` in seconds; `None` unless `later` is later
/// and both were taken.
pub fn span_s(earlier_ns: u64, later_ns: u64) -> Option<f32> {
    if earlier_ns == NEVER_NS || later_ns == NEVER_NS || later_ns <= earlier_ns {
        return None;
    }
    Some(Duration::from_nanos(later_ns.saturating_sub(earlier_ns)).as_secs_f32())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_corrupted_sample_is_bridged_and_a_second_of_them_is_not() {
        let mut senses = Senses::default();
        let intent = RiderIntent::default();
        let mut meas = Measurement {
            steer: SteerSample {
                stamp_ns: 0,
                steer_rad: 0.1,
                steer_rate_rad_s: f32::NAN,
            },
            ..Measurement::default()
        };
        let at = |ms: u64| Instant::from_nanos(ms * 1_000_000);
        assert_eq!(
            senses
                .read(at(0), &meas, &intent)
                .steer
                .map(|s| s.steer_rad),
            Some(0.1)
        );
        for ms in 1..=20 {
            meas.steer = SteerSample {
                stamp_ns: ms * 1_000_000,
                steer_rad: f32::NAN,
                steer_rate_rad_s: 0.0,
            };
            assert!(
                senses.read(at(ms), &meas, &intent).steer.is_some(),
                "{ms} ms"
            );
        }
        meas.steer.stamp_ns = 21_000_000;
        let seen = senses.read(at(21), &meas, &intent);
        assert!(seen.steer.is_none() && seen.link);
        assert!(!senses.read(at(42), &meas, &intent).link);
    }

    #[test]
    fn samples_from_the_future_are_not_believed() {
        let mut senses = Senses::default();
        let meas = Measurement {
            wheels: WheelSample {
                stamp_ns: 2,
                front_rad_s: 1.0,
                rear_rad_s: 1.0,
                speed_m_s: 0.3,
                reserved: 0,
            },
            ..Measurement::default()
        };
        let seen = senses.read(Instant::from_nanos(1), &meas, &RiderIntent::default());
        assert!(seen.wheels.is_none() && !seen.link);
    }
}
