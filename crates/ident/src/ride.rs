//! One measured ride as the predictor sees it: what drives the bicycle, what was read, and which
//! known feedback was at work.

use crate::signal::Signal;

/// What a sensor reads, in the signs of `twinhub_types::conventions`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Output {
    Roll,
    Steer,
    /// Also that of a gyro fixed to the rear frame: the same to first order.
    RollRate,
    SteerRate,
    Yaw,
    YawRate,
    /// Specific force to the right in the rear frame, at (x, z) from the rear contact.
    LateralAccel {
        x_m: f64,
        z_m: f64,
    },
}

/// Standard deviation of a sensor's white noise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum NoiseLevel {
    Known(f64),
    /// Estimated: an index into the estimates, which several rides may share.
    Free(usize),
}

/// One output channel.
#[derive(Clone, Debug)]
pub struct Sensor {
    pub output: Output,
    /// Time and reading, missing ones left out.
    pub samples: Vec<(f64, f64)>,
    pub noise: NoiseLevel,
    /// Standard deviation of a constant offset of the whole ride, 0: none.
    pub bias_sd: f64,
    /// The reading at t tells the truth of t - delay.
    pub delay_s: f64,
    /// Resolution; its variance quantum²/12 is added to that of the noise.
    pub quantum: f64,
    /// Time constant of a first-order filter of the recorder, 0: none.
    pub lag_s: f64,
    /// Length of a running mean of the recorder, 0: none.
    pub moving_average_s: f64,
}

/// One measured force or torque that drives the bicycle.
#[derive(Clone, Debug)]
pub struct Drive {
    pub signal: Signal,
    /// Roll and steer torque per unit.
    pub arm: [f64; 2],
    /// Time constant of a first-order filter of the recorder, undone exactly between the samples.
    pub lag_s: f64,
    pub bias_sd: f64,
    /// Known white noise of the samples, carried into the state.
    pub noise_sd: f64,
}

/// A known feedback: torque = gain(v) * output, within a limit, after a delay.
#[derive(Clone, Debug, PartialEq)]
pub struct Law {
    pub of: Output,
    /// Roll and steer torque per newton metre of the law.
    pub arm: [f64; 2],
    pub gain: Gain,
    /// Infinite: none.
    pub limit_nm: f64,
    pub delay_s: f64,
}

/// How a law's gain depends on speed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Gain {
    Constant(f64),
    /// gain * (speed0 - speed), zero above speed0.
    SpeedScheduled {
        gain: f64,
        speed0_m_s: f64,
    },
}

impl Gain {
    /// The gain at a speed.
    pub fn at(&self, speed_m_s: f64) -> f64 {
        match *self {
            Self::Constant(gain) => gain,
            Self::SpeedScheduled { gain, speed0_m_s } => gain * (speed0_m_s - speed_m_s).max(0.0),
        }
    }
}

/// A part [start, end) of the ride that is used, with an initial state of its own.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Window {
    pub start_s: f64,
    pub end_s: f64,
}

/// Everything about one ride.
#[derive(Clone, Debug)]
pub struct Ride {
    pub speed: Signal,
    pub front_brake: Option<Signal>,
    pub rear_traction: Option<Signal>,
    pub drives: Vec<Drive>,
    pub laws: Vec<Law>,
    pub sensors: Vec<Sensor>,
    /// Ordered, not overlapping.
    pub windows: Vec<Window>,
    /// Standard deviation of the time stamps.
    pub clock_jitter_sd_s: f64,
}
