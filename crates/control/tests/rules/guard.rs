//! The guard alone, against requests that nobody should make.

use crate::frames::{config, healthy};
use crate::referee::Referee;
use twinhub_control::Profile;
use twinhub_control::guard::{Guard, GuardLimits, Request};
use twinhub_types::{Instant, LimitedBy, Mode};

/// xorshift64*: reproducible and without a dependency.
struct Dice(u64);

impl Dice {
    fn roll(&mut self) -> u64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        self.0.wrapping_mul(0x2545_f491_4f6c_dd1d)
    }
    fn below(&mut self, n: u64) -> u64 {
        (self.roll() >> 32) % n
    }
    fn within(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * (self.below(1 << 24) as f32 / (1 << 24) as f32)
    }
    /// Mostly in range, sometimes any bit pattern at all.
    fn number(&mut self, low: f32, high: f32) -> f32 {
        match self.below(40) {
            0 => f32::from_bits(self.roll() as u32),
            1 => f32::NAN,
            2 => f32::INFINITY,
            3 => -f32::INFINITY,
            _ => self.within(low, high),
        }
    }
}

/// `TWINHUB_GUARD_CALLS=100000000` makes it a long run.
#[test]
fn a_million_calls_break_no_promise() {
    let asked = std::env::var("TWINHUB_GUARD_CALLS").ok();
    let calls: u64 = asked
        .and_then(|text| text.parse().ok())
        .unwrap_or(1_000_000)
        / 2;
    for (profile, seed) in [(Profile::Laboratory, 1), (Profile::En15194, 2)] {
        let mut config = config("constant");
        config.profile = profile;
        config.bicycle.rear_wheel_radius_m = if seed == 1 { 0.29 } else { 0.36 };
        config.limits.torque_max_nm = profile.torque_max_nm();
        config.limits.ramp_up_nm_s = 50.0;
        let limits = GuardLimits::new(&config);
        let (mut guard, mut referee) = (Guard::new(limits), Referee::new(limits));
        let mut dice = Dice(0x9e37_79b9_7f4a_7c15 ^ seed);
        let mut ms = 0u64;
        let mut speed_m_s = 5.0;
        let (mut torque, mut undisturbed) = (0u64, 0u64);
        let mut request = Request::default();
        let mut mode = Mode::Active;
        for call in 0..calls {
            ms += match dice.below(2_000) {
                0 => dice.below(5_000),
                1..4 => 0,
                _ => 1,
            };
            if dice.below(20_000) == 0 {
                ms = dice.below(1_000_000);
            }
            if dice.below(500) == 0 {
                speed_m_s = dice.within(-1.0, 12.0);
            }
            if dice.below(300) == 0 {
                mode = Mode::from_u32(if dice.below(3) == 0 {
                    dice.below(6) as u32
                } else {
                    2
                });
                request = Request {
                    pair_nm: dice.number(-50.0, 150.0),
                    trim_nm: dice.number(-120.0, 120.0),
                    pair_ceiling_nm: dice.number(-20.0, 200.0),
                    limited_by: LimitedBy::FRICTION,
                };
            }
            let (mut meas, mut rider) = healthy(ms, speed_m_s, &config);
            match dice.below(8_000) {
                0 => rider.front_brake_ratio = dice.number(0.0, 1.0),
                1 => rider.rear_brake_ratio = dice.number(0.0, 1.0),
                2 => rider.pedalling = dice.below(3) as u32,
                3 => meas.wheels.front_rad_s = dice.number(-10.0, 40.0),
                4 => meas.wheels.rear_rad_s = dice.number(-10.0, 40.0),
                5 => meas.wheels.speed_m_s = dice.number(-5.0, 20.0),
                6 => meas.wheels.stamp_ns = dice.roll(),
                7 => rider.stamp_ns = dice.roll(),
                8 => rider.pedal_nm = dice.number(0.0, 50.0),
                9 => {
                    meas = Default::default();
                    rider = Default::default();
                }
                _ => undisturbed += 1,
            }
            let now = Instant::from_nanos(ms * 1_000_000);
            let command = guard.apply(now, &meas, &rider, mode, &request);
            torque += u64::from(command.front_brake_nm > 1.0);
            if let Err(broken) = referee.check(now, &meas, &rider, &command, guard.limited_by()) {
                panic!(
                    "{profile:?}, call {call}: {broken}; {meas:?} {rider:?} {request:?} {mode:?}"
                );
            }
        }
        assert!(
            torque > calls / 10,
            "a guard that lets nothing out proves nothing: {torque}"
        );
        assert!(undisturbed > calls / 5 * 4, "most of a ride is healthy");
    }
}

#[test]
fn pedal_stop_ends_drive_at_once_and_leaves_the_balanced_pair() {
    let config = config("constant");
    let mut guard = Guard::new(GuardLimits::new(&config));
    let request = Request {
        pair_nm: 30.0,
        trim_nm: 8.0,
        pair_ceiling_nm: 90.0,
        limited_by: LimitedBy::NONE,
    };
    let mut command = Default::default();
    for ms in 0..4_000 {
        let (meas, rider) = healthy(ms, 5.0, &config);
        command = guard.apply(
            Instant::from_nanos(ms * 1_000_000),
            &meas,
            &rider,
            Mode::Active,
            &request,
        );
    }
    assert!((command.front_brake_nm - 30.0).abs() < 1e-3);
    assert!((command.rear_traction_nm - 38.0).abs() < 1e-3);
    let (meas, mut rider) = healthy(4_000, 5.0, &config);
    rider.pedalling = 0;
    let now = Instant::from_nanos(4_000_000_000);
    let command = guard.apply(now, &meas, &rider, Mode::Active, &request);
    assert!((command.front_brake_nm - 30.0).abs() < 1e-3);
    assert!((command.rear_traction_nm - 30.0).abs() < 1e-3);
    assert!(guard.limited_by().any(LimitedBy::NET_DRIVE));
}

#[test]
fn above_25_km_h_the_pair_stays_and_drive_goes() {
    let config = config("constant");
    let mut guard = Guard::new(GuardLimits::new(&config));
    let request = Request {
        pair_nm: 30.0,
        trim_nm: 8.0,
        pair_ceiling_nm: 90.0,
        limited_by: LimitedBy::NONE,
    };
    for (from_ms, speed_m_s, rear_nm) in [(0, 6.9, 38.0), (4_000, 7.0, 30.0)] {
        let mut command = Default::default();
        for ms in from_ms..from_ms + 4_000 {
            let (meas, rider) = healthy(ms, speed_m_s, &config);
            let now = Instant::from_nanos(ms * 1_000_000);
            command = guard.apply(now, &meas, &rider, Mode::Active, &request);
        }
        assert!((command.front_brake_nm - 30.0).abs() < 1e-3, "{command:?}");
        assert!(
            (command.rear_traction_nm - rear_nm).abs() < 1e-3,
            "{command:?}"
        );
    }
}

#[test]
fn a_request_that_is_no_number_is_a_request_for_nothing() {
    let config = config("constant");
    for absurd in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let mut guard = Guard::new(GuardLimits::new(&config));
        for ms in 0..1_000 {
            let (meas, rider) = healthy(ms, 5.0, &config);
            let request = Request {
                pair_nm: absurd,
                trim_nm: absurd,
                pair_ceiling_nm: 90.0,
                limited_by: LimitedBy::NONE,
            };
            let now = Instant::from_nanos(ms * 1_000_000);
            let command = guard.apply(now, &meas, &rider, Mode::Active, &request);
            assert_eq!(command, Default::default(), "{absurd}");
        }
    }
}
