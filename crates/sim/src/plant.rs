//! The plant of a course: which one, its bicycle, road and wind.

use crate::bicycle::ResolvedBicycle;
use crate::choice::Choice;
use crate::error::SetupError;
use crate::resolve;
use serde::{Deserialize, Serialize};
use twinhub_plant::PlantModel;
use twinhub_plant::benchmark::{Benchmark, Resistance};
use twinhub_plant::multibody;
use twinhub_plant::road::Road;
use twinhub_plant::wind::Wind;

/// The plants.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum PlantChoice {
    /// Linear, no tyre slip: `twinhub_plant::benchmark`.
    Benchmark(BenchmarkChoice),
    /// Nonlinear, 14 degrees of freedom, on tyres: `twinhub_plant::multibody`.
    Multibody(MultibodyChoice),
}

/// The benchmark plant of a course.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BenchmarkChoice {
    /// Built-in name, file, or `bicycle+rider`.
    pub bicycle: String,
    /// Resistance to rolling and to air.
    pub resistance: Resistance,
}

/// The multibody plant of a course.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MultibodyChoice {
    /// Built-in name, file, or the parameters themselves.
    pub bicycle: Choice<multibody::Parameters>,
    /// Changes of its parameters: nested tables or dotted paths, `tyre.front.twisting_gain = 0.5`;
    /// `tyre = "NAME"` takes a tyre set.
    #[serde(default, skip_serializing_if = "toml::Table::is_empty")]
    pub set: toml::Table,
    /// The road.
    pub road: Choice<Road>,
    /// The wind.
    pub wind: Choice<Wind>,
    /// Where the inertial sensor sits on the frame, coordinates of the parameters (forward, right,
    /// down from the rear contact), m; in the frame's centre of mass if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sensor_at_m: Option<[f64; 3]>,
}

impl PlantChoice {
    /// The bicycle that is named, with the changes.
    ///
    /// # Errors
    /// If it is unknown, its file wrong, or a change.
    pub fn bicycle(&self) -> Result<ResolvedBicycle, SetupError> {
        match self {
            Self::Benchmark(choice) => Ok(ResolvedBicycle::benchmark(
                twinhub_linear::Bicycle::load(&choice.bicycle)?,
            )),
            Self::Multibody(choice) => choice.load().map(ResolvedBicycle::multibody),
        }
    }

    /// The plant, upright and straight at `speed_m_s`.
    ///
    /// # Errors
    /// If the bicycle's values cannot be.
    pub fn build(
        &self,
        bicycle: &ResolvedBicycle,
        speed_m_s: f64,
    ) -> Result<Box<dyn PlantModel + Send>, SetupError> {
        let wrong_kind = || SetupError::Format {
            origin: format!("bicycle `{}`", bicycle.name),
            detail: "its values are of the other plant".into(),
        };
        match (self, &bicycle.parameters) {
            (Self::Benchmark(choice), _) => {
                let bicycle = bicycle.as_benchmark().ok_or_else(wrong_kind)??;
                Ok(Box::new(Benchmark::new(
                    &bicycle,
                    choice.resistance,
                    speed_m_s,
                )?))
            }
            (Self::Multibody(choice), crate::bicycle::BicycleParameters::Multibody(p)) => {
                let road = choice.road.given().cloned();
                let ride =
                    multibody::Ride::new(p, road, speed_m_s).map_err(|e| SetupError::Format {
                        origin: format!("bicycle `{}`", bicycle.name),
                        detail: e.to_string(),
                    })?;
                Ok(match choice.sensor_at_m {
                    Some(at_m) => Box::new(ride.with_sensor_at(at_m)),
                    None => Box::new(ride),
                })
            }
            (Self::Multibody(_), _) => Err(wrong_kind()),
        }
    }

    /// The wind; `None` where the plant has still air.
    pub fn wind(&self) -> Option<&Wind> {
        match self {
            Self::Benchmark(_) => None,
            Self::Multibody(choice) => choice.wind.given(),
        }
    }

    /// Puts the values in the place of names, and checks them.
    pub(crate) fn resolve(&mut self) -> Result<(), SetupError> {
        let Self::Multibody(choice) = self else {
            return Ok(());
        };
        let road = resolve::road(&choice.road)?;
        road.validate()
            .map_err(|e| bad("plant.multibody.road", &e))?;
        let wind = resolve::wind(&choice.wind)?;
        wind.validate()
            .map_err(|e| bad("plant.multibody.wind", &e))?;
        (choice.road, choice.wind) = (road.into(), wind.into());
        Ok(())
    }

    /// Refuses what this bicycle cannot feel.
    pub(crate) fn check(&self, bicycle: &ResolvedBicycle) -> Result<(), SetupError> {
        let blows = self.wind().is_some_and(|w| *w != Wind::default());
        if blows && !bicycle.feels_wind() {
            return Err(SetupError::Format {
                origin: "plant.multibody.wind".into(),
                detail: format!(
                    "the air moves, but bicycle `{}` has no air areas; set \
                     plant.multibody.set.air.drag_area_m2 and side_area_m2 (m²), \
                     density_kg_m3, x_m and z_m",
                    bicycle.name
                ),
            });
        }
        match self {
            Self::Multibody(MultibodyChoice {
                sensor_at_m: Some(at),
                ..
            }) if !at.iter().all(|v| v.abs() <= 5.0) => Err(SetupError::OutOfRange {
                origin: "course".into(),
                key: "plant.multibody.sensor_at_m".into(),
                found: format!("{at:?}"),
                accepted: "-5 to 5 m each",
            }),
            _ => Ok(()),
        }
    }
}

fn bad(origin: &str, error: &dyn std::error::Error) -> SetupError {
    SetupError::Format {
        origin: origin.into(),
        detail: error.to_string(),
    }
}

impl MultibodyChoice {
    fn load(&self) -> Result<multibody::Parameters, SetupError> {
        let assignments = flattened(&self.set);
        let loaded = match &self.bicycle {
            Choice::Named(name) => twinhub_plant::bicycles::load_multibody(name, &assignments),
            Choice::Given(parameters) => parameters.with(&assignments),
        };
        loaded.map_err(|e| bad("plant.multibody.bicycle", &e))
    }
}

/// The entries of nested tables as `path=value`, in the order of their paths.
fn flattened(table: &toml::Table) -> Vec<String> {
    fn walk(table: &toml::Table, prefix: &str, into: &mut Vec<String>) {
        for (key, value) in table {
            let path = if prefix.is_empty() {
                key.clone()
            } else {
                format!("{prefix}.{key}")
            };
            match value {
                toml::Value::Table(inner) => walk(inner, &path, into),
                toml::Value::String(text) => into.push(format!("{path}={text}")),
                other => into.push(format!("{path}={other}")),
            }
        }
    }
    let mut list = Vec::new();
    walk(table, "", &mut list);
    list
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nested_tables_and_dotted_paths_are_one() {
        let table: toml::Table = toml::from_str(
            "tyre = \"linear\"\nair = { x_m = 0.4 }\n\"geometry.trail_m\" = 0.05\njoints.legs.free = false",
        )
        .expect("TOML");
        assert_eq!(
            flattened(&table),
            [
                "air.x_m=0.4",
                "geometry.trail_m=0.05",
                "joints.legs.free=false",
                "tyre=linear"
            ]
        );
    }
}
