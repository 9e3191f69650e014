//! The stabilizer on tyres: jumps of friction, what it knows of its roll, and hours of use.

mod friction_jumps;
mod long_ride;
mod roll_estimate;
