//! The rides of a study: found, read, converted and checked.
//!
//! A file is looked for beside the study, then in the data folder given, then in `$TWINHUB_DATA`.
//! Values are converted by `scale` and `offset`; missing ones are left out, never filled.

mod checks;
mod csv;
mod table;

use crate::study::{ChannelSpec, Place, RideSpec, Study, TimeSpec, Use, WindowSpec};
use std::path::{Path, PathBuf};
use table::Table;

/// The environment variable that names the data folder.
pub const DATA_VARIABLE: &str = "TWINHUB_DATA";

/// Why a ride cannot be used.
#[non_exhaustive]
#[derive(Debug, thiserror::Error)]
pub enum DataError {
    #[error(
        "{place}: the ride {file} is missing; looked for {}; accepted: put it there, or point to the folder that holds it \
         with --data DIR or ${DATA_VARIABLE}",
        looked.iter().map(|p| p.display().to_string()).collect::<Vec<_>>().join(", ")
    )]
    Missing {
        place: Place,
        file: String,
        looked: Vec<PathBuf>,
    },
    #[error("cannot read {}: {source}", path.display())]
    Read {
        path: PathBuf,
        source: std::io::Error,
    },
    #[error("{}, line {line}, column {column}: found `{found}`; accepted: a finite number, or an empty cell or NaN where it is missing", path.display())]
    Cell {
        path: PathBuf,
        line: u64,
        column: String,
        found: String,
    },
    #[error("{}, line {line}: found {found}; accepted: {accepted}", path.display())]
    Row {
        path: PathBuf,
        line: u64,
        found: String,
        accepted: String,
    },
    #[error("{}: found {found}; accepted: {accepted}", path.display())]
    File {
        path: PathBuf,
        found: String,
        accepted: String,
    },
    #[error("{place}: column `{column}` is not in {}; accepted: {}", path.display(), available.join(", "))]
    Column {
        place: Place,
        path: PathBuf,
        column: String,
        available: Vec<String>,
    },
    #[error("{place}: found {found}; accepted: {accepted}")]
    Value {
        place: Place,
        found: String,
        accepted: String,
    },
    #[error(transparent)]
    Log(#[from] twinhub_log::LogError),
}

/// Something in the data that a reader should know, and what was done about it.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Finding {
    pub column: String,
    pub text: String,
}

/// One channel's samples in its quantity's unit, missing ones left out.
#[derive(Clone, Debug)]
pub struct Channel {
    pub spec: ChannelSpec,
    pub samples: Vec<(f64, f64)>,
    pub missing: usize,
}

/// One ride, read and checked.
#[derive(Clone, Debug)]
pub struct RideData {
    pub spec: RideSpec,
    pub path: PathBuf,
    pub channels: Vec<Channel>,
    pub windows: Vec<WindowSpec>,
    pub findings: Vec<Finding>,
}

/// Where rides are looked for.
#[derive(Clone, Debug, Default)]
pub struct DataFolders {
    folders: Vec<PathBuf>,
}

impl DataFolders {
    /// Beside the study, then `data`, then `$TWINHUB_DATA`.
    pub fn new(study: &Study, data: Option<&Path>) -> Self {
        let beside = study.file.parent().map(|p| {
            if p.as_os_str().is_empty() {
                PathBuf::from(".")
            } else {
                p.to_owned()
            }
        });
        let variable = std::env::var_os(DATA_VARIABLE)
            .filter(|v| !v.is_empty())
            .map(PathBuf::from);
        Self {
            folders: beside
                .into_iter()
                .chain(data.map(Path::to_owned))
                .chain(variable)
                .collect(),
        }
    }

    /// The path of a file of the study.
    pub fn find(&self, file: &str, place: &Place) -> Result<PathBuf, DataError> {
        let looked: Vec<PathBuf> = self.folders.iter().map(|f| f.join(file)).collect();
        match looked.iter().find(|p| p.is_file()) {
            Some(path) => Ok(path.clone()),
            None => Err(DataError::Missing {
                place: place.clone(),
                file: file.to_owned(),
                looked,
            }),
        }
    }
}

/// Reads one ride.
pub fn read_ride(spec: &RideSpec, folders: &DataFolders) -> Result<RideData, DataError> {
    let path = folders.find(&spec.file, &spec.place)?;
    let table = read_table(spec, &path)?;
    let mut findings = vec![];
    let mut channels = vec![];
    for (index, channel) in spec.channels.iter().enumerate() {
        let column = &table.columns[index];
        let all = column.values.iter().zip(&*column.times_s);
        let samples: Vec<(f64, f64)> = all
            .filter(|(v, _)| !v.is_nan())
            .map(|(v, t)| (*t, channel.scale * v + channel.offset))
            .collect();
        let missing = column.values.len() - samples.len();
        channels.push(Channel {
            spec: channel.clone(),
            samples,
            missing,
        });
    }
    let windows = checks::windows(spec, &path, &channels)?;
    checks::channels(&path, &mut channels, &windows, &mut findings)?;
    Ok(RideData {
        spec: spec.clone(),
        path,
        channels,
        windows,
        findings,
    })
}

fn read_table(spec: &RideSpec, path: &Path) -> Result<Table, DataError> {
    let name = path.to_string_lossy();
    match () {
        () if name.ends_with(".mcap") => table::from_log(spec, path),
        () if name.ends_with(".csv") || name.ends_with(".csv.gz") => csv::read(spec, path),
        () => Err(DataError::Value {
            place: spec.place.clone(),
            found: format!("ride file `{}`", spec.file),
            accepted: "a name that ends in .csv, .csv.gz or .mcap".to_owned(),
        }),
    }
}

impl RideData {
    /// The channel of a quantity that is used, not only looked at.
    pub fn used(&self, quantity: crate::Quantity) -> Option<&Channel> {
        self.channels
            .iter()
            .find(|c| c.spec.quantity == quantity && c.spec.role != crate::study::Role::Check)
    }

    /// Windows that may be fitted on.
    pub fn fit_windows(&self) -> impl Iterator<Item = &WindowSpec> {
        self.windows.iter().filter(|w| w.usage == Use::Fit)
    }
}

/// Whether the time of a ride is a column's.
pub(crate) fn time_column(spec: &RideSpec) -> Option<&str> {
    match &spec.time {
        TimeSpec::Column(name) => Some(name),
        TimeSpec::RateHz(_) | TimeSpec::Log => None,
    }
}
