//! From names and files to everything that a ride needs, in one value that is echoed in the log.

use crate::bicycle::ResolvedBicycle;
use crate::course::Course;
use crate::error::SetupError;
use crate::overrides::{Override, apply};
use crate::resolve::parsed;
use crate::shipped::{self, Shipped};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::path::Path;
use twinhub_control::Config;
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
        let mut course: Course = read(&origin, &text, &of("course"))?;
        course.check(&origin)?;
        course.resolve()?;
        let (origin, text) = find("rider", &course.rider, shipped::RIDERS)?;
        let rider: RiderFile = read(&origin, &text, &of("rider"))?;
        let bicycle = course.plant.bicycle()?;
        course.plant.check(&bicycle)?;
        rider
            .validate()
            .and_then(|()| rider.fits(bicycle.limbs()))
            .map_err(|source| SetupError::Rider {
                origin: origin.clone(),
                source,
            })?;
        let (origin, text) = find("law", &course.law, shipped::LAWS)?;
        let mut law: Config = read(&origin, &text, &of("law"))?;
        law.bicycle = bicycle.control();
        course.build_disturbances(&bicycle)?;
        course.build_sensors(bicycle.shape().rear_radius_m)?;
        course.build_motors()?;
        course.plant.build(&bicycle, course.speed_m_s(0.0))?;
        law.check().map_err(|e| SetupError::Law {
            origin,
            detail: e.to_string(),
        })?;
        Ok(Self {
            name,
            stabilizer_on: true,
            bicycle,
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
}

/// The rider called `rider`: a name that ships, or a file.
///
/// # Errors
/// If there is none, or a number is out of range.
pub fn load_rider(rider: &str) -> Result<RiderFile, SetupError> {
    let (origin, text) = find("rider", rider, shipped::RIDERS)?;
    let file: RiderFile = parsed(&origin, &text)?;
    file.validate()
        .map_err(|source| SetupError::Rider { origin, source })?;
    Ok(file)
}

/// The law called `law`, a name that ships or a file, with `assignments` (`path=value`) applied.
///
/// # Errors
/// If there is none, an assignment is wrong, or it breaks a rule.
pub fn load_law(law: &str, assignments: &[String]) -> Result<Config, SetupError> {
    let overrides: Vec<Override> = assignments
        .iter()
        .map(|text| Override::parse(&format!("law.{text}")))
        .collect::<Result<_, _>>()?;
    let (origin, text) = find("law", law, shipped::LAWS)?;
    let config: Config = read(&origin, &text, &overrides.iter().collect::<Vec<_>>())?;
    config.check().map_err(|e| SetupError::Law {
        origin,
        detail: e.to_string(),
    })?;
    Ok(config)
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
pub(crate) fn read<T: DeserializeOwned + Serialize>(
    origin: &str,
    text: &str,
    overrides: &[&Override],
) -> Result<T, SetupError> {
    let as_it_is: T = parsed(origin, text)?;
    if overrides.is_empty() {
        return Ok(as_it_is);
    }
    // What was left out of the file but has a value is there to be set.
    let mut tree = toml::Value::try_from(&as_it_is).map_err(|e| SetupError::Format {
        origin: origin.into(),
        detail: e.to_string(),
    })?;
    let mut doubts = Vec::new();
    for o in overrides {
        doubts.extend(apply(&mut tree, o)?);
    }
    tree.try_into().map_err(|e: toml::de::Error| {
        doubts.into_iter().next().unwrap_or(SetupError::Override {
            assignment: overrides
                .iter()
                .map(|o| o.text())
                .collect::<Vec<_>>()
                .join(" --set "),
            detail: e.to_string().trim_end().to_owned(),
        })
    })
}
