//! From the study's rides to the predictor's.

use super::CompareError;
use crate::data::{Channel, RideData};
use crate::quantity::Quantity;
use crate::study::{ChannelSpec, HoldKind, LawKind, LawSpec, Role, WindowSpec};
use twinhub_ident::noise::PROCESS_RANGE;
use twinhub_ident::{
    Drive, Equations, Gain, Hold, Law, NoiseLevel, Output, Range, Ride, Sensor, Signal, Window,
};

/// What the predictor needs, and which sensor is which channel.
pub struct Problem {
    pub rides: Vec<Ride>,
    /// For each ride, the channel index of each sensor.
    pub channels: Vec<Vec<usize>>,
    /// Process sources first, then the free sensors.
    pub ranges: Vec<Range>,
    /// Quantity and column of each free sensor.
    pub free: Vec<(Quantity, String)>,
}

impl Problem {
    pub fn new(equations: &Equations, data: &[RideData]) -> Result<Self, CompareError> {
        let mut problem = Self {
            rides: vec![],
            channels: vec![],
            ranges: vec![PROCESS_RANGE; 2],
            free: vec![],
        };
        for ride in data {
            problem.add(equations, ride)?;
        }
        Ok(problem)
    }

    fn add(&mut self, equations: &Equations, data: &RideData) -> Result<(), CompareError> {
        let mut sensors = vec![];
        let mut channels = vec![];
        for (index, channel) in data.channels.iter().enumerate() {
            if channel.spec.role == Role::Output {
                sensors.push(self.sensor(channel, &data.windows)?);
                channels.push(index);
            }
        }
        let inputs = || data.channels.iter().filter(|c| c.spec.role == Role::Input);
        let find = |quantity| {
            inputs()
                .find(|c| c.spec.quantity == quantity)
                .map(input_signal)
                .transpose()
        };
        let Some(speed) = find(Quantity::Speed)? else {
            return Err(CompareError::Channel {
                place: data.spec.place.clone(),
                found: "a ride whose speed_m_s is an output".to_owned(),
                accepted: "speed_m_s with role = \"input\": compare prescribes the speed"
                    .to_owned(),
            });
        };
        let mut drives = vec![];
        for channel in inputs() {
            let spec = &channel.spec;
            let arm = match (spec.quantity, spec.arm_m, spec.point_m) {
                (Quantity::SteerTorque, ..) => [0.0, 1.0],
                (Quantity::RollTorque, ..) => [1.0, 0.0],
                (Quantity::LateralForce, Some(arm), _) => arm,
                (Quantity::LateralForce, None, Some([x, z])) => equations.side_force_arm_m(x, z),
                _ => continue,
            };
            drives.push(Drive {
                signal: input_signal(channel)?,
                arm,
                lag_s: lag_s(spec),
                bias_sd: spec.bias_sd,
                noise_sd: spec.noise_sd.unwrap_or(0.0),
            });
        }
        self.rides.push(Ride {
            speed,
            front_brake: find(Quantity::FrontBrake)?,
            rear_traction: find(Quantity::RearTraction)?,
            drives,
            laws: data.spec.laws.iter().map(law).collect(),
            sensors,
            windows: data
                .windows
                .iter()
                .map(|w| Window {
                    start_s: w.start_s,
                    end_s: w.end_s,
                })
                .collect(),
            clock_jitter_sd_s: data.spec.clock_jitter_sd_s,
        });
        self.channels.push(channels);
        Ok(())
    }

    fn sensor(
        &mut self,
        channel: &Channel,
        windows: &[WindowSpec],
    ) -> Result<Sensor, CompareError> {
        let spec = &channel.spec;
        let output = match spec.quantity {
            Quantity::Roll => Output::Roll,
            Quantity::RollRate => Output::RollRate,
            Quantity::Steer => Output::Steer,
            Quantity::SteerRate => Output::SteerRate,
            Quantity::Yaw => Output::Yaw,
            Quantity::YawRate => Output::YawRate,
            Quantity::LateralAccel => {
                let [x_m, z_m] = spec.point_m.unwrap_or([0.0, 0.0]);
                Output::LateralAccel { x_m, z_m }
            }
            other => {
                return Err(CompareError::Channel {
                    place: spec.place.clone(),
                    found: format!("output {other}"),
                    accepted: "outputs of roll, steer and yaw: compare prescribes the speed"
                        .to_owned(),
                });
            }
        };
        let inside = |t: f64| windows.iter().any(|w| (w.start_s..w.end_s).contains(&t));
        let noise = match spec.noise_sd {
            Some(sd) => NoiseLevel::Known(sd),
            None => {
                let key = (spec.quantity, spec.column.clone());
                let known = self.free.iter().position(|k| *k == key);
                let index = match known {
                    Some(index) => index,
                    None => {
                        let values: Vec<f64> = channel
                            .samples
                            .iter()
                            .filter(|s| inside(s.0))
                            .map(|s| s.1)
                            .collect();
                        let Some(range) = noise_range(&values) else {
                            return Err(CompareError::Channel {
                                place: spec.place.clone(),
                                found: format!(
                                    "column {} that does not vary in the windows",
                                    spec.column
                                ),
                                accepted: "an output that varies, or role = \"check\"".to_owned(),
                            });
                        };
                        self.ranges.push(range);
                        self.free.push(key);
                        self.free.len() - 1
                    }
                };
                NoiseLevel::Free(index)
            }
        };
        Ok(Sensor {
            output,
            samples: channel.samples.clone(),
            noise,
            bias_sd: spec.bias_sd,
            delay_s: spec.delay_s,
            quantum: spec.quantum,
            lag_s: lag_s(spec),
            moving_average_s: spec.moving_average_s,
        })
    }
}

/// Where the noise of a channel may lie: about its second differences, within its own spread.
pub(crate) fn noise_range(values: &[f64]) -> Option<Range> {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let sd = (values.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / count).sqrt();
    if values.len() < 3 || !(sd.is_finite() && sd > 0.0) {
        return None;
    }
    let mut rough: Vec<f64> = values
        .windows(3)
        .map(|w| (w[0] - 2.0 * w[1] + w[2]).abs())
        .collect();
    rough.sort_by(f64::total_cmp);
    // Median of |N(0, 6 sd²)|.
    let start = rough[rough.len() / 2] / (0.6745 * 6.0f64.sqrt());
    Some(Range {
        start: start.clamp(1e-2 * sd, sd),
        least: 1e-4 * sd,
        most: 3.0 * sd,
    })
}

fn lag_s(spec: &ChannelSpec) -> f64 {
    if spec.lowpass_hz > 0.0 {
        1.0 / (2.0 * std::f64::consts::PI * spec.lowpass_hz)
    } else {
        0.0
    }
}

/// An input in true time. A running mean of length T has the phase of a delay of T/2 exactly; its
/// gain is taken as one.
fn input_signal(channel: &Channel) -> Result<Signal, CompareError> {
    let spec = &channel.spec;
    let shift = spec.delay_s + 0.5 * spec.moving_average_s;
    let hold = match spec.hold {
        HoldKind::Zero => Hold::Zero,
        HoldKind::Linear => Hold::Linear,
    };
    Signal::new(channel.samples.iter().map(|(t, v)| (t - shift, *v)), hold).map_err(|e| {
        CompareError::Channel {
            place: spec.place.clone(),
            found: e.to_string(),
            accepted: "samples in the order of time".to_owned(),
        }
    })
}

fn law(spec: &LawSpec) -> Law {
    Law {
        of: match spec.of {
            Quantity::Roll => Output::Roll,
            Quantity::Steer => Output::Steer,
            Quantity::SteerRate => Output::SteerRate,
            Quantity::YawRate => Output::YawRate,
            _ => Output::RollRate,
        },
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
