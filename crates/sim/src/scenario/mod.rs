//! Open-loop runs of a multibody bicycle: a scenario file in, rows with units out.
//!
//! A [`Scenario`] says which bicycle starts how, what acts on it over time, and what is written
//! down. [`run`] is a pure function of it. [`record`] keeps the rows as columns by name,
//! [`write_csv`] writes them as they come. The command `twinhub simulate` is these three lines:
//!
//! ```
//! use twinhub_sim::scenario::{Scenario, record};
//! let mut scenario = Scenario::load("push_7ms_off", &["duration_s=0.5".to_owned()])?;
//! scenario.start.roll_rad = 0.01;
//! let recording = record(&scenario, &mut |_| true)?;
//! let roll_rad = recording.column("roll_rad").unwrap();
//! assert!(!recording.summary.fell && roll_rad.len() == recording.rows());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod columns;
mod drive;
mod input;
mod recording;
mod run;
mod steering;
mod summary;

pub use columns::{Columns, unit};
pub use drive::Drive;
pub use input::{Channel, Input, Shape};
pub use recording::{Recording, record, write_csv};
pub use run::{Row, run};
pub use steering::HoldRoll;
pub use summary::{EnergyBalance, Summary};

use crate::error::SetupError;
use crate::overrides::Override;
use crate::setup::{find, read};
use crate::shipped;
use serde::{Deserialize, Serialize};
use std::path::Path;
use twinhub_plant::bicycles;
use twinhub_plant::disturbance::{Disturbance, Disturbances, Places, Timed};
use twinhub_plant::multibody::Parameters;
use twinhub_plant::road::Road;
use twinhub_plant::wind::Wind;
use twinhub_plant::{motor, sensor};

/// A scenario file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scenario {
    /// Version of the format: 1.
    pub schema_version: u32,
    /// One sentence.
    pub about: String,
    /// Where it comes from.
    pub source: String,
    /// A bicycle that ships (`twinhub list bicycles`), or a file; a linear one becomes the
    /// multibody one without slip and with a rigid rider.
    pub bicycle: String,
    /// Changes of its parameters, `path=value`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub set: Vec<String>,
    /// Length of the run, s; above 0, at most 3600.
    pub duration_s: f64,
    /// Step of integration, s; 1e-5 to 5e-3.
    pub step_s: f64,
    /// Time between rows, s: a whole number of steps.
    pub sample_s: f64,
    /// Seed of everything random.
    pub seed: u64,
    /// How long the run goes on after a fall, s.
    #[serde(default)]
    pub after_fall_s: f64,
    /// The state at the start.
    pub start: Start,
    /// What drives the bicycle all the time.
    pub drive: Drive,
    /// What acts on it over time.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub input: Vec<Input>,
    /// Hands on the bar that keep it in a corner for a while.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub hold_roll: Vec<HoldRoll>,
    /// What disturbs it (`twinhub list disturbances`).
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub disturbance: Vec<Timed>,
    /// Motor drives and battery that stand between torques asked for and torques had
    /// (`twinhub list motors`); absent: torques act as asked for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub motors: Option<String>,
    /// From when on the drives get no commands any more, s: shows their watchdog.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub commands_end_s: Option<f64>,
    /// Sensors whose readings are written down as well (`twinhub list sensors`).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sensors: Option<String>,
    /// The road; absent: level, friction 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub road: Option<Road>,
    /// The wind; absent: still air.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub wind: Option<Wind>,
}

/// The state at the start: a steady state, and what is added to it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Start {
    /// Forward speed, m/s; 0.3 to 15.
    pub speed_m_s: f64,
    /// Roll of the steady turn that it starts from, rad; zero: straight ahead.
    #[serde(default)]
    pub turn_roll_rad: f64,
    /// Roll on top, about the rear contact point, rad.
    #[serde(default)]
    pub roll_rad: f64,
    /// Roll rate on top, rad/s.
    #[serde(default)]
    pub roll_rate_rad_s: f64,
    /// Steer on top, rad.
    #[serde(default)]
    pub steer_rad: f64,
    /// Steer rate on top, rad/s.
    #[serde(default)]
    pub steer_rate_rad_s: f64,
    /// Trunk lean, pitch and twist on top, rad.
    #[serde(default)]
    pub trunk_rad: [f64; 3],
    /// Left and right leg on top, rad.
    #[serde(default)]
    pub legs_rad: [f64; 2],
}

/// A range with what a message says of it.
type Range = (f64, f64, &'static str);

impl Scenario {
    /// Loads the scenario called `name` (one that ships, or a file) and applies `assignments`
    /// (`path=value`, paths of the scenario file).
    ///
    /// # Errors
    /// Whatever is wrong with it, with file, place, what was found and what is accepted.
    pub fn load(name: &str, assignments: &[String]) -> Result<Self, SetupError> {
        let overrides: Vec<Override> = assignments
            .iter()
            .map(|text| Override::parse(text))
            .collect::<Result<_, _>>()?;
        let (origin, text) = find("scenario", name, shipped::SCENARIOS)?;
        let scenario: Self = read(&origin, &text, &overrides.iter().collect::<Vec<_>>())?;
        scenario.check(&origin)?;
        Ok(scenario)
    }

    /// The name of a scenario from what was asked for: a shipped name, or a file's stem.
    pub fn name(asked: &str) -> String {
        Path::new(asked)
            .file_stem()
            .map_or(asked.to_owned(), |s| s.to_string_lossy().into_owned())
    }

    /// The scenario as TOML.
    pub fn to_toml(&self) -> String {
        toml::to_string(self).unwrap_or_else(|e| format!("# cannot be written as TOML: {e}\n"))
    }

    /// Its bicycle.
    ///
    /// # Errors
    /// If there is none of that name, or its values cannot be.
    pub fn bicycle(&self) -> Result<Parameters, SetupError> {
        Ok(bicycles::load_multibody(&self.bicycle, &self.set)?)
    }

    /// Steps of the whole run.
    pub fn steps(&self) -> u64 {
        libm::round(self.duration_s / self.step_s) as u64
    }

    /// Steps from one row to the next.
    pub fn steps_per_row(&self) -> u64 {
        libm::round(self.sample_s / self.step_s) as u64
    }

    /// Checks every number, and that everything that is named exists.
    ///
    /// # Errors
    /// The first thing that is wrong, with its key.
    pub fn check(&self, origin: &str) -> Result<(), SetupError> {
        let bad = |key: String, found: String, accepted: &'static str| SetupError::OutOfRange {
            origin: origin.to_owned(),
            key,
            found,
            accepted,
        };
        if self.schema_version != 1 {
            return Err(bad(
                "schema_version".to_owned(),
                self.schema_version.to_string(),
                "1",
            ));
        }
        let s = &self.start;
        let angle: Range = (-1.2, 1.2, "-1.2 to 1.2 rad");
        let rate: Range = (-10.0, 10.0, "-10 to 10 rad/s");
        let numbers: [(&str, f64, Range); 16] = [
            (
                "duration_s",
                self.duration_s,
                (1e-3, 3600.0, "0.001 to 3600 s"),
            ),
            ("step_s", self.step_s, (1e-5, 5e-3, "1e-5 to 0.005 s")),
            ("after_fall_s", self.after_fall_s, (0.0, 60.0, "0 to 60 s")),
            ("start.speed_m_s", s.speed_m_s, (0.3, 15.0, "0.3 to 15 m/s")),
            (
                "start.turn_roll_rad",
                s.turn_roll_rad,
                (-0.8, 0.8, "-0.8 to 0.8 rad"),
            ),
            ("start.roll_rad", s.roll_rad, angle),
            ("start.roll_rate_rad_s", s.roll_rate_rad_s, rate),
            ("start.steer_rad", s.steer_rad, angle),
            ("start.steer_rate_rad_s", s.steer_rate_rad_s, rate),
            ("start.trunk_rad.0", s.trunk_rad[0], angle),
            ("start.trunk_rad.1", s.trunk_rad[1], angle),
            ("start.trunk_rad.2", s.trunk_rad[2], angle),
            ("start.legs_rad.0", s.legs_rad[0], angle),
            ("start.legs_rad.1", s.legs_rad[1], angle),
            (
                "sample_s",
                self.sample_s,
                (0.999 * self.step_s, self.duration_s, "step_s to duration_s"),
            ),
            (
                "commands_end_s",
                self.commands_end_s.unwrap_or(0.0),
                (0.0, 3600.0, "0 to 3600 s"),
            ),
        ];
        for (key, value, (low, high, accepted)) in numbers {
            if !(value >= low && value <= high) {
                return Err(bad(key.to_owned(), value.to_string(), accepted));
            }
        }
        let rows = self.sample_s / self.step_s;
        if (rows - libm::round(rows)).abs() > 1e-6 * rows {
            return Err(bad(
                "sample_s".to_owned(),
                self.sample_s.to_string(),
                "a whole number of steps step_s",
            ));
        }
        self.drive.check().map_err(|(key, found, accepted)| {
            bad(format!("drive.{key}"), found.to_string(), accepted)
        })?;
        for (i, input) in self.input.iter().enumerate() {
            input.check().map_err(|(key, found, accepted)| {
                bad(format!("input.{i}.{key}"), found.to_string(), accepted)
            })?;
        }
        for (i, hold) in self.hold_roll.iter().enumerate() {
            hold.check().map_err(|(key, found, accepted)| {
                bad(format!("hold_roll.{i}.{key}"), found.to_string(), accepted)
            })?;
        }
        self.check_names(origin)
    }

    /// Checks what the scenario names, and what only fits together.
    fn check_names(&self, origin: &str) -> Result<(), SetupError> {
        let format = |detail: String| SetupError::Format {
            origin: origin.to_owned(),
            detail,
        };
        let bicycle = self.bicycle()?;
        self.disturbances(&bicycle)?;
        if let Some(name) = &self.motors {
            if motor::sets::named(name).is_none() {
                return Err(unknown("motor set", name, motor::sets::SETS));
            }
            if self.step_s != crate::TICK_S {
                return Err(format(format!(
                    "`motors` = \"{name}\" with `step_s` = {}: motor drives go in ticks of 0.001 s; \
                     accepted: step_s = 0.001, or no `motors`",
                    self.step_s
                )));
            }
        } else if self.commands_end_s.is_some() {
            return Err(format(
                "`commands_end_s` without `motors`: there are no drives that could wait for commands"
                    .to_owned(),
            ));
        }
        if let Some(name) = &self.sensors {
            if sensor::sets::named(name).is_none() {
                return Err(unknown("sensor suite", name, sensor::sets::SUITES));
            }
            if self.step_s != crate::TICK_S {
                return Err(format(format!(
                    "`sensors` = \"{name}\" with `step_s` = {}: accepted: step_s = 0.001, or no \
                     `sensors`",
                    self.step_s
                )));
            }
        }
        if let Some(road) = &self.road {
            road.validate().map_err(|e| format(e.to_string()))?;
        }
        if let Some(wind) = &self.wind {
            wind.validate().map_err(|e| format(e.to_string()))?;
            if bicycle.air.drag_area_m2 == 0.0 && bicycle.air.side_area_m2 == 0.0 {
                return Err(format(format!(
                    "`wind` on `{}`, whose air.drag_area_m2 and air.side_area_m2 are 0: nothing \
                     would be felt; accepted: set = [\"air.drag_area_m2=0.55\", ...]",
                    self.bicycle
                )));
            }
        }
        Ok(())
    }

    /// The disturbances on this bicycle.
    pub(crate) fn disturbances(&self, bicycle: &Parameters) -> Result<Disturbances, SetupError> {
        let format = |detail: String| SetupError::Format {
            origin: "scenario".to_owned(),
            detail,
        };
        let no_slip = matches!(bicycle.tyre.rear, twinhub_plant::tyre::Tyre::NoSlip(_));
        let rig = |t: &Timed| matches!(t.what, Disturbance::RigMultisine(_));
        if no_slip && self.disturbance.iter().any(rig) {
            return Err(format(
                "`rig_multisine` moves the road under the rear wheel, which a wheel without slip \
                 cannot follow here; accepted: a bicycle on tyres, or `multisine_force`"
                    .to_owned(),
            ));
        }
        Disturbances::new(&self.disturbance, &places(bicycle), self.seed)
            .map_err(|e| format(e.to_string()))
    }
}

fn unknown(kind: &'static str, found: &str, sets: &[(&'static str, &str)]) -> SetupError {
    SetupError::NotFound {
        kind,
        found: found.to_owned(),
        shipped: sets.iter().map(|(name, _)| *name).collect(),
    }
}

/// Where forces act on a multibody bicycle: centre of mass of the rear frame, and the saddle under
/// the hips (of a rider without legs a fifth of the wheelbase before the rear contact, 0.9 m high).
pub fn places(bicycle: &Parameters) -> Places {
    let leg = &bicycle.rider.leg;
    Places {
        frame_centre_m: [bicycle.frame.x_m, -bicycle.frame.z_m],
        saddle_m: if leg.hip_z_m == 0.0 {
            [0.2 * bicycle.geometry.wheelbase_m, 0.9]
        } else {
            [leg.hip_x_m, -leg.hip_z_m]
        },
    }
}

#[cfg(test)]
mod tests;
