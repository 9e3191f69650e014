//! A measured ride as the engine sees it: what drives the bicycle, what was read, in which windows.

use crate::data::{Channel, RideData};
use crate::quantity::Quantity;
use crate::study::{HoldKind, LawKind, LawSpec, Place, Role, Use};
use twinhub_ident::{Gain, Hold, Signal};

/// An input that pushes sideways or turns the bar.
#[derive(Clone, Debug)]
pub struct Drive {
    pub quantity: Quantity,
    pub signal: Signal,
    pub arm: Arm,
    /// Filter of the recorder, undone between the samples.
    pub lag_s: f64,
    pub bias_sd: f64,
    pub noise_sd: f64,
    pub interval_s: f64,
}

/// How a drive acts on roll and steer.
#[derive(Clone, Copy, Debug)]
pub enum Arm {
    Fixed([f64; 2]),
    /// A side force at (x, z).
    Point([f64; 2]),
}

/// Noise of a sensor: given, or the index of one that is estimated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum NoiseKind {
    Known(f64),
    Free(usize),
}

/// One output channel.
#[derive(Clone, Debug)]
pub struct Sensor {
    pub quantity: Quantity,
    pub column: String,
    pub samples: Vec<(f64, f64)>,
    pub noise: NoiseKind,
    pub bias_sd: f64,
    pub delay_s: f64,
    pub quantum: f64,
    pub lag_s: f64,
    pub moving_average_s: f64,
    pub point_m: [f64; 2],
}

impl Sensor {
    /// Whether it belongs to the longitudinal equation.
    pub fn is_longitudinal(&self) -> bool {
        !self.quantity.is_lateral()
    }
}

/// A known feedback.
#[derive(Clone, Debug)]
pub struct Law {
    pub of: Quantity,
    pub arm: [f64; 2],
    pub gain: Gain,
    pub limit_nm: f64,
    pub delay_s: f64,
}

/// One ride, restricted to the windows of one use.
#[derive(Clone, Debug)]
pub struct Ride {
    pub file: String,
    pub rider: String,
    pub place: Place,
    /// None: predicted from the wheels' torques.
    pub speed: Option<Signal>,
    pub front_brake: Option<Signal>,
    pub rear_traction: Option<Signal>,
    pub drives: Vec<Drive>,
    pub laws: Vec<Law>,
    pub sensors: Vec<Sensor>,
    pub windows: Vec<[f64; 2]>,
    pub clock_jitter_sd_s: f64,
    pub crank: Option<Signal>,
    pub wheel: Option<Signal>,
    pub trunk: Option<Signal>,
    pub hands_on: bool,
    pub road: bool,
    /// Along the road of the study or back, see `twinhub_mechanism::Moment`.
    pub way: f64,
}

/// Why a channel cannot be used.
#[derive(Debug)]
pub struct Refusal {
    pub place: Place,
    pub found: String,
    pub accepted: String,
}

/// Free noise levels: one for each quantity and column.
#[derive(Clone, Debug, Default)]
pub struct FreeNoise {
    pub keys: Vec<(Quantity, String)>,
    /// Start, least, most.
    pub range: Vec<[f64; 3]>,
}

impl FreeNoise {
    fn index(&mut self, channel: &Channel, inside: impl Fn(f64) -> bool) -> Option<usize> {
        let key = (channel.spec.quantity, channel.spec.column.clone());
        if let Some(index) = self.keys.iter().position(|k| *k == key) {
            return Some(index);
        }
        let values: Vec<f64> = channel
            .samples
            .iter()
            .filter(|s| inside(s.0))
            .map(|s| s.1)
            .collect();
        let range = crate::compare::noise_range(&values)?;
        self.keys.push(key);
        self.range.push([range.start, range.least, range.most]);
        Some(self.keys.len() - 1)
    }
}

impl Ride {
    /// The windows of one use, or none if the ride has no such window.
    pub fn new(data: &RideData, usage: Use, free: &mut FreeNoise) -> Result<Option<Self>, Refusal> {
        let windows: Vec<[f64; 2]> = data
            .windows
            .iter()
            .filter(|w| w.usage == usage)
            .map(|w| [w.start_s, w.end_s])
            .collect();
        if windows.is_empty() {
            return Ok(None);
        }
        let of = |role: Role| data.channels.iter().filter(move |c| c.spec.role == role);
        let input = |quantity| {
            of(Role::Input)
                .find(|c| c.spec.quantity == quantity)
                .map(signal)
                .transpose()
        };
        let any = |quantity| {
            data.channels
                .iter()
                .find(|c| c.spec.quantity == quantity && !c.samples.is_empty())
        };
        let mut drives = vec![];
        for channel in of(Role::Input) {
            let spec = &channel.spec;
            let arm = match (spec.quantity, spec.arm_m, spec.point_m) {
                (Quantity::SteerTorque, ..) => Arm::Fixed([0.0, 1.0]),
                (Quantity::RollTorque, ..) => Arm::Fixed([1.0, 0.0]),
                (Quantity::LateralForce, Some(arm), _) => Arm::Fixed(arm),
                (Quantity::LateralForce, None, Some(point)) => Arm::Point(point),
                _ => continue,
            };
            drives.push(Drive {
                quantity: spec.quantity,
                signal: signal(channel)?,
                arm,
                lag_s: lag_s(spec.lowpass_hz),
                bias_sd: spec.bias_sd,
                noise_sd: spec.noise_sd.unwrap_or(0.0),
                interval_s: mean_interval_s(&channel.samples),
            });
        }
        let inside = |t: f64| windows.iter().any(|w| t >= w[0] - 1e-7 && t < w[1] - 1e-7);
        let mut sensors = vec![];
        for channel in of(Role::Output) {
            let spec = &channel.spec;
            let noise = match spec.noise_sd {
                Some(sd) => NoiseKind::Known(sd),
                None => match free.index(channel, inside) {
                    Some(index) => NoiseKind::Free(index),
                    None => {
                        return Err(Refusal {
                            place: spec.place.clone(),
                            found: format!(
                                "column {} that does not vary in the windows",
                                spec.column
                            ),
                            accepted: "an output that varies, or role = \"check\"".to_owned(),
                        });
                    }
                },
            };
            sensors.push(Sensor {
                quantity: spec.quantity,
                column: spec.column.clone(),
                samples: channel
                    .samples
                    .iter()
                    .copied()
                    .filter(|s| inside(s.0))
                    .collect(),
                noise,
                bias_sd: spec.bias_sd,
                delay_s: spec.delay_s,
                quantum: spec.quantum,
                lag_s: lag_s(spec.lowpass_hz),
                moving_average_s: spec.moving_average_s,
                point_m: spec.point_m.unwrap_or([0.0, 0.0]),
            });
        }
        let speed = input(Quantity::Speed)?;
        if speed.is_none()
            && !sensors.iter().any(|s| {
                matches!(
                    s.quantity,
                    Quantity::Speed | Quantity::RearWheelRate | Quantity::FrontWheelRate
                )
            })
        {
            return Err(Refusal {
                place: data.spec.place.clone(),
                found: "a ride without any speed".to_owned(),
                accepted: "speed_m_s as input or output, or a wheel rate as output".to_owned(),
            });
        }
        Ok(Some(Self {
            file: data.spec.file.clone(),
            rider: data.spec.rider.clone(),
            place: data.spec.place.clone(),
            front_brake: input(Quantity::FrontBrake)?,
            rear_traction: input(Quantity::RearTraction)?,
            drives,
            laws: data.spec.laws.iter().map(law).collect(),
            sensors,
            clock_jitter_sd_s: data.spec.clock_jitter_sd_s,
            crank: any(Quantity::CrankAngle)
                .map(|c| unwrapped(c, &data.spec.place))
                .transpose()?,
            wheel: any(Quantity::FrontWheelRate).map(integrated).transpose()?,
            trunk: any(Quantity::TrunkLean).map(signal).transpose()?,
            speed,
            windows,
            hands_on: data.spec.hands == Some(crate::study::Hands::On),
            road: data.spec.ground == Some(crate::study::Ground::Road),
            way: 1.0,
        }))
    }
}

/// Time constant of a first-order filter.
pub fn lag_s(lowpass_hz: f64) -> f64 {
    if lowpass_hz > 0.0 {
        0.5 / (std::f64::consts::PI * lowpass_hz)
    } else {
        0.0
    }
}

fn mean_interval_s(samples: &[(f64, f64)]) -> f64 {
    match samples {
        [first, .., last] => (last.0 - first.0) / (samples.len() - 1) as f64,
        _ => 0.0,
    }
}

fn refuse(channel: &Channel, found: String) -> Refusal {
    Refusal {
        place: channel.spec.place.clone(),
        found,
        accepted: "samples in the order of time".to_owned(),
    }
}

/// In true time: known delays and running means are taken off.
fn signal(channel: &Channel) -> Result<Signal, Refusal> {
    let spec = &channel.spec;
    let shift = spec.delay_s + 0.5 * spec.moving_average_s;
    let hold = match spec.hold {
        HoldKind::Zero => Hold::Zero,
        HoldKind::Linear => Hold::Linear,
    };
    Signal::new(channel.samples.iter().map(|(t, v)| (t - shift, *v)), hold)
        .map_err(|e| refuse(channel, e.to_string()))
}

/// An angle that may be logged within one turn.
fn unwrapped(channel: &Channel, _place: &Place) -> Result<Signal, Refusal> {
    let mut turns = 0.0;
    let mut before: Option<f64> = None;
    let samples: Vec<(f64, f64)> = channel
        .samples
        .iter()
        .map(|&(t, v)| {
            if let Some(b) = before {
                let jump = v - b;
                if jump < -std::f64::consts::PI {
                    turns += 1.0;
                } else if jump > std::f64::consts::PI {
                    turns -= 1.0;
                }
            }
            before = Some(v);
            (
                t - channel.spec.delay_s,
                v + turns * 2.0 * std::f64::consts::PI,
            )
        })
        .collect();
    Signal::new(samples, Hold::Linear).map_err(|e| refuse(channel, e.to_string()))
}

/// The angle of a wheel from its rate.
fn integrated(channel: &Channel) -> Result<Signal, Refusal> {
    let mut angle = 0.0;
    let mut before: Option<(f64, f64)> = None;
    let samples: Vec<(f64, f64)> = channel
        .samples
        .iter()
        .map(|&(t, v)| {
            if let Some((t0, v0)) = before {
                angle += 0.5 * (v + v0) * (t - t0);
            }
            before = Some((t, v));
            (t - channel.spec.delay_s, angle)
        })
        .collect();
    Signal::new(samples, Hold::Linear).map_err(|e| refuse(channel, e.to_string()))
}

fn law(spec: &LawSpec) -> Law {
    Law {
        of: spec.of,
        arm: if spec.quantity == Quantity::RollTorque {
            [1.0, 0.0]
        } else {
            [0.0, 1.0]
        },
        gain: match (spec.kind, spec.speed0_m_s) {
            (LawKind::SpeedScheduledRate, Some(speed0_m_s)) => Gain::SpeedScheduled {
                gain: spec.gain,
                speed0_m_s,
            },
            _ => Gain::Constant(spec.gain),
        },
        limit_nm: spec.limit_nm,
        delay_s: spec.delay_s,
    }
}
