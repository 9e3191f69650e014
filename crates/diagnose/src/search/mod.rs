//! Which cause: baseline, tests, refits, decision on held-out rides.

pub mod answer;
mod contender;
mod decide;
mod disagreement;
pub mod experiment;
mod faults;
mod fitting;
mod gain;
mod greedy;
mod latent;
mod levels;
mod limits;
mod locate;
mod matched;
mod modes;
pub mod phases;
mod pictures;
mod probe;
mod random;
mod refit;
mod rides;
mod run;
mod score;
mod screen;
mod skew;
mod step;
mod testable;
pub mod thresholds;
mod tolerance;
mod verdict;
mod wide;
mod words;

pub use answer::{Answer, Verdict};
pub use run::{DiagnoseError, Options, diagnose, diagnose_data, diagnose_in};
