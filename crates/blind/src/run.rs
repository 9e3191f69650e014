//! One set: made, sized by the printed limits, diagnosed, its answer kept beside the truth.

use crate::engine::{Ask, Engine};
use crate::plan::Planned;
use crate::reading::Reading;
use serde::{Deserialize, Serialize};
use std::path::Path;
use std::time::Instant;
use twinhub_hidden::{Kind, Scenario, SealError, SealedAnswer};

/// What came of one set.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Outcome {
    pub planned: Planned,
    pub truth: SealedAnswer,
    /// Size of each effect over its printed limit; none where no limit is printed.
    pub multiples: Vec<Option<f64>>,
    pub found: Reading,
    /// Of the rides that part a confounded pair.
    pub separated: Option<Reading>,
    /// Held-out gain of the model told what is hidden.
    pub oracle_nats: Option<f64>,
    pub seconds: f64,
}

/// Why a set gave no outcome.
#[non_exhaustive]
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    #[error("set {kind} {seed}: no such kind; accepted: {}", Kind::ALL.map(Kind::name).join(", "))]
    Kind { kind: String, seed: u64 },
    #[error("set {kind} {seed}: {source}")]
    Seal {
        kind: String,
        seed: u64,
        source: Box<SealError>,
    },
    #[error("set {kind} {seed}: no folder for it: {source}")]
    Folder {
        kind: String,
        seed: u64,
        source: std::io::Error,
    },
    #[error("set {kind} {seed}: the diagnosis refuses it: {message}; accepted: every sealed study")]
    Refused {
        kind: String,
        seed: u64,
        message: String,
    },
}

/// Makes the set and has it diagnosed.
pub fn run(engine: &impl Engine, planned: &Planned) -> Result<Outcome, RunError> {
    let kind = Kind::named(&planned.kind).ok_or_else(|| RunError::Kind {
        kind: planned.kind.clone(),
        seed: planned.seed,
    })?;
    run_scenario(engine, planned, &Scenario::new(kind, planned.seed))
}

/// As `run`, with a scenario of the caller's.
pub fn run_scenario(
    engine: &impl Engine,
    planned: &Planned,
    scenario: &Scenario,
) -> Result<Outcome, RunError> {
    let (kind, seed) = (planned.kind.clone(), planned.seed);
    let folder = tempfile::tempdir().map_err(|source| RunError::Folder {
        kind: kind.clone(),
        seed,
        source,
    })?;
    let write = |scenario: &Scenario, name: &str| {
        let seal = |source| RunError::Seal {
            kind: kind.clone(),
            seed,
            source: Box::new(source),
        };
        let sealed = scenario.seal().map_err(seal)?;
        let study = sealed.write(&folder.path().join(name)).map_err(seal)?;
        Ok((study, sealed.answer))
    };
    let refused = |message| RunError::Refused {
        kind: kind.clone(),
        seed,
        message,
    };
    let ask = |study: &Path, ask: &Ask| engine.diagnose(study, ask).map_err(refused);
    let sized = matches!(
        scenario.kind,
        Kind::OneEffect | Kind::TwoEffects | Kind::Confounded
    );
    let mut limits = vec![None; scenario.hidden.len()];
    let mut scenario = scenario.clone();
    if sized {
        let (study, _) = write(&scenario.clean_twin(), "clean")?;
        let printed = engine.limits(&study).map_err(refused)?;
        limits = scenario
            .hidden
            .iter()
            .map(|h| printed.limit(h.effect.name, h.effect.parameter))
            .collect();
        let sizes: Vec<f64> = (scenario.hidden.iter().zip(&limits).zip(&planned.multiples))
            .map(|((h, limit), m)| limit.map_or(h.size.abs(), |l| l * m))
            .collect();
        scenario = scenario.sized(&sizes);
    }
    let (study, truth) = write(&scenario, "study")?;
    let start = Instant::now();
    let found = ask(&study, &Ask::default())?;
    let seconds = start.elapsed().as_secs_f64();
    let multiples: Vec<Option<f64>> = (truth.effects.iter().zip(&limits))
        .map(|(e, limit)| limit.map(|l| e.size.abs() / l))
        .collect();
    let oracle_nats = match planned.oracle {
        true => {
            let only = truth.effects.iter().map(|e| e.mechanism.clone()).collect();
            let told = ask(
                &study,
                &Ask {
                    only,
                    ..Ask::default()
                },
            )?;
            Some(told.gain_nats())
        }
        false => None,
    };
    let separated = match scenario.pair {
        Some(pair) => {
            let (study, _) = write(&scenario.separated(pair.separate), "separated")?;
            Some(ask(&study, &Ask::default())?)
        }
        None => None,
    };
    Ok(Outcome {
        planned: planned.clone(),
        truth,
        multiples,
        found,
        separated,
        oracle_nats,
        seconds,
    })
}
