#![forbid(unsafe_code)]
//! Reports: self-contained HTML pages with inline SVG. No script, no network, light and dark,
//! printable.
//!
//! [`ride`] is the page of a ride, [`modes_picture`] the picture of the eigenvalues over speed,
//! [`reproduce`] the page of published figures beside ours.
//! New pages are made of [`page`] (shell, tables, verdict) and [`chart`] (lines over a shared x
//! axis). All take plain numbers and text; degrees appear here and nowhere before.

pub mod axis;
pub mod blind;
pub mod chart;
pub mod compare;
pub mod design;
pub mod diagnose;
pub mod league;
pub mod line;
pub mod map_picture;
pub mod modes_picture;
pub mod page;
pub mod reproduce;
pub mod ride;
pub mod text;
