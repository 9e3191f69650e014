//! A course: what is ridden, on what, by whom, and what disturbs it.

use crate::bicycle::ResolvedBicycle;
use crate::choice::Choice;
use crate::error::SetupError;
use crate::plant::PlantChoice;
use crate::resolve;
use serde::{Deserialize, Serialize};
use twinhub_link::fault::LinkFault;
use twinhub_plant::benchmark::Resistance;
use twinhub_plant::disturbance::{Disturbance, Disturbances, Timed};
use twinhub_plant::motor::{PowerTrain, PowerTrainParameters};
use twinhub_plant::sensor::{SensorSuite, SuiteParameters};

/// A course file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Course {
    /// Version of the format: 1.
    pub schema_version: u32,
    /// One sentence.
    pub about: String,
    /// Length of the ride, s; above 0, at most 36,000.
    pub duration_s: f64,
    /// Seed of everything random.
    pub seed: u64,
    /// A rider that ships, or a rider file.
    pub rider: String,
    /// A law that ships, or a law file.
    pub law: String,
    /// Motor drives and battery: a set that ships, a file, or the values.
    pub motors: Choice<PowerTrainParameters>,
    /// Sensors: a suite that ships, a file, or the values.
    pub sensors: Choice<SuiteParameters>,
    /// Speed over time, straight lines between the points.
    pub speed: Vec<SpeedPoint>,
    /// The plant.
    pub plant: PlantChoice,
    /// What disturbs the ride.
    #[serde(default)]
    pub disturbance: Vec<Timed>,
    /// What goes wrong on the link.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub link_fault: Vec<LinkFault>,
}

/// A point of the speed that the course asks for.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SpeedPoint {
    /// Time, s.
    pub t_s: f64,
    /// Speed, m/s.
    pub speed_m_s: f64,
}

impl Course {
    /// Checks the numbers.
    ///
    /// # Errors
    /// The first number that is out of range, with its key.
    pub fn check(&self, origin: &str) -> Result<(), SetupError> {
        let bad = |key: String, found: String, accepted| {
            Err(SetupError::OutOfRange {
                origin: origin.into(),
                key,
                found,
                accepted,
            })
        };
        if self.schema_version != 1 {
            return bad(
                "schema_version".into(),
                self.schema_version.to_string(),
                "1",
            );
        }
        if !(self.duration_s > 0.0 && self.duration_s <= 36_000.0) {
            return bad(
                "duration_s".into(),
                self.duration_s.to_string(),
                "above 0, at most 36000 s",
            );
        }
        for (i, fault) in self.link_fault.iter().enumerate() {
            if let Err(e) = fault.check() {
                return bad(
                    format!("link_fault.{i}.{}", e.key),
                    e.found.to_string(),
                    e.accepted,
                );
            }
        }
        if self.speed.is_empty() {
            return bad("speed".into(), "empty".into(), "at least one point");
        }
        for (i, point) in self.speed.iter().enumerate() {
            if !(point.speed_m_s >= 0.3 && point.speed_m_s <= 20.0) {
                return bad(
                    format!("speed.{i}.speed_m_s"),
                    point.speed_m_s.to_string(),
                    "0.3 to 20 m/s",
                );
            }
            let before = if i == 0 {
                f64::NEG_INFINITY
            } else {
                self.speed[i - 1].t_s
            };
            if !(point.t_s > before && point.t_s.is_finite()) {
                return bad(
                    format!("speed.{i}.t_s"),
                    point.t_s.to_string(),
                    "finite, later than the point before",
                );
            }
        }
        let Resistance {
            rolling_ratio,
            drag_area_m2,
            air_density_kg_m3,
        } = match &self.plant {
            PlantChoice::Benchmark(choice) => choice.resistance,
            // Its own check follows when its names are resolved.
            PlantChoice::Multibody(_) => return Ok(()),
        };
        for (key, value, most, accepted) in [
            ("rolling_ratio", rolling_ratio, 0.2, "0 to 0.2"),
            ("drag_area_m2", drag_area_m2, 5.0, "0 to 5 m²"),
            ("air_density_kg_m3", air_density_kg_m3, 2.0, "0 to 2 kg/m³"),
        ] {
            if !(value >= 0.0 && value <= most) {
                return bad(
                    format!("plant.benchmark.resistance.{key}"),
                    value.to_string(),
                    accepted,
                );
            }
        }
        Ok(())
    }

    /// Puts values in the place of names.
    ///
    /// # Errors
    /// If a name is unknown, or its file or values are wrong.
    pub fn resolve(&mut self) -> Result<(), SetupError> {
        self.motors = resolve::motors(&self.motors)?.into();
        self.sensors = resolve::sensors(&self.sensors)?.into();
        self.plant.resolve()
    }

    /// What disturbs the ride on this bicycle.
    ///
    /// # Errors
    /// If a number is out of range, or the plant cannot take such a disturbance.
    pub fn build_disturbances(
        &self,
        bicycle: &ResolvedBicycle,
    ) -> Result<Disturbances, SetupError> {
        let bad = |detail: String| SetupError::Format {
            origin: "course".into(),
            detail,
        };
        let rig = |t: &Timed| matches!(t.what, Disturbance::RigMultisine(_));
        if !bicycle.has_tyres() && self.disturbance.iter().any(rig) {
            return Err(bad(
                "`rig_multisine` moves the road under the rear tyre, which this bicycle does not \
                 have (no slip); use `multisine_force`, or a multibody bicycle on tyres"
                    .into(),
            ));
        }
        Disturbances::new(&self.disturbance, &bicycle.places(), self.seed)
            .map_err(|e| bad(e.to_string()))
    }

    /// The sensors of the bicycle with rear wheels of `rear_radius_m`.
    ///
    /// # Errors
    /// If no suite has that name, or a number is out of range.
    pub fn build_sensors(&self, rear_radius_m: f64) -> Result<SensorSuite, SetupError> {
        let suite = resolve::sensors(&self.sensors)?;
        SensorSuite::new(&suite.with_rear_radius_m(rear_radius_m), self.seed).map_err(|e| {
            SetupError::Format {
                origin: "sensors".into(),
                detail: e.to_string(),
            }
        })
    }

    /// Motor drives and battery.
    ///
    /// # Errors
    /// If no set has that name, or a number is out of range.
    pub fn build_motors(&self) -> Result<PowerTrain, SetupError> {
        let set = resolve::motors(&self.motors)?;
        PowerTrain::new(&set).map_err(|e| SetupError::Format {
            origin: "motors".into(),
            detail: e.to_string(),
        })
    }

    /// The speed that the course asks for at `t_s`, m/s.
    pub fn speed_m_s(&self, t_s: f64) -> f64 {
        let last = self.speed.len() - 1;
        match self.speed.iter().position(|p| p.t_s > t_s) {
            None => self.speed[last].speed_m_s,
            Some(0) => self.speed[0].speed_m_s,
            Some(i) => {
                let (a, b) = (self.speed[i - 1], self.speed[i]);
                a.speed_m_s + (t_s - a.t_s) / (b.t_s - a.t_s) * (b.speed_m_s - a.speed_m_s)
            }
        }
    }
}
