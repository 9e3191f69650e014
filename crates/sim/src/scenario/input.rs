//! What acts on the bicycle over time, channel by channel.

use serde::{Deserialize, Serialize};
use twinhub_plant::multibody;

/// What is wrong with a number: its key, what was found, what is accepted.
pub(super) type Wrong = (String, f64, &'static str);

/// A channel that follows a shape; several on one channel add up.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Input {
    /// Which one.
    pub channel: Channel,
    /// How it goes over time, in the unit that the channel's name ends with.
    pub shape: Shape,
}

/// What can act.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Channel {
    /// Both motors: the front one brakes with this torque, the rear one drives with the same force
    /// at the road, Nm.
    PairNm,
    /// Front motor, braking positive, Nm.
    FrontBrakeNm,
    /// Rear motor, driving positive, Nm.
    RearTractionNm,
    /// Driving force of the pedals at the rear contact, N.
    PedalForceN,
    /// Rider's torque on the handlebar, Nm.
    SteerTorqueNm,
    /// Muscles between frame and trunk: lean to the right, Nm.
    TrunkLeanTorqueNm,
    /// Muscles between frame and trunk: pitch backward, Nm.
    TrunkPitchTorqueNm,
    /// Muscles between frame and trunk: twist to the right, Nm.
    TrunkTwistTorqueNm,
    /// Muscles of the left leg, knee outward, Nm.
    LeftLegTorqueNm,
    /// Muscles of the right leg, knee outward, Nm.
    RightLegTorqueNm,
}

/// A value over time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Shape {
    /// Zero, but for a while.
    Pulse {
        /// Start, s.
        from_s: f64,
        /// End, s.
        to_s: f64,
        /// Value between.
        value: f64,
        /// Time that it takes to rise and to fall, inside the pulse, s.
        #[serde(default)]
        ramp_s: f64,
    },
    /// Straight lines between points `[t_s, value]`; zero before the first, the last value after
    /// the last.
    Points(Vec<[f64; 2]>),
    /// value · sin(2π f (t - from)) for a while.
    Sine {
        /// Start, s.
        from_s: f64,
        /// End, s.
        to_s: f64,
        /// Amplitude.
        value: f64,
        /// Frequency, Hz.
        frequency_hz: f64,
    },
}

impl Shape {
    /// The value at a time.
    pub fn at(&self, t_s: f64) -> f64 {
        match self {
            Self::Pulse {
                from_s,
                to_s,
                value,
                ramp_s,
            } => {
                // The grid of steps may miss an edge by rounding.
                let inside = (t_s - from_s).min(to_s - t_s);
                if inside < -1e-9 || (to_s - t_s) < 1e-9 {
                    0.0
                } else if inside < *ramp_s {
                    value * inside.max(0.0) / ramp_s
                } else {
                    *value
                }
            }
            Self::Points(points) => match points.iter().position(|p| p[0] > t_s) {
                None => points.last().map_or(0.0, |p| p[1]),
                Some(0) => 0.0,
                Some(i) => {
                    let (a, b) = (points[i - 1], points[i]);
                    a[1] + (t_s - a[0]) / (b[0] - a[0]) * (b[1] - a[1])
                }
            },
            Self::Sine {
                from_s,
                to_s,
                value,
                frequency_hz,
            } => {
                if t_s < from_s - 1e-9 || t_s > to_s - 1e-9 {
                    return 0.0;
                }
                value * libm::sin(2.0 * core::f64::consts::PI * frequency_hz * (t_s - from_s))
            }
        }
    }

    fn numbers(&self) -> Vec<(String, f64)> {
        match self {
            Self::Pulse {
                from_s,
                to_s,
                value,
                ramp_s,
            } => vec![
                ("pulse.from_s".to_owned(), *from_s),
                ("pulse.to_s".to_owned(), *to_s),
                ("pulse.value".to_owned(), *value),
                ("pulse.ramp_s".to_owned(), *ramp_s),
            ],
            Self::Points(points) => (points.iter().enumerate())
                .flat_map(|(i, p)| {
                    [
                        (format!("points.{i}.0"), p[0]),
                        (format!("points.{i}.1"), p[1]),
                    ]
                })
                .collect(),
            Self::Sine {
                from_s,
                to_s,
                value,
                frequency_hz,
            } => vec![
                ("sine.from_s".to_owned(), *from_s),
                ("sine.to_s".to_owned(), *to_s),
                ("sine.value".to_owned(), *value),
                ("sine.frequency_hz".to_owned(), *frequency_hz),
            ],
        }
    }
}

impl Input {
    /// Checks the numbers.
    pub(super) fn check(&self) -> Result<(), Wrong> {
        let key = |name: &str| format!("shape.{name}");
        for (name, value) in self.shape.numbers() {
            if !(value.abs() <= 1e6) {
                return Err((key(&name), value, "-1e6 to 1e6"));
            }
        }
        match &self.shape {
            Shape::Pulse {
                from_s,
                to_s,
                ramp_s,
                ..
            } => {
                if to_s <= from_s {
                    return Err((key("pulse.to_s"), *to_s, "later than from_s"));
                }
                if !(*ramp_s >= 0.0 && 2.0 * ramp_s <= to_s - from_s) {
                    return Err((key("pulse.ramp_s"), *ramp_s, "0 to half the pulse"));
                }
            }
            Shape::Points(points) => {
                if points.is_empty() {
                    return Err((key("points"), 0.0, "at least one point"));
                }
                for (i, pair) in points.windows(2).enumerate() {
                    if pair[1][0] <= pair[0][0] {
                        let name = format!("points.{}.0", i + 1);
                        return Err((key(&name), pair[1][0], "later than the point before"));
                    }
                }
            }
            Shape::Sine {
                from_s,
                to_s,
                frequency_hz,
                ..
            } => {
                if to_s <= from_s {
                    return Err((key("sine.to_s"), *to_s, "later than from_s"));
                }
                if !(*frequency_hz > 0.0 && *frequency_hz <= 100.0) {
                    return Err((
                        key("sine.frequency_hz"),
                        *frequency_hz,
                        "above 0, at most 100",
                    ));
                }
            }
        }
        Ok(())
    }

    /// Adds what acts at `t_s`; the pair balances on wheels of these radii (rear, front). Gives
    /// the pedal force, N.
    pub(super) fn add(&self, t_s: f64, radii_m: [f64; 2], to: &mut multibody::Input) -> f64 {
        let value = self.shape.at(t_s);
        match self.channel {
            Channel::PairNm => {
                to.front_brake_nm += value;
                to.rear_traction_nm += value * radii_m[0] / radii_m[1];
            }
            Channel::FrontBrakeNm => to.front_brake_nm += value,
            Channel::RearTractionNm => to.rear_traction_nm += value,
            Channel::PedalForceN => return value,
            Channel::SteerTorqueNm => to.steer_torque_nm += value,
            Channel::TrunkLeanTorqueNm => to.trunk_torque_nm[0] += value,
            Channel::TrunkPitchTorqueNm => to.trunk_torque_nm[1] += value,
            Channel::TrunkTwistTorqueNm => to.trunk_torque_nm[2] += value,
            Channel::LeftLegTorqueNm => to.leg_torque_nm[0] += value,
            Channel::RightLegTorqueNm => to.leg_torque_nm[1] += value,
        }
        0.0
    }
}
