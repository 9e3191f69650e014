//! Does a controller harm anybody? Falls against those without a stabilizer, cell by cell.
//!
//! What: for each class of riders, band of speeds and surface, the share of rides that end in a fall
//! with the controller less the share without (the first controller), on the same riders and courses.
//! A cell is `no worse` if the upper end of the interval lies within [`MARGIN`], `worse` if the lower
//! end lies above zero, else `undecided`: it has too few rides to tell.
//!
//! Equation: interval of Bonett and Price, its confidence 1 - 0.05 / (number of cells) (Bonferroni).

use crate::course::Surface;
use crate::interval::paired_difference;
use crate::league::Part;
use crate::spec::Spec;
use serde::Serialize;

/// Difference of falling rides (of a minute, unless the league says otherwise) that counts as none.
pub const MARGIN: f64 = 0.05;

/// Bands of the mean speed, m/s.
pub const BANDS_M_S: [[f64; 2]; 3] = [[3.0, 4.5], [4.5, 6.0], [6.0, 8.01]];

/// A class of riders at a band of speeds on a surface, with one controller.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Cell {
    /// The controller.
    pub controller: String,
    /// The riders.
    pub class: &'static str,
    /// The band, m/s.
    pub speeds_m_s: [f64; 2],
    /// The surface.
    pub surface: &'static str,
    /// Rides.
    pub rides: u64,
    /// Rides that fell without and with the controller.
    pub falls_without: u64,
    /// ... with it.
    pub falls_with: u64,
    /// Share of falling rides with the controller less that without.
    pub difference: f64,
    /// Its interval, corrected for the number of cells.
    pub interval: [f64; 2],
    /// `no worse`, `worse` or `undecided`.
    pub verdict: &'static str,
}

/// Every cell with a ride in it, for every controller but the first.
pub fn harm(spec: &Spec, parts: &[Part]) -> Vec<Cell> {
    let mut groups: Vec<(&'static str, [f64; 2], &'static str, Vec<&Part>)> = Vec::new();
    for class in &spec.classes {
        for band in BANDS_M_S {
            for surface in Surface::ALL {
                let inside = |part: &&Part| {
                    part.class == *class
                        && part.surface == surface
                        && (band[0]..band[1]).contains(&part.speed_m_s)
                };
                let parts: Vec<&Part> = parts.iter().filter(inside).collect();
                if !parts.is_empty() {
                    groups.push((class.name(), band, surface.name(), parts));
                }
            }
        }
    }
    let confidence = 1.0 - 0.05 / groups.len().max(1) as f64;
    let mut cells = Vec::new();
    for (index, contestant) in spec.controllers.iter().enumerate().skip(1) {
        for (class, speeds_m_s, surface, parts) in &groups {
            let count = |with: bool, without: bool| {
                let fell = |part: &&&Part| {
                    part.scores[index].metrics.fell == with
                        && part.scores[0].metrics.fell == without
                };
                parts.iter().filter(fell).count() as u64
            };
            let rides = parts.len() as u64;
            let (only_with, only_without) = (count(true, false), count(false, true));
            let both = count(true, true);
            let (difference, interval) =
                paired_difference(only_with, only_without, rides, confidence);
            let verdict = if interval[0] > 0.0 {
                "worse"
            } else if interval[1] <= MARGIN {
                "no worse"
            } else {
                "undecided"
            };
            cells.push(Cell {
                controller: contestant.name.clone(),
                class,
                speeds_m_s: *speeds_m_s,
                surface,
                rides,
                falls_without: both + only_without,
                falls_with: both + only_with,
                difference,
                interval,
                verdict,
            });
        }
    }
    cells
}
