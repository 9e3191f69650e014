//! The stabilizer on hard ground: jumps of friction, and what it knows of its roll.

mod friction_jumps;
mod roll_estimate;
