//! From what was true to what was recorded: noise white and coloured, bias, resolution, a clock that
//! jitters, channels slightly apart in time, missing samples.

use crate::random::{Coloured, Stream};
use crate::ride::{Moment, SAMPLE_S, Track};
use crate::truth::SensorTruth;

/// One recorded channel.
#[derive(Clone, Debug)]
pub struct Recorded {
    pub spec: ChannelKind,
    /// NaN where the sample was lost.
    pub values: Vec<f64>,
}

/// A kind of channel and how its sensor errs.
#[derive(Clone, Copy, Debug)]
pub struct ChannelKind {
    pub column: &'static str,
    /// In the words of study files.
    pub quantity: &'static str,
    pub noise_sd: f64,
    /// Declared spread of the constant offset of each ride.
    pub bias_sd: f64,
    pub quantum: f64,
    /// Chance that a sample is lost.
    pub lost: f64,
    /// What a step of an input does.
    pub steps: bool,
    read: fn(&Moment) -> f64,
    /// Of what steps with the motors: what it was just before.
    before: fn(&Moment) -> f64,
}

/// Spread of the time between channels that should be simultaneous, and of the clock.
const SKEW_SD_S: f64 = 0.0002;
pub const JITTER_SD_S: f64 = 0.0003;
/// Coloured part of the noise: level against the white part, and correlation time.
const COLOURED_RATIO: f64 = 0.15;
const COLOURED_TIME_S: f64 = 0.1;

macro_rules! channels {
    (@before |$m:ident| $read:expr) => { |$m: &Moment| $read };
    (@before |$m:ident| $read:expr, $before:expr) => { |$m: &Moment| $before };
    ($($name:ident: $column:literal $quantity:literal noise $noise:literal bias $bias:literal
        quantum $quantum:literal lost $lost:literal steps $steps:literal |$m:ident| $read:expr $(, before $before:expr)?;)*) => {
        $(pub const $name: ChannelKind = ChannelKind {
            column: $column,
            quantity: $quantity,
            noise_sd: $noise,
            bias_sd: $bias,
            quantum: $quantum,
            lost: $lost,
            steps: $steps,
            read: |$m| $read,
            before: channels!(@before |$m| $read $(, $before)?),
        };)*
    };
}

channels! {
    SPEED: "speed" "speed_m_s" noise 0.01 bias 0.0 quantum 0.001 lost 0.002 steps false |m| m.speed_m_s;
    TORQUE: "steer_torque" "steer_torque_nm" noise 0.02 bias 0.0 quantum 0.005 lost 0.0 steps false |m| m.steer_torque_nm;
    PULL: "pull" "lateral_force_n" noise 0.5 bias 0.0 quantum 0.1 lost 0.0 steps false |m| m.pull_n;
    FRONT_BRAKE: "front_brake" "front_brake_nm" noise 0.0 bias 0.0 quantum 0.02 lost 0.0 steps true |m| m.front_brake_nm;
    REAR_TRACTION: "rear_traction" "rear_traction_nm" noise 0.0 bias 0.0 quantum 0.02 lost 0.0 steps true |m| m.rear_traction_nm;
    ROLL: "roll" "roll_rad" noise 0.003 bias 0.01 quantum 0.0005 lost 0.01 steps false |m| m.roll_rad;
    ROLL_RATE: "roll_rate" "roll_rate_rad_s" noise 0.008 bias 0.01 quantum 0.001 lost 0.01 steps false |m| m.roll_rate_rad_s;
    STEER: "steer" "steer_rad" noise 0.002 bias 0.005 quantum 0.0005 lost 0.01 steps false |m| m.steer_rad;
    YAW_RATE: "yaw_rate" "yaw_rate_rad_s" noise 0.008 bias 0.01 quantum 0.001 lost 0.01 steps false |m| m.yaw_rate_rad_s;
    ACCEL: "accel" "longitudinal_accel_m_s2" noise 0.05 bias 0.03 quantum 0.002 lost 0.01 steps false |m| m.accel_m_s2, before m.accel_before_m_s2;
    FRONT_WHEEL: "front_wheel" "front_wheel_rate_rad_s" noise 0.03 bias 0.0 quantum 0.01 lost 0.01 steps false |m| m.front_wheel_rad_s;
    REAR_WHEEL: "rear_wheel" "rear_wheel_rate_rad_s" noise 0.03 bias 0.0 quantum 0.01 lost 0.01 steps false |m| m.rear_wheel_rad_s;
    CADENCE: "cadence" "cadence_rad_s" noise 0.02 bias 0.0 quantum 0.0 lost 0.0 steps false |m| m.cadence_rad_s;
    CRANK: "crank" "crank_angle_rad" noise 0.01 bias 0.0 quantum 0.0 lost 0.0 steps false |m| m.crank_rad;
    YAW: "yaw" "yaw_rad" noise 0.02 bias 0.0 quantum 0.0 lost 0.0 steps false |m| m.yaw_rad;
}

/// Time stamps and readings of one ride.
#[derive(Clone, Debug)]
pub struct Recording {
    pub t_s: Vec<f64>,
    pub channels: Vec<Recorded>,
}

/// Reads the track through every sensor of `kinds`.
pub fn record(
    track: &Track,
    kinds: &[ChannelKind],
    sensors: &SensorTruth,
    direction: f64,
    stream: &impl Fn(&str) -> Stream,
) -> Recording {
    let duration_s = track.step_s * track.moments.len() as f64;
    let samples = libm::round(duration_s / SAMPLE_S) as usize - 1;
    let mut clock = stream("clock");
    // The stamps are even; the samples are taken a little off.
    let at: Vec<f64> = (0..samples)
        .map(|k| k as f64 * SAMPLE_S + JITTER_SD_S * clock.normal_within(3.0))
        .collect();
    let channels = kinds
        .iter()
        .map(|kind| {
            let stream = |what: &str| stream(&format!("{} {what}", kind.column));
            let mut once = stream("once");
            let skew_s = if kind.steps {
                0.0
            } else {
                SKEW_SD_S * once.normal()
            };
            let bias = kind.bias_sd * once.normal_within(2.0);
            let mut white = stream("white");
            let sd = COLOURED_RATIO * kind.noise_sd;
            let mut coloured = Coloured::new(sd, COLOURED_TIME_S, SAMPLE_S, stream("coloured"));
            let mut lost = stream("lost");
            let values = at.iter().map(|t| {
                let truth = reading(track, kind, sensors, direction, t - skew_s);
                let noise = kind.noise_sd * white.normal() + coloured.step();
                let value = truth + bias + noise;
                let value = match kind.quantum > 0.0 {
                    true => kind.quantum * libm::round(value / kind.quantum),
                    false => value,
                };
                if lost.uniform() < kind.lost {
                    f64::NAN
                } else {
                    value
                }
            });
            Recorded {
                spec: *kind,
                values: values.collect(),
            }
        })
        .collect();
    Recording {
        t_s: (0..samples).map(|k| k as f64 * SAMPLE_S).collect(),
        channels,
    }
}

/// What a sensor without noise would say.
fn reading(track: &Track, kind: &ChannelKind, s: &SensorTruth, direction: f64, t_s: f64) -> f64 {
    let read = |t_s: f64| {
        let last = track.moments.len() - 1;
        let place = (t_s / track.step_s).clamp(0.0, last as f64 - 1e-6);
        let (k, part) = (place as usize, place.fract());
        let a = (kind.read)(&track.moments[k]);
        // A command steps; what is in between does not exist.
        let b = if kind.steps {
            a
        } else {
            (kind.before)(&track.moments[(k + 1).min(last)])
        };
        a + part * (b - a)
    };
    match kind.column {
        "roll" => read(t_s) + s.roll_bias_rad,
        "steer" => s.steer_scale * read(t_s - s.steer_delay_s) + s.steer_bias_rad,
        "roll_rate" => {
            let t = t_s - s.roll_rate_delay_s;
            let yaw = reading(track, &YAW_RATE, s, direction, t);
            let (sin, cos) = libm::sincos(s.gyro_rotation_rad);
            cos * read(t) + sin * yaw
        }
        "speed" => s.speed_scale * read(t_s),
        // A command is known at its own time, not at that of a late sample.
        "front_brake" | "rear_traction" => read(SAMPLE_S * libm::round(t_s / SAMPLE_S) + 1e-7),
        "yaw" if direction < 0.0 => read(t_s) + core::f64::consts::PI,
        _ => read(t_s),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bicycle::Bicycle;
    use crate::truth::Truth;

    fn ramp() -> Track {
        let moment = |k: usize| Moment {
            steer_rad: 0.1 * libm::sin(0.002 * k as f64),
            roll_rate_rad_s: 0.3,
            yaw_rate_rad_s: 0.5,
            ..Moment::default()
        };
        Track {
            step_s: 0.002,
            moments: (0..20_000).map(moment).collect(),
        }
    }

    #[test]
    fn a_delay_shows_the_past_and_a_scale_scales() {
        let mut s = Truth::clean(Bicycle::benchmark()).sensors;
        s.steer_delay_s = 0.02;
        s.steer_scale = 2.0;
        let found = reading(&ramp(), &STEER, &s, 1.0, 1.0);
        assert!((found - 0.2 * libm::sin(0.98)).abs() < 1e-9);
    }

    #[test]
    fn a_turned_gyro_sees_yaw() {
        let mut s = Truth::clean(Bicycle::benchmark()).sensors;
        s.gyro_rotation_rad = 0.1;
        let found = reading(&ramp(), &ROLL_RATE, &s, 1.0, 1.0);
        assert!((found - 0.3 * 0.1f64.cos() - 0.5 * 0.1f64.sin()).abs() < 1e-12);
    }

    #[test]
    fn noise_has_its_level_and_samples_get_lost() {
        let s = Truth::clean(Bicycle::benchmark()).sensors;
        let stream = |name: &str| Stream::new(1, name);
        let found = record(&ramp(), &[STEER], &s, 1.0, &stream);
        let channel = &found.channels[0];
        let lost = channel.values.iter().filter(|v| v.is_nan()).count() as f64;
        assert!((lost / channel.values.len() as f64 - 0.01).abs() < 0.007);
        let errors: Vec<f64> = (channel.values.iter().zip(&found.t_s))
            .filter(|(v, _)| !v.is_nan())
            .map(|(v, t)| v - 0.1 * t.sin())
            .collect();
        let mean = errors.iter().sum::<f64>() / errors.len() as f64;
        let sd =
            (errors.iter().map(|e| (e - mean).powi(2)).sum::<f64>() / errors.len() as f64).sqrt();
        assert!((sd / 0.00203 - 1.0).abs() < 0.05, "{sd}");
        assert!(mean.abs() < 0.011);
    }
}
