//! A ride of healthy frames, to be disturbed one thing at a time.

use twinhub_control::{Config, Controller};
use twinhub_types::{
    Health, ImuSample, Instant, Measurement, Mode, MotorSample, Output, RiderIntent, SteerSample,
    WheelSample,
};

pub fn config(name: &str) -> Config {
    let text = match name {
        "off" => include_str!("../../laws/off.toml"),
        "constant" => include_str!("../../laws/constant.toml"),
        "roll_steer_feedback" => include_str!("../../laws/roll_steer_feedback.toml"),
        "steering_spring" => include_str!("../../laws/steering_spring.toml"),
        "steering_motor" => include_str!("../../laws/steering_motor.toml"),
        "scheduled" => include_str!("../../laws/scheduled.toml"),
        other => panic!("no law file {other} ships"),
    };
    toml::from_str(text).expect("a law file that ships can be read")
}

/// Upright, straight, at `speed_m_s`, pedalling, everything healthy, at `ms`.
pub fn healthy(ms: u64, speed_m_s: f32, config: &Config) -> (Measurement, RiderIntent) {
    let stamp_ns = ms * 1_000_000;
    let meas = Measurement {
        imu: ImuSample {
            stamp_ns,
            gyro_rad_s: [0.0; 3],
            accel_m_s2: [0.0, 0.0, -9.81],
        },
        steer: SteerSample {
            stamp_ns,
            steer_rad: 0.0,
            steer_rate_rad_s: 0.0,
        },
        wheels: WheelSample {
            stamp_ns,
            front_rad_s: speed_m_s / config.bicycle.front_wheel_radius_m,
            rear_rad_s: speed_m_s / config.bicycle.rear_wheel_radius_m,
            speed_m_s,
            reserved: 0,
        },
        motors: MotorSample {
            stamp_ns,
            ..MotorSample::default()
        },
        ..Measurement::default()
    };
    let intent = RiderIntent {
        stamp_ns,
        assist_on: 1,
        pedalling: 1,
        ..RiderIntent::default()
    };
    (meas, intent)
}

/// A controller on a ride.
pub struct Ride {
    pub config: Config,
    pub controller: Controller,
    pub ms: u64,
    pub speed_m_s: f32,
    pub last: Output,
}

impl Ride {
    /// At rest, at 5 m/s.
    pub fn new(config: Config) -> Self {
        let controller = Controller::new(&config);
        Self {
            config,
            controller,
            ms: 0,
            speed_m_s: 5.0,
            last: Output::default(),
        }
    }

    /// After ten healthy seconds: the pair is fully there.
    pub fn settled(config: Config) -> Self {
        let mut ride = Self::new(config);
        ride.go(10_000, |_, _| {});
        assert_eq!(ride.mode(), Mode::Active);
        assert!((ride.front_nm() - 40.0).abs() < 1e-3, "{}", ride.front_nm());
        ride
    }

    /// `ticks` milliseconds of frames changed by `change`.
    pub fn go(&mut self, ticks: u64, change: impl Fn(&mut Measurement, &mut RiderIntent)) {
        for _ in 0..ticks {
            let (mut meas, mut intent) = healthy(self.ms, self.speed_m_s, &self.config);
            change(&mut meas, &mut intent);
            self.last =
                self.controller
                    .step(Instant::from_nanos(self.ms * 1_000_000), &meas, &intent);
            self.ms += 1;
        }
    }

    pub fn mode(&self) -> Mode {
        Mode::from_u32(self.last.mode)
    }

    pub fn health(&self) -> Health {
        Health::from_bits(self.last.health)
    }

    pub fn front_nm(&self) -> f32 {
        self.last.command.front_brake_nm
    }
}
