#![forbid(unsafe_code)]
//! The figures of Bulsink (2017) beside those of the multibody model.
//!
//! [`reproduce`] gives one row for every figure that the source states, with one set of assumptions
//! ([`Assumed`]) for all of them, and for each miss the assumptions that move it with the values that
//! would meet it. [`method::TRIALS`] has the thesis's own method (a push and a fit of four poles)
//! beside the linearised model, [`figures::all`] the figures drawn again, [`readings`] the count of
//! agreeing rows for every named alternative.

pub mod assumed;
pub mod chapter3;
pub mod chapter6;
pub mod chapter7;
pub mod error;
pub mod figures;
pub mod markdown;
pub mod method;
pub mod misses;
pub mod motion;
pub mod push;
pub mod row;
pub mod stability;
mod work;

pub use assumed::Assumed;
pub use error::ReproduceError;
pub use method::Method;
pub use row::{Figure, Row, Verdict};

/// Ids of all rows, in the order of the source.
pub const IDS: &[&str] = &[
    "benchmark_weave",
    "benchmark_capsize",
    "benchmark_mf_weave",
    "benchmark_mf_capsize_stable",
    "case1_weave",
    "case1_capsize",
    "case2_effect",
    "case3_effect",
    "case4_effect",
    "case5_range_low",
    "case5_range_high",
    "case5_limit",
    "case6_weave",
    "case6_capsize_stable",
    "case7_weave_400n",
    "case7_weave_600n",
    "sens_cornering",
    "sens_camber",
    "sens_twisting",
    "sens_trail",
    "sens_overturning",
    "arm_damping_weave",
    "rear_drive_weave",
    "front_drive_weave",
    "pair_100nm_percent",
    "pair_7ms_verdict",
    "corner_front_verdict",
    "corner_rear_verdict",
    "rider_table_6_2",
    "rider_table_6_3",
    "rider_table_6_4",
];

/// A part of the table that is computed together.
type Section = fn(&Assumed) -> Result<Vec<Row>, ReproduceError>;

/// The longest first, so that two threads end together.
const SECTIONS: &[(&[&str], Section)] = &[
    (&["sens_"], chapter3::sensitivities),
    (&["pair_100nm"], chapter7::two_motors),
    (&["case6_", "case7_"], chapter3::tyre_cases),
    (&["rear_drive", "front_drive"], chapter7::one_motor),
    (&["case5_"], chapter3::arm_stiffness),
    (&["arm_damping"], chapter3::arm_damping),
    (&["benchmark_"], chapter3::benchmark),
    (
        &["case1_", "case2_", "case3_", "case4_"],
        chapter3::no_slip_cases,
    ),
    (&["pair_7ms"], chapter7::push_at_7),
    (&["corner_"], chapter7::corners),
    (&["rider_"], chapter6::riders),
];

/// Everything that was reproduced.
#[derive(Clone, Debug)]
pub struct Reproduction {
    /// The assumptions behind every row.
    pub assumed: Assumed,
    /// Rows in the order of [`IDS`].
    pub rows: Vec<Row>,
    /// The thesis's own method beside the linearised model.
    pub method: Vec<Method>,
}

impl Reproduction {
    /// Rows that agree: met, or the same words.
    pub fn agreeing(&self) -> usize {
        agreeing(&self.rows)
    }
}

fn agreeing(rows: &[Row]) -> usize {
    rows.iter().filter(|r| r.verdict.agrees()).count()
}

/// The rows whose ids are in `only` (all if it is empty), and the method's comparison if all are
/// asked for, on `threads` threads. `progress` is told how many parts are done, and of how many.
///
/// # Errors
/// If the model has no steady state where it is asked for one.
pub fn reproduce(
    assumed: &Assumed,
    only: &[String],
    threads: usize,
    progress: &(dyn Fn(usize, usize) + Sync),
) -> Result<Reproduction, ReproduceError> {
    let wanted = |id: &str| only.is_empty() || only.iter().any(|o| o == id);
    let sections: Vec<&Section> = SECTIONS
        .iter()
        .filter(|(prefixes, _)| {
            IDS.iter()
                .any(|id| wanted(id) && prefixes.iter().any(|p| id.starts_with(p)))
        })
        .map(|(_, section)| section)
        .collect();
    let trials = if only.is_empty() { method::TRIALS } else { &[] };
    let parts = sections.len() + trials.len();
    let results = work::shared(parts, threads, progress, |k| {
        match k.checked_sub(sections.len()) {
            None => sections[k](assumed).map(Part::Rows),
            Some(t) => trials[t].run(assumed).map(Part::Method),
        }
    });
    let (mut rows, mut compared) = (Vec::new(), Vec::new());
    for result in results {
        match result? {
            Part::Rows(part) => rows.extend(part.into_iter().filter(|r| wanted(r.id))),
            Part::Method(method) => compared.push(method),
        }
    }
    rows.sort_by_key(|row| IDS.iter().position(|id| *id == row.id));
    Ok(Reproduction {
        assumed: *assumed,
        rows,
        method: compared,
    })
}

enum Part {
    Rows(Vec<Row>),
    Method(Method),
}

/// How many rows agree under every named set of assumptions, without looking for what moves the
/// misses.
///
/// # Errors
/// As [`reproduce`].
pub fn readings(
    threads: usize,
    progress: &(dyn Fn(usize, usize) + Sync),
) -> Result<Vec<(Assumed, usize)>, ReproduceError> {
    let all = Assumed::all();
    let counts = work::shared(all.len(), threads, progress, |k| {
        let quick = Assumed {
            explain_misses: false,
            ..all[k]
        };
        let mut rows = Vec::new();
        for (_, section) in SECTIONS {
            rows.extend(section(&quick)?);
        }
        Ok::<_, ReproduceError>(agreeing(&rows))
    });
    all.into_iter()
        .zip(counts)
        .map(|(assumed, count)| Ok((assumed, count?)))
        .collect()
}
