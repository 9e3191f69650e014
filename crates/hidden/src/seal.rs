//! A set as files: the study and its rides in one folder, the answer in another.

use crate::course::Motors;
use crate::random::Stream;
use crate::ride::{Fell, PULL_AT_M, SAMPLE_S};
use crate::scenario::{DECLARED_RATIO, Kind, Ridden, SHIFT_S, Scenario, band_hz};
use crate::sensors::{self, ChannelKind, JITTER_SD_S, Recording, record};
use flate2::Compression;
use flate2::write::GzEncoder;
use serde::{Deserialize, Serialize};
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::{Path, PathBuf};

/// What is hidden in a set.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SealedAnswer {
    pub schema_version: u32,
    pub kind: String,
    pub seed: u64,
    pub effects: Vec<HiddenEffect>,
    /// Names that a study like this cannot tell apart, if it was made for that.
    pub confounded: Vec<String>,
    /// Spread of the parameters about the declared ones, and the spread declared.
    pub spread_ratio: f64,
    pub declared_ratio: f64,
}

/// One thing hidden.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct HiddenEffect {
    pub mechanism: String,
    /// Whether a library should know it.
    pub in_library: bool,
    pub parameter: Option<String>,
    /// Of the parameter.
    pub value: f64,
    /// Distance from "absent".
    pub size: f64,
    pub equation: String,
    /// Frequencies with a tenth of its power below and above; known outside the library.
    pub band_hz: Option<[f64; 2]>,
}

/// Why a set cannot be made.
#[non_exhaustive]
#[derive(Debug, thiserror::Error)]
pub enum SealError {
    #[error(transparent)]
    Fell(#[from] Fell),
    #[error("cannot write {}: {source}", path.display())]
    Write {
        path: PathBuf,
        source: std::io::Error,
    },
}

/// A set, ready to be written.
#[derive(Clone, Debug)]
pub struct Sealed {
    pub study: String,
    pub answer: SealedAnswer,
    rides: Vec<(String, Recording)>,
}

impl Scenario {
    /// Rides the scenario and records it.
    pub fn seal(&self) -> Result<Sealed, SealError> {
        let ridden = self.ride()?;
        let kinds = self.kinds();
        let mut rides = vec![];
        for (course, (track, truth)) in ridden
            .courses
            .iter()
            .zip(ridden.tracks.iter().zip(&ridden.truths))
        {
            let stream = |what: &str| Stream::new(self.seed, &format!("{} {what}", course.name));
            let mut recording = record(track, &kinds, &truth.sensors, course.direction, &stream);
            if self.kind == Kind::Shifted {
                shift(&mut recording, &self.input_columns());
            }
            rides.push((format!("{}.csv.gz", course.name), recording));
        }
        Ok(Sealed {
            study: self.study(&ridden),
            answer: self.answer(&ridden),
            rides,
        })
    }

    fn kinds(&self) -> Vec<ChannelKind> {
        use sensors::*;
        let mut kinds = vec![
            SPEED,
            TORQUE,
            PULL,
            ROLL,
            ROLL_RATE,
            STEER,
            YAW_RATE,
            FRONT_WHEEL,
            REAR_WHEEL,
        ];
        kinds.extend([CADENCE, CRANK, YAW]);
        if self.layout.motors != Motors::Prescribed {
            kinds.extend([FRONT_BRAKE, REAR_TRACTION, ACCEL]);
        }
        kinds
    }

    fn input_columns(&self) -> Vec<&'static str> {
        let columns = self.kinds().into_iter().map(|k| k.column);
        columns.filter(|c| self.role(c) == "input").collect()
    }

    fn role(&self, column: &str) -> &'static str {
        let driven = self.layout.motors != Motors::Prescribed;
        match column {
            "steer_torque" | "pull" | "front_brake" | "rear_traction" => "input",
            "speed" => {
                if driven {
                    "output"
                } else {
                    "input"
                }
            }
            "front_wheel" | "rear_wheel" if !driven => "check",
            "cadence" | "crank" | "yaw" => "check",
            _ => "output",
        }
    }

    /// The study file. It says nothing about what is hidden.
    fn study(&self, ridden: &Ridden) -> String {
        let mut text = format!(
            "schema_version = 1\nname = \"sealed set {:016x}\"\n\n[bicycle]\nmodel = \"benchmark\"\n\
             parameters = \"meijaard2007_benchmark\"\ntolerance_ratio = {DECLARED_RATIO}\n",
            Stream::new(self.seed, self.kind.name()).uniform().to_bits()
        );
        for course in &ridden.courses {
            let _ = write!(
                text,
                "\n[[ride]]\nfile = \"{}.csv.gz\"\nuse = \"{}\"\nrider = \"one\"\nhands = \"{}\"\nground = \"road\"\n\
                 time = {{ column = \"t_s\", clock_jitter_sd_s = {JITTER_SD_S} }}\n",
                course.name,
                if course.held_out { "held_out" } else { "fit" },
                if course.hands_on { "on" } else { "off" },
            );
            for kind in self.kinds() {
                self.channel(&mut text, &kind);
            }
        }
        text
    }

    fn channel(&self, text: &mut String, kind: &ChannelKind) {
        let role = self.role(kind.column);
        let _ = write!(
            text,
            "\n[[ride.channel]]\ncolumn = \"{}\"\nquantity = \"{}\"\nrole = \"{role}\"\n",
            kind.column, kind.quantity
        );
        if kind.column == "pull" {
            let _ = writeln!(text, "point_m = [{}, {}]", PULL_AT_M[0], PULL_AT_M[1]);
        }
        if kind.steps {
            text.push_str("hold = \"zero\"\n");
        }
        let of_input = role == "input" && kind.column != "speed";
        if kind.noise_sd > 0.0 && (of_input || self.declares_noise) {
            let _ = writeln!(text, "noise_sd = {}", kind.noise_sd);
        }
        if kind.bias_sd > 0.0 {
            let _ = writeln!(text, "bias_sd = {}", kind.bias_sd);
        }
        if kind.quantum > 0.0 {
            let _ = writeln!(text, "quantum = {}", kind.quantum);
        }
    }

    fn answer(&self, ridden: &Ridden) -> SealedAnswer {
        let effects = ridden.hidden.iter().map(|h| {
            let e = h.effect;
            let axis = usize::from(e.equation != "roll");
            let outside = self.kind == Kind::Outside;
            HiddenEffect {
                mechanism: e.name.to_owned(),
                in_library: !outside,
                parameter: (!e.parameter.is_empty()).then(|| e.parameter.to_owned()),
                value: e.value(h.size),
                size: h.size,
                equation: e.equation.to_owned(),
                band_hz: outside
                    .then(|| ridden.tracks.first().and_then(|t| band_hz(t, axis)))
                    .flatten(),
            }
        });
        SealedAnswer {
            schema_version: 1,
            kind: self.kind.name().to_owned(),
            seed: self.seed,
            effects: effects.collect(),
            confounded: self
                .pair
                .map_or(vec![], |p| p.names.map(str::to_owned).to_vec()),
            spread_ratio: self.spread_ratio,
            declared_ratio: DECLARED_RATIO,
        }
    }
}

/// Makes these columns late; what is not known at the start is what comes last.
fn shift(recording: &mut Recording, columns: &[&str]) {
    let late = libm::round(SHIFT_S / SAMPLE_S) as usize;
    for channel in &mut recording.channels {
        if columns.contains(&channel.spec.column) {
            channel.values.rotate_right(late);
        }
    }
}

impl Sealed {
    /// Writes `STUDY.toml` and the rides into `folder`, which is made; gives the study's path.
    pub fn write(&self, folder: &Path) -> Result<PathBuf, SealError> {
        let wrap = |path: &Path| {
            let path = path.to_owned();
            move |source| SealError::Write { path, source }
        };
        std::fs::create_dir_all(folder).map_err(wrap(folder))?;
        let study = folder.join("STUDY.toml");
        std::fs::write(&study, &self.study).map_err(wrap(&study))?;
        for (name, recording) in &self.rides {
            let path = folder.join(name);
            let file = std::fs::File::create(&path).map_err(wrap(&path))?;
            let mut gz = GzEncoder::new(file, Compression::fast());
            gz.write_all(csv(recording).as_bytes())
                .map_err(wrap(&path))?;
            gz.finish().map_err(wrap(&path))?;
        }
        Ok(study)
    }

    /// Writes the answer alone.
    pub fn write_answer(&self, file: &Path) -> Result<(), SealError> {
        let wrap = |source| SealError::Write {
            path: file.to_owned(),
            source,
        };
        if let Some(folder) = file.parent() {
            std::fs::create_dir_all(folder).map_err(wrap)?;
        }
        let text = serde_json::to_string_pretty(&self.answer).map_err(|e| wrap(e.into()))?;
        std::fs::write(file, text + "\n").map_err(wrap)
    }
}

/// Header and rows; lost samples are empty cells.
fn csv(recording: &Recording) -> String {
    let names = recording.channels.iter().map(|c| c.spec.column);
    let mut text = core::iter::once("t_s")
        .chain(names)
        .collect::<Vec<_>>()
        .join(",");
    text.push('\n');
    for (k, t) in recording.t_s.iter().enumerate() {
        let _ = write!(text, "{t:.2}");
        for channel in &recording.channels {
            let value = channel.values[k];
            text.push(',');
            if !value.is_nan() {
                let _ = write!(text, "{value:.5}");
            }
        }
        text.push('\n');
    }
    text
}
