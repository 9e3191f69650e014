#![forbid(unsafe_code)]
//! The blind suite: sealed data of `twinhub-hidden` through a diagnosis, scored against the answers.
//!
//! [`plan::plan`] says which sets, [`run::run`] makes and sizes one and has it diagnosed,
//! [`suite::suite`] does all on all cores, [`metrics::metrics`] scores them. Every threshold stands in
//! [`gates`]. The scoring reads nothing but the diagnosis' public JSON; [`Product`] is ours.

pub mod engine;
pub mod gates;
pub mod interval;
pub mod metrics;
#[cfg(test)]
mod metrics_test;
pub mod plan;
pub mod product;
pub mod reading;
pub mod run;
pub mod suite;
pub mod wrong;

pub use engine::{Ask, Engine};
pub use metrics::{Metric, metrics};
pub use plan::{Planned, plan};
pub use product::Product;
pub use reading::Reading;
pub use run::{Outcome, RunError, run, run_scenario};
pub use suite::{SuiteError, suite, timing};
