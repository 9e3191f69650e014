//! The rules that every ride rests on, seen from outside.

mod faults;
mod frames;
mod guard;
mod limits;
mod referee;
