//! Disturbances: pushes, kicks, gusts, pulls at the bar, and the laboratory rig's multisine.
//!
//! Each entry of the registry [`Disturbance`] is a pure function of time once built; a course
//! lists several with their start times, and [`Disturbances::at`] adds them up. Whatever acts on
//! the rear frame is a lateral force at a point, exact for the sum as well.

mod gust;
mod pulses;
mod rig;
pub mod sets;
mod side_force;
mod signal;

pub use gust::Gust;
pub use pulses::{HalfSine, HandlebarPull, Kick, Push, Step};
pub use rig::{MultisineForce, RIG_LINES_HZ, RigMultisine};
pub use side_force::SideForce;
pub use signal::{MAX_LINES, Signal, Sines};

use serde::{Deserialize, Serialize};

use crate::admissible::{OutOfRange, within};
use crate::explain::Explain;

/// What acts on the bicycle at one moment, SI, signs of `twinhub_types::conventions`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Wrench {
    /// Lateral force on the rear frame, to the right, N.
    pub lateral_force_n: f64,
    /// Where it acts: x forward of the rear contact of the upright bicycle, m.
    pub point_x_m: f64,
    /// Where it acts: height above the road of the upright bicycle, m.
    pub point_height_m: f64,
    /// Roll torque on the rear frame, Nm; only from forces that cancel each other.
    pub roll_torque_nm: f64,
    /// Yaw torque on the rear frame, Nm; only from forces that cancel each other.
    pub yaw_torque_nm: f64,
    /// Torque on the handlebar, Nm.
    pub steer_torque_nm: f64,
    /// Lateral place of the road under the rear wheel, to the right, m.
    pub rear_road_y_m: f64,
    /// Its velocity, m/s.
    pub rear_road_y_m_s: f64,
    /// Its acceleration, m/s².
    pub rear_road_y_m_s2: f64,
}

/// Forces whose sum is below this share of their magnitudes count as a couple.
const CANCELLED: f64 = 1e-6;

impl Wrench {
    /// Both together. Two forces become one at the point that keeps their torques about the road
    /// and the vertical; forces that cancel leave torques.
    pub fn plus(self, other: Self) -> Self {
        let (a, b) = (self.lateral_force_n, other.lateral_force_n);
        let force = a + b;
        let mut sum = Self {
            lateral_force_n: force,
            roll_torque_nm: self.roll_torque_nm + other.roll_torque_nm,
            yaw_torque_nm: self.yaw_torque_nm + other.yaw_torque_nm,
            steer_torque_nm: self.steer_torque_nm + other.steer_torque_nm,
            rear_road_y_m: self.rear_road_y_m + other.rear_road_y_m,
            rear_road_y_m_s: self.rear_road_y_m_s + other.rear_road_y_m_s,
            rear_road_y_m_s2: self.rear_road_y_m_s2 + other.rear_road_y_m_s2,
            ..Self::default()
        };
        if b == 0.0 {
            (sum.point_x_m, sum.point_height_m) = (self.point_x_m, self.point_height_m);
        } else if a == 0.0 {
            (sum.point_x_m, sum.point_height_m) = (other.point_x_m, other.point_height_m);
        } else if force.abs() > CANCELLED * (a.abs() + b.abs()) {
            sum.point_x_m = (a * self.point_x_m + b * other.point_x_m) / force;
            sum.point_height_m = (a * self.point_height_m + b * other.point_height_m) / force;
        } else {
            (sum.point_x_m, sum.point_height_m) = (self.point_x_m, self.point_height_m);
            sum.roll_torque_nm += b * (other.point_height_m - self.point_height_m);
            sum.yaw_torque_nm += b * (other.point_x_m - self.point_x_m);
        }
        sum
    }
}

/// Where a force acts on the rear frame.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Place {
    /// Centre of mass of the rear frame.
    FrameCentre {},
    /// The saddle.
    Saddle {},
    /// A point of the upright bicycle.
    Point {
        /// Forward of the rear contact, m.
        x_m: f64,
        /// Above the road, m.
        height_m: f64,
    },
}

/// Named points of a bicycle: (x forward of the rear contact, height above the road), m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Places {
    /// Centre of mass of the rear frame, m.
    pub frame_centre_m: [f64; 2],
    /// The saddle, m.
    pub saddle_m: [f64; 2],
}

impl Place {
    fn validate(&self) -> Result<(), OutOfRange> {
        match self {
            Self::Point { x_m, height_m } => {
                within("x_m", *x_m, -5.0, 5.0)?;
                within("height_m", *height_m, 0.0, 5.0)
            }
            Self::FrameCentre {} | Self::Saddle {} => Ok(()),
        }
    }

    fn on(&self, places: &Places) -> [f64; 2] {
        match self {
            Self::FrameCentre {} => places.frame_centre_m,
            Self::Saddle {} => places.saddle_m,
            Self::Point { x_m, height_m } => [*x_m, *height_m],
        }
    }
}

/// What a signal drives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Effect {
    /// Lateral force at a point (x, height), N.
    LateralForce([f64; 2]),
    /// Torque on the handlebar, Nm.
    SteerTorque,
    /// Lateral place of the road under the rear wheel, m.
    RearRoad,
}

/// A disturbance in use: a function of the time since its start.
#[derive(Clone, Debug)]
pub struct Source {
    /// What it does over time.
    pub signal: Signal,
    /// What that drives.
    pub effect: Effect,
}

impl Source {
    /// The wrench `t_s` after the start.
    pub fn at(&self, t_s: f64) -> Wrench {
        let [y, y_1, y_2] = self.signal.at(t_s);
        match self.effect {
            Effect::LateralForce([point_x_m, point_height_m]) => Wrench {
                lateral_force_n: y,
                point_x_m,
                point_height_m,
                ..Wrench::default()
            },
            Effect::SteerTorque => Wrench {
                steer_torque_nm: y,
                ..Wrench::default()
            },
            Effect::RearRoad => Wrench {
                rear_road_y_m: y,
                rear_road_y_m_s: y_1,
                rear_road_y_m_s2: y_2,
                ..Wrench::default()
            },
        }
    }
}

/// A disturbance as configured.
pub trait DisturbanceModel {
    /// What it is, for users.
    fn explain(&self) -> Explain;
    /// Checks every parameter.
    fn validate(&self) -> Result<(), OutOfRange>;
    /// The disturbance in use, on a bicycle with `places`, with the random stream called `name`.
    fn build(&self, places: &Places, seed: u64, name: &str) -> Source;
}

twinhub_types::registry! {
    /// The disturbances.
    #[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
    #[serde(rename_all = "snake_case")]
    pub enum Disturbance: DisturbanceModel {
        /// Constant lateral force for a while.
        Push(Push) = "push",
        /// Half a sine of lateral force.
        HalfSine(HalfSine) = "half_sine",
        /// Lateral force that stays.
        Step(Step) = "step",
        /// Lateral impulse.
        Kick(Kick) = "kick",
        /// Random lateral force in a band of frequencies.
        SideForce(SideForce) = "side_force",
        /// The platform under the rear wheel of the laboratory rig.
        RigMultisine(RigMultisine) = "rig_multisine",
        /// The rig's multisine as a lateral force.
        MultisineForce(MultisineForce) = "multisine_force",
        /// Side wind that comes and goes.
        Gust(Gust) = "gust",
        /// Pull at the handlebar.
        HandlebarPull(HandlebarPull) = "handlebar_pull",
    }
    fn explain(&self) -> Explain;
    fn validate(&self) -> Result<(), OutOfRange>;
    fn build(&self, places: &Places, seed: u64, name: &str) -> Source;
}

/// One line of a course: what, and when it starts.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Timed {
    /// Start, s of ride time.
    pub start_s: f64,
    /// What.
    pub what: Disturbance,
}

/// Why a list of disturbances cannot be built.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("disturbance {number} ({name}): {error}")]
pub struct DisturbanceError {
    /// Which of the list, counted from 1.
    pub number: usize,
    /// Its name in the registry.
    pub name: &'static str,
    /// What is wrong.
    pub error: OutOfRange,
}

/// The disturbances of a course in use.
#[derive(Clone, Debug, Default)]
pub struct Disturbances {
    sources: Vec<(f64, Source)>,
}

impl Disturbances {
    /// The disturbances of `list` on a bicycle with `places`. Each random one has a stream of its
    /// own, named after its kind and its number among its kind.
    pub fn new(list: &[Timed], places: &Places, seed: u64) -> Result<Self, DisturbanceError> {
        let mut sources = Vec::with_capacity(list.len());
        for (i, timed) in list.iter().enumerate() {
            let name = timed.what.name();
            within("start_s", timed.start_s, 0.0, 1e9)
                .and_then(|()| timed.what.validate())
                .map_err(|error| DisturbanceError {
                    number: i + 1,
                    name,
                    error,
                })?;
            let before = list[..i].iter().filter(|t| t.what.name() == name).count();
            let stream = format!("disturbance.{name}.{before}");
            sources.push((timed.start_s, timed.what.build(places, seed, &stream)));
        }
        Ok(Self { sources })
    }

    /// Everything together at ride time `t_s`.
    pub fn at(&self, t_s: f64) -> Wrench {
        self.sources
            .iter()
            .fold(Wrench::default(), |sum, (start_s, source)| {
                sum.plus(source.at(t_s - start_s))
            })
    }
}

#[cfg(test)]
mod tests;
