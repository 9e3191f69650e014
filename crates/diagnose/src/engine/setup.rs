//! A model, and how it acts on one ride.

use super::ride::{Arm, NoiseKind, Ride, Sensor};
use crate::quantity::Quantity;
use std::collections::BTreeMap;
use std::sync::Arc;
use twinhub_linear::{Bicycle, BicycleError};
use twinhub_mechanism::{Body, InputModel, Mechanism, RandomForce, Requirement, SensorModel};

/// A mechanism with its parameters.
#[derive(Clone, Debug)]
pub struct Active {
    pub mechanism: &'static dyn Mechanism,
    pub p: Vec<f64>,
    /// Phases that belong to rides, by file, where the mechanism has such.
    pub phase_rad: BTreeMap<String, f64>,
}

impl Active {
    /// Without any phase.
    pub fn new(mechanism: &'static dyn Mechanism, p: Vec<f64>) -> Self {
        Self {
            mechanism,
            p,
            phase_rad: BTreeMap::new(),
        }
    }
}

/// Noise levels, one standard deviation each.
#[derive(Clone, Debug, PartialEq)]
pub struct Levels {
    /// White roll torque, steer torque (Nm √s) and forward force (N √s).
    pub process: [f64; 3],
    /// The free sensors' white noise.
    pub sensors: Vec<f64>,
}

/// A slow random force.
pub type Latent = RandomForce;

/// Latent torques on roll and on steer at most, and one random mechanism.
pub const MOST_LATENT: usize = 3;

/// Everything that can be changed about the prediction.
#[derive(Clone, Debug)]
pub struct Model {
    pub bicycle: Bicycle,
    pub active: Vec<Active>,
    pub levels: Levels,
    /// Torques on roll and on steer.
    pub latent: [Option<Latent>; 2],
}

/// The model's part that all rides share.
#[derive(Clone, Debug)]
pub struct Plant {
    bicycle: Arc<Bicycle>,
    pub body: Arc<Body>,
    pub active: Vec<Active>,
}

/// Whether a mechanism acts in a ride: arms do not with hands off, wind does not on a treadmill.
fn acts_in(mechanism: &dyn Mechanism, ride: &Ride) -> bool {
    mechanism.card().requires.iter().all(|r| match r {
        Requirement::HandsOn => ride.hands_on,
        Requirement::Rider => !(ride.rider.is_empty() || ride.rider == "none"),
        Requirement::Road => ride.road,
        Requirement::Treadmill => !ride.road,
        _ => true,
    })
}

impl Plant {
    fn new(bicycle: Arc<Bicycle>, active: Vec<Active>) -> Result<Self, BicycleError> {
        let list: Vec<(&'static dyn Mechanism, &[f64])> = active
            .iter()
            .map(|a| (a.mechanism, a.p.as_slice()))
            .collect();
        Ok(Self {
            body: Arc::new(Body::with(&bicycle, &list)?),
            bicycle,
            active,
        })
    }

    /// With the mechanisms that act in this ride.
    fn on(&self, ride: &Ride) -> Self {
        let acts = |a: &&Active| acts_in(a.mechanism, ride);
        if self.active.iter().all(|a| acts(&a)) {
            return self.clone();
        }
        let active = self.active.iter().filter(acts).cloned().collect();
        // Fewer mechanisms leave a bicycle that is at least as near to the declared one.
        Self::new(Arc::clone(&self.bicycle), active).unwrap_or_else(|_| self.clone())
    }
}

impl Model {
    pub fn plant(&self) -> Result<Plant, BicycleError> {
        Plant::new(Arc::new(self.bicycle.clone()), self.active.clone())
    }

    /// With one more mechanism.
    pub fn with(&self, mechanism: &'static dyn Mechanism, p: Vec<f64>) -> Self {
        let mut model = self.clone();
        model.active.push(Active::new(mechanism, p));
        model
    }

    /// Slow random forces in one ride: the model's own, and that of a random mechanism.
    pub fn latents(&self, ride: &Ride) -> [Option<Latent>; MOST_LATENT] {
        let random = self
            .active
            .iter()
            .filter(|a| acts_in(a.mechanism, ride))
            .find_map(|a| a.mechanism.random_force(&a.p, &self.bicycle.parameters));
        [self.latent[0], self.latent[1], random]
    }

    /// Noise of a sensor, one standard deviation.
    pub fn noise_sd(&self, sensor: &Sensor) -> f64 {
        match sensor.noise {
            NoiseKind::Known(sd) => sd,
            NoiseKind::Free(index) => self.levels.sensors[index],
        }
    }
}

/// How a plant acts on one ride.
#[derive(Clone, Debug)]
pub struct Setup {
    pub plant: Plant,
    pub sensors: Vec<SensorModel>,
    pub drives: Vec<InputModel>,
    pub brake: InputModel,
    pub traction: InputModel,
    pub speed: InputModel,
    /// Roll and steer torque per unit of each drive.
    pub arms: Vec<[f64; 2]>,
    pub law_delay_s: f64,
    /// Phase of the front wheel at its angle zero.
    pub wheel_phase_rad: f64,
    /// Mechanisms that push, and where their memory starts.
    pub pushing: Vec<(usize, usize)>,
    pub memory: usize,
    pub reads: bool,
}

impl Setup {
    pub fn new(plant: &Plant, ride: &Ride) -> Self {
        let plant = plant.on(ride);
        let input = |quantity: Quantity| {
            let mut model = InputModel::IDEAL;
            for a in &plant.active {
                a.mechanism.input(&a.p, quantity, &mut model);
            }
            // A limit that was never reached is none.
            if model.limit >= 200.0 {
                model.limit = f64::INFINITY;
            }
            model
        };
        let mut memory = 0;
        let mut pushing = vec![];
        for (index, a) in plant.active.iter().enumerate() {
            if a.mechanism.pushes() {
                pushing.push((index, memory));
                memory += a.mechanism.memory();
            }
        }
        Self {
            sensors: ride
                .sensors
                .iter()
                .map(|s| {
                    let mut model = SensorModel::IDEAL;
                    for a in &plant.active {
                        a.mechanism.sensor(&a.p, s.quantity, &mut model);
                    }
                    model
                })
                .collect(),
            drives: ride.drives.iter().map(|d| input(d.quantity)).collect(),
            brake: input(Quantity::FrontBrake),
            traction: input(Quantity::RearTraction),
            speed: input(Quantity::Speed),
            arms: ride
                .drives
                .iter()
                .map(|d| match d.arm {
                    Arm::Fixed(arm) => arm,
                    Arm::Point([x, z]) => plant.body.side_force_arm_m(x, z),
                })
                .collect(),
            law_delay_s: plant
                .active
                .iter()
                .map(|a| a.mechanism.law_delay_s(&a.p))
                .sum(),
            wheel_phase_rad: plant
                .active
                .iter()
                .filter_map(|a| a.phase_rad.get(&ride.file))
                .sum(),
            pushing,
            memory,
            reads: plant.active.iter().any(|a| a.mechanism.reads()),
            plant,
        }
    }

    /// Whether inputs act as in `other`.
    pub fn same_inputs(&self, other: &Self) -> bool {
        self.drives == other.drives
            && self.brake == other.brake
            && self.traction == other.traction
            && self.speed == other.speed
    }

    /// Whether events lie as in `other`.
    pub fn same_events(&self, other: &Self) -> bool {
        let late = |s: &Self| s.sensors.iter().map(|m| m.delay_s).collect::<Vec<_>>();
        self.same_inputs(other) && late(self) == late(other)
    }
}
