//! Faults of sensors, by schedule and seed.
//!
//! What: between `start_s` and `end_s` one channel, or all of one sensor, does what `kind` says;
//! later faults of a list see the output of earlier ones. Equation: see [`FaultKind`]. Source: our
//! own list. Assumes and ignores: faults of the link (lost, late, repeated or corrupted frames)
//! are the link's. Valid for: any suite. Checked by: `fault_tests.rs`.

use serde::{Deserialize, Serialize};
use twinhub_types::{Duration, Instant, Measurement};

use crate::admissible::{OutOfRange, within};
use crate::noise::{Gaussian, stream};

/// What a fault hits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[allow(missing_docs)] // the names say it: five sensors and their channels
pub enum FaultTarget {
    Imu,
    GyroX,
    GyroY,
    GyroZ,
    AccelX,
    AccelY,
    AccelZ,
    Roll,
    RollAngle,
    RollRate,
    Steer,
    SteerAngle,
    SteerRate,
    Wheels,
    FrontWheel,
    RearWheel,
    Speed,
    Motors,
    FrontTorque,
    RearTorque,
    BusVoltage,
    BusCurrent,
    Winding,
}

/// What goes wrong. Amounts are in the unit of the channel.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum FaultKind {
    /// The value stays what it was; stamps go on as if nothing were wrong.
    Stuck {},
    /// A constant is added.
    Offset {
        /// What is added.
        amount: f64,
    },
    /// A growing amount is added.
    Drift {
        /// What is added in a second.
        amount_per_s: f64,
    },
    /// The value is multiplied.
    Scale {
        /// The factor.
        factor: f64,
    },
    /// The sign is wrong.
    SignSwap {},
    /// Single samples jump by plus or minus the amount.
    Spike {
        /// How far.
        amount: f64,
        /// Share of samples that jump.
        share_ratio: f64,
    },
    /// The value is not a number.
    Nan {},
    /// Samples arrive late; hits the whole sensor.
    Late {
        /// By how much, s.
        delay_s: f64,
    },
    /// Samples are lost; hits the whole sensor. A share of 1 is a dead sensor.
    Dropout {
        /// Share of samples that are lost.
        share_ratio: f64,
    },
}

/// One fault.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Fault {
    /// What it hits.
    pub target: FaultTarget,
    /// When it begins, s.
    pub start_s: f64,
    /// When it ends, s; without it, never.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub end_s: Option<f64>,
    /// What goes wrong.
    pub kind: FaultKind,
}

const CHANNELS: usize = 18;
const LATE_TICKS: usize = 512;

impl FaultTarget {
    /// Every target.
    pub const ALL: [Self; 23] = [
        Self::Imu,
        Self::GyroX,
        Self::GyroY,
        Self::GyroZ,
        Self::AccelX,
        Self::AccelY,
        Self::AccelZ,
        Self::Roll,
        Self::RollAngle,
        Self::RollRate,
        Self::Steer,
        Self::SteerAngle,
        Self::SteerRate,
        Self::Wheels,
        Self::FrontWheel,
        Self::RearWheel,
        Self::Speed,
        Self::Motors,
        Self::FrontTorque,
        Self::RearTorque,
        Self::BusVoltage,
        Self::BusCurrent,
        Self::Winding,
    ];

    /// Number of the sensor and its channels, in the order of `channel`.
    fn place(self) -> (usize, core::ops::Range<usize>) {
        match self {
            Self::Imu => (0, 0..6),
            Self::GyroX => (0, 0..1),
            Self::GyroY => (0, 1..2),
            Self::GyroZ => (0, 2..3),
            Self::AccelX => (0, 3..4),
            Self::AccelY => (0, 4..5),
            Self::AccelZ => (0, 5..6),
            Self::Roll => (1, 6..8),
            Self::RollAngle => (1, 6..7),
            Self::RollRate => (1, 7..8),
            Self::Steer => (2, 8..10),
            Self::SteerAngle => (2, 8..9),
            Self::SteerRate => (2, 9..10),
            Self::Wheels => (3, 10..13),
            Self::FrontWheel => (3, 10..11),
            Self::RearWheel => (3, 11..12),
            Self::Speed => (3, 12..13),
            Self::Motors => (4, 13..18),
            Self::FrontTorque => (4, 13..14),
            Self::RearTorque => (4, 14..15),
            Self::BusVoltage => (4, 15..16),
            Self::BusCurrent => (4, 16..17),
            Self::Winding => (4, 17..18),
        }
    }
}

fn channel(m: &mut Measurement, index: usize) -> &mut f32 {
    match index {
        0..3 => &mut m.imu.gyro_rad_s[index],
        3..6 => &mut m.imu.accel_m_s2[index - 3],
        6 => &mut m.roll.roll_rad,
        7 => &mut m.roll.roll_rate_rad_s,
        8 => &mut m.steer.steer_rad,
        9 => &mut m.steer.steer_rate_rad_s,
        10 => &mut m.wheels.front_rad_s,
        11 => &mut m.wheels.rear_rad_s,
        12 => &mut m.wheels.speed_m_s,
        13 => &mut m.motors.front_brake_nm,
        14 => &mut m.motors.rear_traction_nm,
        15 => &mut m.motors.bus_v,
        16 => &mut m.motors.bus_a,
        _ => &mut m.motors.winding_celsius,
    }
}

fn stamp(m: &Measurement, sensor: usize) -> u64 {
    match sensor {
        0 => m.imu.stamp_ns,
        1 => m.roll.stamp_ns,
        2 => m.steer.stamp_ns,
        3 => m.wheels.stamp_ns,
        _ => m.motors.stamp_ns,
    }
}

fn copy_sensor(from: &Measurement, to: &mut Measurement, sensor: usize) {
    match sensor {
        0 => to.imu = from.imu,
        1 => to.roll = from.roll,
        2 => to.steer = from.steer,
        3 => to.wheels = from.wheels,
        _ => to.motors = from.motors,
    }
}

impl Fault {
    /// Checks every parameter.
    pub fn validate(&self) -> Result<(), OutOfRange> {
        within("start_s", self.start_s, 0.0, 1e9)?;
        if let Some(end_s) = self.end_s {
            within("end_s", end_s, self.start_s, 1e9)?;
        }
        match self.kind {
            FaultKind::Stuck {} | FaultKind::SignSwap {} | FaultKind::Nan {} => Ok(()),
            FaultKind::Offset { amount } => within("amount", amount, -1e6, 1e6),
            FaultKind::Drift { amount_per_s } => within("amount_per_s", amount_per_s, -1e6, 1e6),
            FaultKind::Scale { factor } => within("factor", factor, -1e3, 1e3),
            FaultKind::Spike {
                amount,
                share_ratio,
            } => {
                within("amount", amount, -1e6, 1e6)?;
                within("share_ratio", share_ratio, 0.0, 1.0)
            }
            FaultKind::Late { delay_s } => within("delay_s", delay_s, 0.0, 0.5),
            FaultKind::Dropout { share_ratio } => within("share_ratio", share_ratio, 0.0, 1.0),
        }
    }
}

/// Faults at work.
#[derive(Clone, Debug, Default)]
pub struct FaultInjector {
    active: Vec<Active>,
}

/// One fault and what it remembers.
#[derive(Clone, Debug)]
struct Active {
    fault: Fault,
    start_ns: u64,
    end_ns: u64,
    source: Gaussian,
    last_stamp: u64,
    began: bool,
    held: [f32; CHANNELS],
    jump: [f32; CHANNELS],
    delivered: Measurement,
    line: Vec<(Instant, Measurement)>,
    head: usize,
    count: usize,
}

impl FaultInjector {
    /// Faults of `list`, with the random streams of `seed`.
    pub fn new(list: &[Fault], seed: u64) -> Self {
        let nanos = |s: f64| libm::round(s * 1e9) as u64;
        let active = list.iter().enumerate().map(|(i, fault)| Active {
            fault: *fault,
            start_ns: nanos(fault.start_s),
            end_ns: fault.end_s.map_or(u64::MAX, nanos),
            source: stream(seed, &format!("fault.{i}")),
            last_stamp: twinhub_types::NEVER_NS,
            began: false,
            held: [0.0; CHANNELS],
            jump: [0.0; CHANNELS],
            delivered: Measurement::default(),
            line: match fault.kind {
                FaultKind::Late { .. } => {
                    vec![(Instant::START, Measurement::default()); LATE_TICKS]
                }
                _ => Vec::new(),
            },
            head: 0,
            count: 0,
        });
        Self {
            active: active.collect(),
        }
    }

    /// Lays every fault over `told`.
    pub fn apply(&mut self, now: Instant, told: &mut Measurement) {
        for fault in &mut self.active {
            fault.apply(now, told);
        }
    }
}

impl Active {
    fn apply(&mut self, now: Instant, told: &mut Measurement) {
        let (sensor, channels) = self.fault.target.place();
        let ns = now.as_nanos();
        let on = ns >= self.start_ns && ns < self.end_ns;
        if let FaultKind::Late { delay_s } = self.fault.kind {
            self.record(now, told);
            if on {
                let late = self.delayed(now, delay_s);
                copy_sensor(&late, told, sensor);
            }
            return;
        }
        if !on {
            self.delivered = *told;
            self.last_stamp = stamp(told, sensor);
            self.began = false;
            return;
        }
        let fresh = stamp(told, sensor) != self.last_stamp;
        self.last_stamp = stamp(told, sensor);
        if !self.began {
            for i in channels.clone() {
                self.held[i] = *channel(told, i);
            }
            self.began = true;
        }
        let since_s = (ns - self.start_ns) as f64 * 1e-9;
        if let FaultKind::Dropout { share_ratio } = self.fault.kind {
            if fresh && self.source.uniform() >= share_ratio {
                self.delivered = *told;
            }
            copy_sensor(&self.delivered, told, sensor);
            return;
        }
        if let (
            true,
            FaultKind::Spike {
                amount,
                share_ratio,
            },
        ) = (fresh, self.fault.kind)
        {
            for i in channels.clone() {
                let hit = self.source.uniform() < share_ratio;
                let sign = if self.source.uniform() < 0.5 {
                    -1.0
                } else {
                    1.0
                };
                self.jump[i] = if hit { (sign * amount) as f32 } else { 0.0 };
            }
        }
        for i in channels {
            let value = channel(told, i);
            *value = match self.fault.kind {
                FaultKind::Stuck {} => self.held[i],
                FaultKind::Offset { amount } => *value + amount as f32,
                FaultKind::Drift { amount_per_s } => *value + (amount_per_s * since_s) as f32,
                FaultKind::Scale { factor } => *value * factor as f32,
                FaultKind::SignSwap {} => -*value,
                FaultKind::Spike { .. } => *value + self.jump[i],
                FaultKind::Nan {} => f32::NAN,
                FaultKind::Late { .. } | FaultKind::Dropout { .. } => *value,
            };
        }
    }

    fn record(&mut self, now: Instant, told: &Measurement) {
        self.head = (self.head + 1) % LATE_TICKS;
        self.line[self.head] = (now, *told);
        self.count = (self.count + 1).min(LATE_TICKS);
    }

    /// The newest record that is at least `delay_s` old.
    fn delayed(&self, now: Instant, delay_s: f64) -> Measurement {
        let delay = Duration::from_nanos(libm::round(delay_s * 1e9) as u64);
        // records are in order of time: bisect for the number of ticks back
        let age =
            |back: usize| now.since(self.line[(self.head + LATE_TICKS - back) % LATE_TICKS].0);
        if self.count == 0 || age(self.count - 1) < delay {
            return Measurement::default();
        }
        let (mut young, mut old) = (0, self.count - 1);
        while young < old {
            let middle = (young + old) / 2;
            if age(middle) >= delay {
                old = middle
            } else {
                young = middle + 1
            }
        }
        self.line[(self.head + LATE_TICKS - old) % LATE_TICKS].1
    }
}
