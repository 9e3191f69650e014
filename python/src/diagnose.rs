//! What the model gets wrong about measured rides.

use crate::errors;
use crate::watched::{texts, watched};
use pyo3::prelude::*;
use std::path::PathBuf;
use twinhub_diagnose::data::{DataFolders, RideData, read_ride};
use twinhub_diagnose::search::experiment::experiment as what_rides_show;
use twinhub_diagnose::search::{Options, diagnose_in};
use twinhub_diagnose::study::Study;

/// The answer as JSON, and the extended plant as TOML if there is one.
#[pyfunction]
pub fn diagnose(
    py: Python<'_>,
    study: &str,
    data: Option<PathBuf>,
    assignments: Vec<String>,
    without: Vec<String>,
    only: Vec<String>,
    progress: Option<Py<PyAny>>,
) -> PyResult<(String, Option<String>)> {
    let study = Study::read(study, &assignments).map_err(errors::input)?;
    let found = watched(py, texts(progress.as_ref()), move |teller| {
        let folders = DataFolders::new(&study, data.as_deref());
        let options = Options { without, only };
        diagnose_in(&study, &folders, &options, &mut |text| {
            teller.tell(text.to_owned())
        })
        .map_err(|e| e.to_string())
    })?;
    let answer = found.map_err(errors::input)?;
    let plant = answer.plant.as_ref().map(|plant| plant.to_toml());
    let text = serde_json::to_string(&answer).map_err(errors::input)?;
    Ok((text, plant))
}

/// What rides like these could show, as JSON.
#[pyfunction]
pub fn experiment(
    py: Python<'_>,
    study: &str,
    data: Option<PathBuf>,
    assignments: Vec<String>,
    progress: Option<Py<PyAny>>,
) -> PyResult<String> {
    let study = Study::read(study, &assignments).map_err(errors::input)?;
    let found = watched(py, texts(progress.as_ref()), move |teller| {
        let folders = DataFolders::new(&study, data.as_deref());
        let rides: Vec<RideData> = study
            .rides
            .iter()
            .map(|ride| {
                teller.tell(format!("reading {}", ride.file));
                read_ride(ride, &folders).map_err(|e| e.to_string())
            })
            .collect::<Result<_, _>>()?;
        what_rides_show(&study, &rides, &mut |text| teller.tell(text.to_owned()))
            .map_err(|e| e.to_string())
    })?;
    serde_json::to_string(&found.map_err(errors::input)?).map_err(errors::input)
}
