//! A bicycle by name, by file, or as bicycle and rider.

use crate::benchmark_file::{self, Entries};
use crate::bicycle::Bicycle;
use crate::error::BicycleError;
use crate::parameters::{Parameters, SYMBOLS};
use crate::rigid_body::RigidBody;
use crate::sets;
use std::path::Path;

/// What a rider file gives.
const RIDER_KEYS: [&str; 7] = ["mB", "xB", "zB", "IBxx", "IByy", "IBzz", "IBxz"];

/// A bicycle, or only what a file says.
enum Part {
    Whole(Box<Bicycle>),
    File(String, Entries),
}

impl Bicycle {
    /// Loads a bicycle: the name of a built-in set (`sets::NAMES`, with options as
    /// `NAME:OPTION=VALUE,...`), the path of a bicycle `.toml` or of a BicycleParameters
    /// `*Benchmark.txt`, or `BICYCLE+RIDER`, where the rider's file gives mB, xB, zB, IBxx, IByy,
    /// IBzz and IBxz.
    pub fn load(spec: &str) -> Result<Self, BicycleError> {
        if sets::find(spec).is_some() || Path::new(spec).is_file() || !spec.contains('+') {
            return match part(spec)? {
                Part::Whole(bicycle) => Ok(*bicycle),
                Part::File(stem, entries) => whole(&stem, Path::new(spec), &entries),
            };
        }
        let mut names = spec.split('+').map(str::trim);
        let mut bicycle = Self::load(names.next().unwrap_or(""))?;
        for name in names {
            bicycle = with_rider(bicycle, name)?;
        }
        Ok(bicycle)
    }
}

fn part(spec: &str) -> Result<Part, BicycleError> {
    if let Some(set) = sets::find(spec) {
        return set.map(|b| Part::Whole(Box::new(b)));
    }
    let path = Path::new(spec);
    if !path.is_file() {
        return Err(BicycleError::UnknownBicycle {
            found: spec.to_owned(),
        });
    }
    let text = std::fs::read_to_string(path).map_err(|source| BicycleError::Read {
        path: path.to_owned(),
        source,
    })?;
    if path
        .extension()
        .is_some_and(|e| e.eq_ignore_ascii_case("toml"))
    {
        return Bicycle::from_toml(&text, path).map(|b| Part::Whole(Box::new(b)));
    }
    let stem = path
        .file_stem()
        .map(|s| s.to_string_lossy().into_owned())
        .unwrap_or_default();
    Ok(Part::File(
        stem.strip_suffix("Benchmark").unwrap_or(&stem).to_owned(),
        benchmark_file::parse(&text, path)?,
    ))
}

/// The bicycle of a complete `*Benchmark.txt`.
fn whole(name: &str, path: &Path, entries: &Entries) -> Result<Bicycle, BicycleError> {
    let keys: Vec<_> = SYMBOLS
        .iter()
        .copied()
        .filter(|s| !entries.contains_key(s))
        .collect();
    if !keys.is_empty() {
        let rider = !entries.is_empty() && entries.keys().all(|k| RIDER_KEYS.contains(k));
        let hint = if rider {
            " (this is a rider's file: give it with a bicycle, as BICYCLE+RIDER)"
        } else {
            ""
        };
        return Err(BicycleError::Missing {
            path: path.to_owned(),
            keys,
            hint: hint.to_owned(),
        });
    }
    let in_file = |source| BicycleError::InFile {
        path: path.to_owned(),
        source: Box::new(source),
    };
    let mut parameters = Parameters::ZERO;
    for (symbol, entry) in entries {
        parameters.set(symbol, entry.value).map_err(in_file)?;
    }
    let mut bicycle =
        Bicycle::new(name, &path.display().to_string(), parameters).map_err(in_file)?;
    bicycle.standard_deviations = entries
        .iter()
        .filter_map(|(s, e)| e.sd.map(|sd| (*s, sd)))
        .collect();
    Ok(bicycle)
}

/// `bicycle` with the rider of file `spec` rigidly on its rear body.
fn with_rider(mut bicycle: Bicycle, spec: &str) -> Result<Bicycle, BicycleError> {
    let path = Path::new(spec);
    let not_a_rider = || BicycleError::NotARider {
        found: spec.to_owned(),
    };
    let Part::File(name, entries) = part(spec)? else {
        return Err(not_a_rider());
    };
    let keys: Vec<_> = RIDER_KEYS
        .iter()
        .copied()
        .filter(|k| !entries.contains_key(k))
        .collect();
    if !keys.is_empty() {
        return Err(BicycleError::Missing {
            path: path.to_owned(),
            keys,
            hint: " (of a rider)".to_owned(),
        });
    }
    if entries.keys().any(|k| !RIDER_KEYS.contains(k)) {
        return Err(not_a_rider());
    }
    let mut rider = Parameters::ZERO;
    for (key, entry) in &entries {
        rider.set(key, entry.value)?;
    }
    let join = |frame: &Parameters, rider: &Parameters| {
        let mut p = *frame;
        RigidBody::rear_body(frame)
            .and(RigidBody::rear_body(rider))
            .store_rear_body(&mut p);
        p
    };
    let frame = bicycle.parameters;
    let joined = join(&frame, &rider);
    // First-order propagation: each input moved by its deviation, results added in squares.
    let mut variance = [0.0; RIDER_KEYS.len()];
    let mut known = false;
    for key in RIDER_KEYS {
        let moved = |p: &Parameters, sd: f64| {
            let mut p = *p;
            let value = p.get(key).unwrap_or(0.0);
            // Straight, unchecked: a deviation may reach past what a value may be.
            p.nudge(key, value + sd);
            p
        };
        let mut add = |p: Parameters| {
            for (sum, out) in variance.iter_mut().zip(RIDER_KEYS) {
                let d = p.get(out).unwrap_or(0.0) - joined.get(out).unwrap_or(0.0);
                *sum += d * d;
            }
        };
        if let Some(sd) = bicycle.standard_deviations.get(key) {
            known = true;
            add(join(&moved(&frame, *sd), &rider));
        }
        if let Some(sd) = entries[key].sd {
            known = true;
            add(join(&frame, &moved(&rider, sd)));
        }
    }
    bicycle.parameters = joined;
    bicycle.remarks = bicycle.validate().map_err(|source| BicycleError::InFile {
        path: path.to_owned(),
        source: Box::new(source),
    })?;
    for (key, sum) in RIDER_KEYS.into_iter().zip(variance).filter(|_| known) {
        bicycle.standard_deviations.insert(key, libm::sqrt(sum));
    }
    bicycle.name = format!("{}+{name}", bicycle.name);
    bicycle.source = format!("{} + {}", bicycle.source, path.display());
    Ok(bicycle)
}
