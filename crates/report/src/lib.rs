//! report

pub mod modes_picture;
