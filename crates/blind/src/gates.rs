//! Every threshold of the suite. The hash of this file is printed with the metrics, so that a moved
//! threshold shows.

/// Share of clean sets with a named cause, and the upper end of its 95 % interval.
pub const FALSE_CAUSE: [f64; 2] = [0.02, 0.0];
pub const FALSE_CAUSE_UPPER: f64 = 0.05;
/// Smallest p-value, over all mechanisms, of the test for uniform p-values on clean sets; the tests
/// count as many as there are mechanisms.
pub const UNIFORM_P: f64 = 0.01;
/// Share found from twice the printed limit.
pub const DETECTED: [f64; 2] = [0.90, 0.98];
pub const DETECTED_FROM: f64 = 2.0;
/// Share whose first cause is the hidden one, from four times the limit.
pub const FIRST: [f64; 2] = [0.85, 0.95];
pub const FIRST_FROM: f64 = 4.0;
/// Share of named sets of causes that hold the hidden one, and their median size.
pub const COVERED: [f64; 2] = [0.95, 0.99];
pub const SET_SIZE: [f64; 2] = [2.0, 1.0];
/// Share of confounded pairs answered as a set that the proposed experiment then resolves.
pub const RESOLVED: [f64; 2] = [0.90, 1.0];
/// Median error of the parameter, and share of its 95 % intervals that hold the truth: from, to.
pub const PARAMETER_ERROR: [f64; 2] = [0.15, 0.05];
pub const COVERAGE: [[f64; 2]; 2] = [[0.90, 0.98], [0.93, 0.97]];
/// Median of held-out gain over that of the model told the truth.
pub const GAIN_RATIO: [f64; 2] = [0.9, 0.98];
/// Outside the library: share with a confirmed name; share with the right equation and band.
pub const WRONG_NAME: [f64; 2] = [0.05, 0.01];
pub const LOCATED: [f64; 2] = [0.70, 0.90];
/// Share of two effects both named, each from four times its limit.
pub const BOTH: [f64; 2] = [0.70, 0.90];
/// Seconds for one diagnosis of seven rides of 60 s, on one core.
pub const SECONDS: [f64; 2] = [10.0, 1.0];
/// Share with a named cause where parameters spread twice as far as declared.
pub const MISMATCHED: [f64; 2] = [0.05, 0.02];
/// Shifted inputs and mixed bicycles: share with a named cause; share called bad data or unknown.
pub const CONTROL_CAUSE: [f64; 2] = [0.0, 0.0];
pub const CONTROL_VERDICT: [f64; 2] = [0.95, 1.0];
/// Sizes of single effects, in multiples of the printed limit.
pub const MULTIPLES: [f64; 8] = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0];
/// Sizes of the two effects of a pair, from and to.
pub const TWO_MULTIPLES: [f64; 2] = [4.0, 8.0];
/// Share of sets of each kind, in multiples of the suite's size: the suite itself, then clean sets of
/// their own, mismatched tolerances, controls of each sort, confounded pairs.
pub const SHARE_CLEAN: f64 = 0.25;
pub const SHARE_ONE: f64 = 0.45;
pub const SHARE_TWO: f64 = 0.15;
pub const SHARE_OUTSIDE: f64 = 0.15;
pub const OWN_CLEAN: f64 = 1.0;
pub const OWN_MISMATCHED: f64 = 0.33;
pub const OWN_CONTROL: f64 = 0.1;
pub const OWN_CONFOUNDED: f64 = 0.2;

/// Hash of this file.
pub fn hash() -> String {
    blake3::hash(include_bytes!("gates.rs")).to_hex()[..16].to_owned()
}
