//! What a league is: everything that its results depend on.

use crate::error::LeagueError;
use crate::population::Class;
use serde::{Deserialize, Serialize};
use twinhub_control::{Config, Profile};
use twinhub_sim::setup::load_law;

/// Version of league files.
pub const SCHEMA_VERSION: u32 = 1;

/// The bicycle that is ridden if none is named: the one that the shipped riders are made for.
pub const BICYCLE: &str = twinhub_plant::rider::presets::BICYCLE;

/// Controllers that ride if none is named.
pub const CONTROLLERS: [&str; 9] = [
    "off",
    "constant_80_nm",
    "constant",
    "scheduled",
    "scheduled_20_nm",
    "scheduled_low_energy",
    "roll_steer_feedback",
    "steering_spring",
    "steering_motor",
];

/// One controller of a league.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Contestant {
    /// Name: that of the law that ships, or the file's stem.
    pub name: String,
    /// The law.
    pub law: Config,
}

/// Everything that the results of a league depend on.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Spec {
    /// [`SCHEMA_VERSION`].
    pub schema_version: u32,
    /// Seed of riders, courses and noise.
    pub seed: u64,
    /// Riders of each class, 1 to 1,000,000.
    pub riders: u64,
    /// Classes of riders.
    pub classes: Vec<Class>,
    /// Length of each ride, s, 10 to 600.
    pub duration_s: f64,
    /// The bicycle: a multibody set that ships, or a file.
    pub bicycle: String,
    /// The controllers; the first is what the others are measured against.
    pub controllers: Vec<Contestant>,
}

impl Spec {
    /// A league of these controllers: names that ship, or law files. `off` rides always, first.
    /// `profile` takes the place of the profiles in the law files, and tightens their limits.
    ///
    /// # Errors
    /// If a number is out of range, or a law cannot be read or breaks a rule.
    pub fn new(
        seed: u64,
        riders: u64,
        classes: &[Class],
        duration_s: f64,
        controllers: &[String],
        profile: Option<Profile>,
    ) -> Result<Self, LeagueError> {
        let mut contestants = vec![contestant("off", profile)?];
        for name in controllers.iter().filter(|name| *name != "off") {
            contestants.push(contestant(name, profile)?);
        }
        let spec = Self {
            schema_version: SCHEMA_VERSION,
            seed,
            riders,
            classes: classes.to_vec(),
            duration_s,
            bicycle: BICYCLE.to_owned(),
            controllers: contestants,
        };
        spec.check()?;
        Ok(spec)
    }

    /// The first rule that the league breaks, if any.
    ///
    /// # Errors
    /// That rule.
    pub fn check(&self) -> Result<(), LeagueError> {
        let bad = |key, found: String, accepted: &str| {
            Err(LeagueError::OutOfRange {
                key,
                found,
                accepted: accepted.to_owned(),
            })
        };
        if self.schema_version != SCHEMA_VERSION {
            return bad("schema_version", self.schema_version.to_string(), "1");
        }
        if !(1..=1_000_000).contains(&self.riders) {
            return bad("riders", self.riders.to_string(), "1 to 1000000");
        }
        if !(self.duration_s >= 10.0 && self.duration_s <= 600.0) {
            return bad("duration_s", self.duration_s.to_string(), "10 to 600 s");
        }
        if self.classes.is_empty() {
            return bad("classes", "none".into(), "at least one class of riders");
        }
        for (i, contestant) in self.controllers.iter().enumerate() {
            if self.controllers[..i]
                .iter()
                .any(|c| c.name == contestant.name)
            {
                return Err(LeagueError::Twice {
                    name: contestant.name.clone(),
                });
            }
        }
        Ok(())
    }

    /// Number of parts.
    pub fn parts(&self) -> u64 {
        self.riders * self.classes.len() as u64
    }

    /// The parts of shard `index` of `count`, counted from 1: every `count`th.
    ///
    /// # Errors
    /// If there is no such shard.
    pub fn shard(&self, index: u64, count: u64) -> Result<Vec<u64>, LeagueError> {
        if index == 0 || index > count {
            return Err(LeagueError::OutOfRange {
                key: "shard",
                found: format!("{index}/{count}"),
                accepted: "I/N with I from 1 to N".into(),
            });
        }
        Ok((0..self.parts())
            .filter(|part| part % count == index - 1)
            .collect())
    }

    /// What differs from `other`, in words; `None` if nothing does.
    pub fn difference(&self, other: &Self) -> Option<String> {
        let names = |spec: &Self| -> Vec<String> {
            spec.controllers.iter().map(|c| c.name.clone()).collect()
        };
        if self == other {
            None
        } else if self.seed != other.seed {
            Some(format!("its seed is {}, here {}", other.seed, self.seed))
        } else if self.riders != other.riders {
            Some(format!(
                "it has {} riders, here {}",
                other.riders, self.riders
            ))
        } else if self.classes != other.classes {
            Some(format!(
                "its classes are {:?}, here {:?}",
                other.classes, self.classes
            ))
        } else if names(self) != names(other) {
            let (theirs, ours) = (names(other).join(", "), names(self).join(", "));
            Some(format!("its controllers are {theirs}, here {ours}"))
        } else {
            Some("its laws, profile, bicycle or length of rides".into())
        }
    }
}

fn contestant(name: &str, profile: Option<Profile>) -> Result<Contestant, LeagueError> {
    let mut law = load_law(name, &[])?;
    if let Some(profile) = profile {
        law.profile = profile;
        law.limits.torque_max_nm = law.limits.torque_max_nm.min(profile.torque_max_nm());
    }
    law.check().map_err(|e| twinhub_sim::SetupError::Law {
        origin: name.into(),
        detail: e.to_string(),
    })?;
    let name = std::path::Path::new(name).file_stem().map_or_else(
        || name.to_owned(),
        |stem| stem.to_string_lossy().into_owned(),
    );
    Ok(Contestant { name, law })
}
