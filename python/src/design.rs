//! Schedules with their proof.

use crate::errors;
use crate::watched::{texts, watched};
use pyo3::prelude::*;
use twinhub_design::plan::{Progress, run};
use twinhub_design::summary::summary;
use twinhub_design::{Ask, DesignError, law};
use twinhub_plant::bicycles::load_multibody;
use twinhub_sim::bicycle::ResolvedBicycle;

/// The design in short, as JSON; the law, TOML; its proof, JSON.
#[pyfunction]
pub fn design(
    py: Python<'_>,
    ask: &str,
    progress: Option<Py<PyAny>>,
) -> PyResult<(String, String, String)> {
    let ask: Ask = serde_json::from_str(ask).map_err(errors::input)?;
    let plan = ask.plan().map_err(errors::input)?;
    let none: [&str; 0] = [];
    let parameters = load_multibody(&plan.bicycle, &none).map_err(errors::input)?;
    let found = watched(py, texts(progress.as_ref()), move |teller| {
        let watch = |p: Progress| {
            let go_on = teller.go_on();
            if go_on && p.of > 0 {
                teller.tell(format!("{}: {} of {}", p.doing, p.done, p.of));
            }
            go_on
        };
        let certificate = run(&plan, &parameters, &watch)?;
        let told = ResolvedBicycle::multibody(parameters.clone()).control();
        let law = law::file(&certificate, &told)?;
        Ok::<_, DesignError>((certificate, law))
    })?;
    let (certificate, law) = found.map_err(errors::input)?;
    let proof = serde_json::to_string(&certificate).map_err(errors::input)?;
    Ok((summary(&certificate).to_string(), law, proof))
}
