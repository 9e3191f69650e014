//! From names and files to everything that a ride needs, in one value that is echoed in the log.

use crate::course::Course;
use crate::error::SetupError;
use crate::overrides::{Override, apply};
use crate::shipped::{self, Shipped};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::path::Path;
use twinhub_control::Config;
use twinhub_linear::Bicycle;
use twinhub_plant::disturbance::Places;
use twinhub_plant::rider::RiderFile;

/// A ride with every name resolved: two rides with equal values give equal digests.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Ride {
    /// Name of the course: the name that ships, or the file's stem.
    pub name: String,
    /// The rider's switch: the stabilizer is on.
    pub stabilizer_on: bool,
    /// The course.
    pub course: Course,
    /// The rider.
    pub rider: RiderFile,
    /// The controller, its `bicycle` replaced by the one that is ridden.
    pub law: Config,
    /// The bicycle.
    pub bicycle: ResolvedBicycle,
}

/// A bicycle with its values.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ResolvedBicycle {
    /// Name or file.
    pub name: String,
    /// Where the values come from.
    pub source: String,
    /// Values, symbols of Meijaard et al. (2007), SI.
    pub parameters: twinhub_linear::Parameters,
}

impl Ride {
    /// Loads the course called `course` (a name that ships, or a file) with everything that it
    /// names, and applies `assignments` (`path=value`): keys of the course by their path, those of
    /// the rider and of the law with `rider.` and `law.` in front.
    ///
    /// # Errors
    /// Whatever is wrong with the files, with file, place, what was found and what is accepted.
    pub fn load(course: &str, assignments: &[String]) -> Result<Self, SetupError> {
        let overrides: Vec<Override> = assignments
            .iter()
            .map(|text| Override::parse(text))
            .collect::<Result<_, _>>()?;
        let of = |part: &str| -> Vec<&Override> {
            overrides.iter().filter(|o| o.part() == part).collect()
        };
        let (origin, text) = find("course", course, shipped::COURSES)?;
        let name = Path::new(course)
            .file_stem()
            .map_or(course.to_owned(), |s| s.to_string_lossy().into_owned());
        let course: Course = read(&origin, &text, &of("course"))?;
        course.check(&origin)?;
        let (origin, text) = find("rider", &course.rider, shipped::RIDERS)?;
        let rider: RiderFile = read(&origin, &text, &of("rider"))?;
        rider
            .start(course.seed, crate::TICK_S)
            .map_err(|source| SetupError::Rider {
                origin: origin.clone(),
                source,
            })?;
        let (origin, text) = find("law", &course.law, shipped::LAWS)?;
        let mut law: Config = read(&origin, &text, &of("law"))?;
        let bicycle = Bicycle::load(course.plant.bicycle())?;
        law.bicycle = control_bicycle(&bicycle);
        course.build_disturbances(&places(&bicycle))?;
        course.build_sensors(bicycle.parameters.rR)?;
        course.build_motors()?;
        law.check().map_err(|e| SetupError::Law {
            origin,
            detail: e.to_string(),
        })?;
        Ok(Self {
            name,
            stabilizer_on: true,
            bicycle: ResolvedBicycle {
                name: bicycle.name,
                source: bicycle.source,
                parameters: bicycle.parameters,
            },
            course,
            rider,
            law,
        })
    }

    /// The same ride with the stabilizer switched on or off.
    pub fn with_stabilizer(&self, on: bool) -> Self {
        Self {
            stabilizer_on: on,
            ..self.clone()
        }
    }

    /// The ride as TOML, as the log's attachment holds it.
    pub fn to_toml(&self) -> String {
        toml::to_string(self).unwrap_or_else(|e| format!("# cannot be written as TOML: {e}\n"))
    }

    /// Number of ticks of the whole course.
    pub fn ticks(&self) -> u64 {
        libm::round(self.course.duration_s / crate::TICK_S) as u64
    }

    /// The bicycle that is ridden.
    pub fn bicycle(&self) -> Result<Bicycle, SetupError> {
        Ok(Bicycle::new(
            &self.bicycle.name,
            &self.bicycle.source,
            self.bicycle.parameters,
        )?)
    }
}

/// Where forces act on the benchmark bicycle. It has no saddle; a city bicycle's stands a fifth of
/// the wheelbase before the rear contact, 0.9 m high.
pub fn places(bicycle: &Bicycle) -> Places {
    let p = &bicycle.parameters;
    Places {
        frame_centre_m: [p.xB, -p.zB],
        saddle_m: [0.2 * p.w, 0.9],
    }
}

/// What the controller is told about the bicycle, rider on it.
fn control_bicycle(bicycle: &Bicycle) -> twinhub_control::Bicycle {
    let p = &bicycle.parameters;
    let mass = p.mR + p.mB + p.mH + p.mF;
    let front = p.g * (p.mB * p.xB + p.mH * p.xH + p.mF * p.w) / p.w;
    let height = (p.mR * p.rR - p.mB * p.zB - p.mH * p.zH + p.mF * p.rF) / mass;
    twinhub_control::Bicycle {
        front_wheel_radius_m: p.rF as f32,
        rear_wheel_radius_m: p.rR as f32,
        wheelbase_m: p.w as f32,
        steer_tilt_rad: p.lam as f32,
        front_load_n: front as f32,
        rear_load_n: (mass * p.g - front) as f32,
        com_height_m: height as f32,
    }
}

/// The text of `what`, a name that ships or a file, and where it comes from.
pub(crate) fn find(
    kind: &'static str,
    what: &str,
    table: &[Shipped],
) -> Result<(String, String), SetupError> {
    if let Some(file) = table.iter().find(|file| file.name == what) {
        return Ok((format!("{kind} `{what}`"), file.text.to_owned()));
    }
    let path = Path::new(what);
    if !path.exists() {
        return Err(SetupError::NotFound {
            kind,
            found: what.into(),
            shipped: shipped::names(table),
        });
    }
    let text = std::fs::read_to_string(path).map_err(|source| SetupError::Unreadable {
        path: path.into(),
        source,
    })?;
    Ok((what.to_owned(), text))
}

/// Reads a file strictly, then once more with the assignments applied.
pub(crate) fn read<T: DeserializeOwned>(
    origin: &str,
    text: &str,
    overrides: &[&Override],
) -> Result<T, SetupError> {
    let as_it_is: T = toml::from_str(text).map_err(|e| SetupError::Format {
        origin: origin.into(),
        detail: e.to_string().trim_end().to_owned(),
    })?;
    if overrides.is_empty() {
        return Ok(as_it_is);
    }
    let mut tree: toml::Value = toml::from_str(text).map_err(|e| SetupError::Format {
        origin: origin.into(),
        detail: e.to_string(),
    })?;
    for o in overrides {
        apply(&mut tree, o)?;
    }
    tree.try_into()
        .map_err(|e: toml::de::Error| SetupError::Override {
            assignment: overrides
                .iter()
                .map(|o| o.text())
                .collect::<Vec<_>>()
                .join(" --set "),
            detail: e.to_string().trim_end().to_owned(),
        })
}
