//! The multibody model against the benchmark, against itself, and against its limits.

mod benchmark;
mod friction;
mod motion;
mod pair;
