//! Controllers against each other: parts of a league, for any executor.

use crate::controller::PythonLaw;
use crate::errors::{self, keep};
use crate::ride::PythonRider;
use crate::watched::{Ended, end, panicked};
use pyo3::prelude::*;
use std::collections::HashMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use twinhub_control::{Config, Controller, Profile};
use twinhub_league::league::{Answers, Hand};
use twinhub_league::{Class, League, LeagueError, Part, Spec, frontier, harm, table};
use twinhub_plant::rider::Perception;
use twinhub_sim::in_process;
use twinhub_types::PlantFrame;

fn refused(error: LeagueError) -> PyErr {
    match error {
        LeagueError::File { .. } | LeagueError::Ride { .. } => {
            errors::python::RideError::new_err(error.to_string())
        }
        other => errors::input(other),
    }
}

/// The spec of a league, JSON.
#[pyfunction]
pub fn league_spec(
    seed: u64,
    riders: u64,
    classes: Vec<String>,
    duration_s: f64,
    controllers: Vec<(String, String)>,
    profile: Option<String>,
) -> PyResult<String> {
    let named = |name: &String| {
        Class::named(name).ok_or_else(|| {
            let names = Class::ALL.map(Class::name).join(", ");
            errors::input(format!("no class of riders {name:?}; accepted: {names}"))
        })
    };
    let classes: Vec<Class> = classes.iter().map(named).collect::<PyResult<_>>()?;
    let profile = match profile.as_deref() {
        None => None,
        Some("laboratory") => Some(Profile::Laboratory),
        Some("en15194") => Some(Profile::En15194),
        Some(other) => {
            return Err(errors::input(format!(
                "profile={other:?}; accepted: {}",
                Profile::NAMES.join(", ")
            )));
        }
    };
    // A law of the caller's own stands on the law file that it names.
    let files: Vec<String> = controllers.iter().map(|(_, file)| file.clone()).collect();
    let mut spec = Spec::new(seed, riders, &classes, duration_s, &[], profile).map_err(refused)?;
    for ((name, _), file) in controllers.iter().zip(&files) {
        if name == "off" {
            continue;
        }
        let one = Spec::new(
            seed,
            riders,
            &classes,
            duration_s,
            std::slice::from_ref(file),
            profile,
        );
        let mut contestant = one
            .map_err(refused)?
            .controllers
            .pop()
            .ok_or_else(|| errors::input("no controller"))?;
        contestant.name.clone_from(name);
        spec.controllers.push(contestant);
    }
    spec.check().map_err(refused)?;
    serde_json::to_string(&spec).map_err(errors::input)
}

/// Leagues that were set up: the gains that their riders practised are kept between parts.
static READY: Mutex<Vec<(String, Arc<League>)>> = Mutex::new(Vec::new());
/// How many of them.
const READY_MOST: usize = 4;

fn ready(spec: &str) -> PyResult<Arc<League>> {
    let mut ready = match READY.lock() {
        Ok(ready) => ready,
        Err(poisoned) => poisoned.into_inner(),
    };
    if let Some((_, league)) = ready.iter().find(|(known, _)| known == spec) {
        return Ok(Arc::clone(league));
    }
    let parsed: Spec = serde_json::from_str(spec).map_err(errors::input)?;
    let league = Arc::new(League::new(parsed).map_err(refused)?);
    if ready.len() == READY_MOST {
        ready.remove(0);
    }
    ready.push((spec.to_owned(), Arc::clone(&league)));
    Ok(league)
}

/// Tells the parts of a league that run in this process to end.
#[pyclass(name = "_Stop", module = "twinhub._twinhub", frozen)]
#[derive(Default)]
pub struct Stop {
    set: AtomicBool,
}

#[pymethods]
impl Stop {
    #[new]
    fn new() -> Self {
        Self::default()
    }

    /// Parts end with their next tick.
    fn set(&self) {
        self.set.store(true, Ordering::Relaxed);
    }
}

/// Part number `part`, JSON. `laws` are the controllers that are written in Python, by name; `rider` gives
/// a rider written in Python for each ride. What these raise ends the part with that tick; so does `stop`.
#[pyfunction]
pub fn league_part(
    py: Python<'_>,
    spec: &str,
    part: u64,
    laws: HashMap<String, Py<PyAny>>,
    stop: Option<&Bound<'_, Stop>>,
    rider: Option<Py<PyAny>>,
) -> PyResult<String> {
    let raised: Mutex<Option<PyErr>> = Mutex::new(None);
    let stop: Option<&Stop> = stop.map(Bound::get);
    let stopped = || stop.is_some_and(|stop| stop.set.load(Ordering::Relaxed));
    let found = py.detach(|| -> PyResult<Part> {
        let league = ready(spec)?;
        let parts = league.spec().parts();
        if part >= parts {
            return Err(errors::input(format!(
                "part {part}; accepted: 0 to {}",
                parts - 1
            )));
        }
        let go_on = || {
            if stopped() || raised.lock().is_ok_and(|raised| raised.is_some()) {
                end();
            }
        };
        // A law or a rider may remember: every ride gets one of its own.
        let begin = |start: &Py<PyAny>| {
            Python::attach(|py| start.call0(py)).unwrap_or_else(|error| {
                keep(&raised, error);
                end()
            })
        };
        let raised = &raised;
        let answers = |name: &str, config: &Config| -> Answers<'_> {
            let Some(start) = laws.get(name) else {
                let mut answer = in_process(config);
                return Box::new(move |frame: &PlantFrame| {
                    go_on();
                    answer(frame)
                });
            };
            let callable = begin(start);
            let mut controller = Controller::new(config);
            Box::new(move |frame: &PlantFrame| {
                let law = PythonLaw {
                    callable: &callable,
                    raised,
                };
                let answer = controller.answer_by(&mut |_, x, dt_s| law.demand(x, dt_s), frame);
                go_on();
                answer
            })
        };
        let hand = |start: &Py<PyAny>| -> Hand<'_> {
            let callable = begin(start);
            Box::new(move |perception: &Perception, step_s: f64| {
                let rider = PythonRider {
                    callable: &callable,
                    raised,
                };
                rider.act(perception, step_s)
            })
        };
        // Nothing of a part outlives it but the practised gains, which are whole or not there.
        let run = || match &rider {
            Some(start) => league.part_by(part, &answers, Some(&|| hand(start))),
            None => league.part_by(part, &answers, None),
        };
        match catch_unwind(AssertUnwindSafe(run)) {
            Ok(found) => found.map_err(refused),
            Err(panic) if panic.is::<Ended>() => {
                Err(errors::python::RideError::new_err("the league was stopped"))
            }
            Err(panic) => Err(panicked(&*panic)),
        }
    });
    if let Ok(Some(error)) = raised.into_inner() {
        return Err(error);
    }
    py.check_signals()?;
    serde_json::to_string(&found?).map_err(errors::input)
}

/// Rows, frontier and cells of harm of these parts, JSON.
#[pyfunction]
pub fn league_table(py: Python<'_>, spec: &str, parts: Vec<String>) -> PyResult<String> {
    py.detach(|| {
        let spec: Spec = serde_json::from_str(spec).map_err(errors::input)?;
        let mut parts: Vec<Part> = parts
            .iter()
            .map(|text| serde_json::from_str(text).map_err(errors::input))
            .collect::<PyResult<_>>()?;
        parts.sort_by_key(|part| part.part);
        let answer = serde_json::json!({
            "rows": table(&spec, &parts),
            "frontier": frontier(&spec, &parts),
            "harm": harm(&spec, &parts),
        });
        serde_json::to_string(&answer).map_err(errors::input)
    })
}
