//! The bicycle that is ridden, of either plant, and what sensors, controller and log need of it.

use crate::error::SetupError;
use serde::{Deserialize, Serialize};
use twinhub_plant::disturbance::Places;
use twinhub_plant::multibody;
use twinhub_plant::rider::Limbs;
use twinhub_plant::tyre::TyreModel as _;

/// A bicycle with its values.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ResolvedBicycle {
    /// Name or file.
    pub name: String,
    /// Where the values come from.
    pub source: String,
    /// Values.
    pub parameters: BicycleParameters,
}

/// The values of a bicycle, SI.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum BicycleParameters {
    /// Of the benchmark plant: symbols of Meijaard et al. (2007).
    Benchmark(twinhub_linear::Parameters),
    /// Of the multibody plant.
    Multibody(Box<multibody::Parameters>),
}

/// Sizes and loads of a bicycle with its rider.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shape {
    /// Wheelbase, m.
    pub wheelbase_m: f64,
    /// Steer axis tilt, rad.
    pub steer_tilt_rad: f64,
    /// Trail, m.
    pub trail_m: f64,
    /// Radius of the rear wheel, m.
    pub rear_radius_m: f64,
    /// Radius of the front wheel, m.
    pub front_radius_m: f64,
    /// Centre of mass of the rear frame (with a rigid rider on the benchmark bicycle): forward of
    /// the rear contact and above the road, m.
    pub frame_centre_m: [f64; 2],
    /// Load of the front wheel at rest, N.
    pub front_load_n: f64,
    /// Load of the rear wheel at rest, N.
    pub rear_load_n: f64,
    /// Height of the centre of mass of bicycle and rider, m.
    pub centre_height_m: f64,
}

impl ResolvedBicycle {
    /// A bicycle of the benchmark plant.
    pub fn benchmark(bicycle: twinhub_linear::Bicycle) -> Self {
        Self {
            name: bicycle.name,
            source: bicycle.source,
            parameters: BicycleParameters::Benchmark(bicycle.parameters),
        }
    }

    /// A bicycle of the multibody plant.
    pub fn multibody(parameters: multibody::Parameters) -> Self {
        Self {
            name: parameters.name.clone(),
            source: parameters.source.clone(),
            parameters: BicycleParameters::Multibody(Box::new(parameters)),
        }
    }

    /// Sizes and loads.
    pub fn shape(&self) -> Shape {
        match &self.parameters {
            BicycleParameters::Benchmark(p) => {
                let mass = p.mR + p.mB + p.mH + p.mF;
                let front = p.g * (p.mB * p.xB + p.mH * p.xH + p.mF * p.w) / p.w;
                Shape {
                    wheelbase_m: p.w,
                    steer_tilt_rad: p.lam,
                    trail_m: p.c,
                    rear_radius_m: p.rR,
                    front_radius_m: p.rF,
                    frame_centre_m: [p.xB, -p.zB],
                    front_load_n: front,
                    rear_load_n: mass * p.g - front,
                    centre_height_m: (p.mR * p.rR - p.mB * p.zB - p.mH * p.zH + p.mF * p.rF) / mass,
                }
            }
            BicycleParameters::Multibody(p) => {
                let (mass, [x, height]) = p.mass_and_centre();
                let (weight, g) = (mass * p.gravity_m_s2, &p.geometry);
                Shape {
                    wheelbase_m: g.wheelbase_m,
                    steer_tilt_rad: g.steer_tilt_rad,
                    trail_m: g.trail_m,
                    rear_radius_m: p.rear_wheel.radius_m,
                    front_radius_m: p.front_wheel.radius_m,
                    frame_centre_m: [p.frame.x_m, -p.frame.z_m],
                    front_load_n: weight * x / g.wheelbase_m,
                    rear_load_n: weight * (1.0 - x / g.wheelbase_m),
                    centre_height_m: height,
                }
            }
        }
    }

    /// Where forces act. No set has a saddle; a city bicycle's stands a fifth of the wheelbase
    /// before the rear contact, 0.9 m high.
    pub fn places(&self) -> Places {
        let shape = self.shape();
        Places {
            frame_centre_m: shape.frame_centre_m,
            saddle_m: [0.2 * shape.wheelbase_m, 0.9],
        }
    }

    /// What the controller is told, rider on the bicycle.
    pub fn control(&self) -> twinhub_control::Bicycle {
        let shape = self.shape();
        twinhub_control::Bicycle {
            front_wheel_radius_m: shape.front_radius_m as f32,
            rear_wheel_radius_m: shape.rear_radius_m as f32,
            wheelbase_m: shape.wheelbase_m as f32,
            steer_tilt_rad: shape.steer_tilt_rad as f32,
            front_load_n: shape.front_load_n as f32,
            rear_load_n: shape.rear_load_n as f32,
            com_height_m: shape.centre_height_m as f32,
        }
    }

    /// What its rider can move beside the handlebar.
    pub fn limbs(&self) -> Limbs {
        match &self.parameters {
            BicycleParameters::Benchmark(_) => Limbs::default(),
            BicycleParameters::Multibody(p) => Limbs {
                trunk: p.joints.trunk_lean.free,
                legs: p.joints.legs.free,
            },
        }
    }

    /// True if the road under a wheel may move: on tyres.
    pub fn has_tyres(&self) -> bool {
        match &self.parameters {
            BicycleParameters::Benchmark(_) => false,
            BicycleParameters::Multibody(p) => !p.tyre.rear.is_constraint(),
        }
    }

    /// True if moving air does something to it.
    pub fn feels_wind(&self) -> bool {
        match &self.parameters {
            BicycleParameters::Benchmark(_) => false,
            BicycleParameters::Multibody(p) => {
                p.air.density_kg_m3 > 0.0 && (p.air.drag_area_m2 > 0.0 || p.air.side_area_m2 > 0.0)
            }
        }
    }

    /// The values as the linear crate has them; `None` for a multibody bicycle.
    pub fn as_benchmark(&self) -> Option<Result<twinhub_linear::Bicycle, SetupError>> {
        match &self.parameters {
            BicycleParameters::Benchmark(p) => Some(
                twinhub_linear::Bicycle::new(&self.name, &self.source, *p)
                    .map_err(SetupError::from),
            ),
            BicycleParameters::Multibody(_) => None,
        }
    }
}
