#![forbid(unsafe_code)]
//! Controllers against each other over a population of riders, on paired seeds.
//!
//! A league is a list of numbered parts. A part is one rider on one course; every controller rides
//! it, so that what one gains over another is not luck. A part depends on the [`Spec`] and its own
//! number alone: parts can be run anywhere, in any order, and put together exactly.
//!
//! Read [`league`] first: it runs parts. [`population`] says who rides, [`course`] what is ridden,
//! [`practice`] how riders are used to what they ride; [`table`], [`harm`] and [`frontier`] say what
//! came out, [`file`] keeps it. [`faults`] breaks sensors and the link instead.

pub mod course;
mod error;
pub mod faults;
pub mod file;
pub mod frontier;
pub mod harm;
pub mod interval;
pub mod league;
pub mod population;
pub mod practice;
pub mod spec;
pub mod table;

pub use error::LeagueError;
pub use file::{Kept, merge};
pub use frontier::{Point, frontier};
pub use harm::{Cell, harm};
pub use interval::Estimate;
pub use league::{Answers, League, Part, Score};
pub use population::Class;
pub use spec::{Contestant, Spec};
pub use table::{Row, table};
