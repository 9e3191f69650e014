//! Study files: which rides, which channels, which bicycle. A public interface; its JSON schema is
//! `schema/study.schema.json`.
//!
//! [`Study::read`] gives a study that is complete and checked in itself; every error names the
//! file, the line, what was found and what is accepted. The rides are read by [`crate::data`].

mod check;
mod check_channel;
mod check_ride;
mod overrides;
mod raw;
#[cfg(test)]
mod schema_test;
pub mod shipped;

use crate::quantity::Quantity;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use twinhub_linear::Bicycle;

macro_rules! choice {
    ($(#[$doc:meta])* $name:ident { $($variant:ident = $text:literal),* }) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
        pub enum $name { $(#[serde(rename = $text)] $variant),* }
        impl $name {
            /// The words of the study file.
            pub const NAMES: &'static [&'static str] = &[$($text),*];
        }
    };
}
choice!(/// Which plant the rides are set against.
    ModelKind { Benchmark = "benchmark", Multibody = "multibody" });
choice!(/// What a ride or window is for.
    Use { Fit = "fit", HeldOut = "held_out" });
choice!(/// Whether the rider's hands hold the bar.
    Hands { On = "on", Off = "off" });
choice!(/// What the wheels roll on.
    Ground { Treadmill = "treadmill", Road = "road" });
choice!(/// What a channel is for: it drives the model, is compared with it, or is only looked at.
    Role { Input = "input", Output = "output", Check = "check" });
choice!(/// What an input does between samples.
    HoldKind { Zero = "zero", Linear = "linear" });
choice!(/// Form of a known feedback.
    LawKind { SpeedScheduledRate = "speed_scheduled_rate", Linear = "linear" });

/// Where something stands in the study file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    pub file: PathBuf,
    /// Counted from 1.
    pub line: usize,
}

impl std::fmt::Display for Place {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}, line {}", self.file.display(), self.line)
    }
}

/// A study, checked.
#[derive(Clone, Debug)]
pub struct Study {
    pub name: String,
    /// The file that it came from.
    pub file: PathBuf,
    pub model: ModelKind,
    /// `parameters` as written.
    pub parameters: String,
    /// One standard deviation of every parameter, relative to its value.
    pub tolerance_ratio: f64,
    pub values: BTreeMap<String, f64>,
    pub tolerances: BTreeMap<String, Tolerance>,
    /// The bicycle with its values overridden; none for the multibody plant.
    pub bicycle: Option<Bicycle>,
    pub rides: Vec<RideSpec>,
    pub modes: Vec<ModesSpec>,
}

/// One standard deviation of a parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Tolerance {
    Ratio(f64),
    Absolute(f64),
}

/// One ride of the study.
#[derive(Clone, Debug)]
pub struct RideSpec {
    pub file: String,
    pub place: Place,
    pub usage: Use,
    pub rider: String,
    pub hands: Option<Hands>,
    pub ground: Option<Ground>,
    pub time: TimeSpec,
    pub clock_jitter_sd_s: f64,
    /// None: the whole ride.
    pub windows: Option<Vec<WindowSpec>>,
    pub channels: Vec<ChannelSpec>,
    pub laws: Vec<LawSpec>,
}

#[derive(Clone, Debug, PartialEq)]
pub enum TimeSpec {
    /// A column in seconds.
    Column(String),
    /// Evenly spaced rows, the first at 0.
    RateHz(f64),
    /// The sample times of an MCAP log's topics.
    Log,
}

/// A half-open part [start, end) of a ride.
#[derive(Clone, Debug, PartialEq)]
pub struct WindowSpec {
    pub start_s: f64,
    pub end_s: f64,
    pub usage: Use,
    pub place: Place,
}

#[derive(Clone, Debug)]
pub struct ChannelSpec {
    pub column: String,
    pub quantity: Quantity,
    pub role: Role,
    pub scale: f64,
    pub offset: f64,
    /// Of a lateral force: roll and steer torque per newton.
    pub arm_m: Option<[f64; 2]>,
    /// (x, z) where a lateral force acts or an accelerometer sits.
    pub point_m: Option<[f64; 2]>,
    pub noise_sd: Option<f64>,
    pub bias_sd: f64,
    pub delay_s: f64,
    pub quantum: f64,
    pub lowpass_hz: f64,
    pub moving_average_s: f64,
    pub hold: HoldKind,
    pub place: Place,
}

#[derive(Clone, Debug, PartialEq)]
pub struct LawSpec {
    pub quantity: Quantity,
    pub kind: LawKind,
    pub of: Quantity,
    pub gain: f64,
    pub speed0_m_s: Option<f64>,
    /// Infinite: none.
    pub limit_nm: f64,
    pub delay_s: f64,
}

/// Fitted modes where the rides themselves were not published.
#[derive(Clone, Debug)]
pub struct ModesSpec {
    pub file: String,
    pub place: Place,
    pub usage: Use,
    pub speed_column: String,
    pub sigma_column: String,
    pub omega_column: String,
    pub sigma_sd_1_s: f64,
    pub omega_sd_rad_s: f64,
    pub law: Option<LawSpec>,
}

/// Why a study is refused.
#[non_exhaustive]
#[derive(Debug, thiserror::Error)]
pub enum StudyError {
    #[error("cannot read study {}: {source}; studies that ship with twinhub: {}", path.display(), shipped::NAMES.join(", "))]
    Read {
        path: PathBuf,
        source: std::io::Error,
    },
    #[error("{place}: {message}")]
    Syntax { place: Place, message: String },
    #[error("{place}: found {found}; accepted: {accepted}")]
    Value {
        place: Place,
        found: String,
        accepted: String,
    },
    #[error("{place}: {source}")]
    Bicycle {
        place: Place,
        source: Box<twinhub_linear::BicycleError>,
    },
    #[error("--set {assignment}: {message}")]
    Override { assignment: String, message: String },
}

impl Study {
    /// Reads a study file, or one that ships by its name.
    pub fn read(name_or_path: &str, overrides: &[String]) -> Result<Self, StudyError> {
        if let Some(text) = shipped::text(name_or_path) {
            return Self::parse(text, Path::new(&format!("{name_or_path}.toml")), overrides);
        }
        let path = Path::new(name_or_path);
        let text = std::fs::read_to_string(path).map_err(|source| StudyError::Read {
            path: path.to_owned(),
            source,
        })?;
        Self::parse(&text, path, overrides)
    }

    /// Parses the text of a study; `path` is where it stands, for errors and for files beside it.
    /// Overrides are `path=value`, for instance `bicycle.values.IBxx=9.2` or `ride.0.use="fit"`.
    pub fn parse(text: &str, path: &Path, overrides: &[String]) -> Result<Self, StudyError> {
        let study = check::parse(text, path)?;
        if overrides.is_empty() {
            return Ok(study);
        }
        let changed = overrides::with_overrides(text, overrides)?;
        let mut changed = check::parse(&changed, path).map_err(|error| StudyError::Override {
            assignment: overrides.join(" --set "),
            message: error.without_place(),
        })?;
        changed.take_places(&study);
        Ok(changed)
    }

    /// Overrides move lines; the places are those of the file.
    fn take_places(&mut self, file: &Self) {
        for (ride, old) in self.rides.iter_mut().zip(&file.rides) {
            ride.place = old.place.clone();
            for (channel, old) in ride.channels.iter_mut().zip(&old.channels) {
                channel.place = old.place.clone();
            }
            let windows = ride.windows.iter_mut().flatten();
            for (window, old) in windows.zip(old.windows.iter().flatten()) {
                window.place = old.place.clone();
            }
        }
    }
}

impl StudyError {
    /// The message without file and line.
    fn without_place(&self) -> String {
        let text = self.to_string();
        match self {
            Self::Syntax { place, .. }
            | Self::Value { place, .. }
            | Self::Bicycle { place, .. } => {
                let prefix = format!("{place}: ");
                text.strip_prefix(&prefix).unwrap_or(&text).to_owned()
            }
            _ => text,
        }
    }
}
