//! The file of a certificate: all that `check` needs, and nothing that has to be believed.

use crate::DesignError;
use crate::family::FactorBox;
use crate::loops::{Gains, Rider};
use crate::program::Cones;
use crate::symmetric::full;
use nalgebra::DMatrix;
use serde::{Deserialize, Serialize};

/// Version of the file.
pub const SCHEMA_VERSION: u32 = 1;

/// What is to be certified.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Plan {
    /// A bicycle that ships, or its file.
    pub bicycle: String,
    /// The rider's joints move; locked, the rider's body is one with the frame.
    pub joints_free: bool,
    /// Who rides, and into how many boxes mass, load and twisting torque are cut for them: the rider
    /// is used to a bicycle of the box.
    pub riders: Vec<Entry>,
    /// What may differ from the bicycle.
    pub uncertainty: FactorBox,
    /// Nodes, m/s, rising.
    pub speeds_m_s: Vec<f64>,
    /// Largest pair, Nm.
    pub torque_max_nm: f64,
    /// Half the width of the tube, Nm.
    pub half_width_nm: f64,
    /// Fastest change of speed, m/s².
    pub rate_m_s2: f64,
    /// Steepest schedule, Nm per m/s.
    pub slope_nm_per_m_s: f64,
    /// Largest growth rate after the pair is lost at once, 1/s.
    pub loss_growth_per_s: f64,
    /// Least friction that has to carry four fifths of the pair.
    pub friction_ratio: f64,
    /// What the search holds matrices positive by; a check does not ask.
    #[serde(default)]
    pub cones: Cones,
}

/// One rider of the set.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Entry {
    /// The rider.
    pub rider: Rider,
    /// Boxes along mass, load and twisting torque.
    pub parts: [usize; 3],
}

/// The schedule and its tube at a node.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Point {
    /// Speed, m/s.
    pub speed_m_s: f64,
    /// The schedule, Nm.
    pub torque_nm: f64,
    /// Lower edge of the tube, Nm.
    pub from_nm: f64,
    /// Upper edge of the tube, Nm.
    pub to_nm: f64,
}

/// A rider used to a box of bicycles, at one speed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Node {
    /// The rider's gains.
    pub gains: Gains,
    /// Largest growth rate in the tube, 1/s.
    pub growth_per_s: f64,
    /// Largest growth rate after the pair is lost, 1/s.
    pub loss_growth_per_s: f64,
    /// Upper triangle of the Lyapunov matrix by rows; empty: none was found.
    pub lyapunov: Vec<f64>,
}

/// One rider on one box of bicycles.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Piece {
    /// Which rider of the plan.
    pub rider: usize,
    /// Which bicycles.
    pub factors: FactorBox,
    /// At each node.
    pub nodes: Vec<Node>,
}

/// What stops the certificate between two speeds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Stop {
    /// From and to, m/s.
    pub speeds_m_s: [f64; 2],
    /// Name of the rider who is stopped first.
    pub rider: String,
    /// What would have to be smaller: any one of these; empty: not one of them alone.
    pub because: Vec<String>,
}

/// A schedule with its proof.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Certificate {
    /// Version of the file.
    pub schema_version: u32,
    /// What was asked for.
    pub plan: Plan,
    /// Every parameter of the bicycle, as TOML: the proof is for this one.
    pub bicycle_toml: String,
    /// Schedule and tube at the nodes.
    pub schedule: Vec<Point>,
    /// Cells between nodes that are proved for every rider and box.
    pub cells: Vec<bool>,
    /// The proof.
    pub pieces: Vec<Piece>,
    /// Why cells are not proved.
    pub stops: Vec<Stop>,
}

impl Node {
    /// The Lyapunov matrix, n by n.
    pub fn matrix(&self) -> Option<DMatrix<f64>> {
        let count = self.lyapunov.len();
        let n = (0..200).find(|n| n * (n + 1) / 2 == count)?;
        if n == 0 {
            return None;
        }
        Some(full(n, &self.lyapunov))
    }
}

/// Is every cell at node `k` proved?
pub fn proved_at(cells: &[bool], k: usize) -> bool {
    (k == 0 || cells[k - 1]) && (k == cells.len() || cells[k])
}

impl Plan {
    /// Every rider with every box, in the order of the pieces.
    pub fn boxes(&self) -> Vec<(usize, FactorBox)> {
        let of = |(rider, entry): (usize, &Entry)| {
            let boxes = self.uncertainty.split(entry.parts);
            boxes.into_iter().map(move |b| (rider, b))
        };
        self.riders.iter().enumerate().flat_map(of).collect()
    }

    /// The first rule that the plan breaks.
    ///
    /// # Errors
    /// What is wrong, what was found and what would be accepted.
    pub fn check(&self) -> Result<(), DesignError> {
        let within = |what: &str, found: f64, least: f64, most: f64| {
            if found >= least && found <= most {
                Ok(())
            } else {
                Err(DesignError::Plan(format!(
                    "{what} is {found}; accepted: {least} to {most}"
                )))
            }
        };
        if self.riders.is_empty() {
            return Err(DesignError::Plan(
                "no rider; accepted: one or more".to_owned(),
            ));
        }
        for Entry { rider, parts } in &self.riders {
            within(
                &format!("delay of rider {}, s", rider.name),
                rider.delay_s,
                0.01,
                0.5,
            )?;
            for part in parts {
                within("boxes along a factor", *part as f64, 1.0, 100.0)?;
            }
        }
        for (what, [from, to]) in [
            ("mass", self.uncertainty.mass),
            ("load", self.uncertainty.load),
            ("twisting", self.uncertainty.twisting),
        ] {
            within(&format!("least factor on {what}"), from, 0.05, 1.0)?;
            within(&format!("largest factor on {what}"), to, 1.0, 5.0)?;
        }
        if self.speeds_m_s.len() < 3 || !self.speeds_m_s.windows(2).all(|w| w[1] - w[0] >= 0.01) {
            return Err(DesignError::Plan(
                "speeds have to be three or more and rise by 0.01 m/s or more".to_owned(),
            ));
        }
        within("slowest speed, m/s", self.speeds_m_s[0], 0.5, 20.0)?;
        within(
            "fastest speed, m/s",
            self.speeds_m_s[self.speeds_m_s.len() - 1],
            0.5,
            20.0,
        )?;
        within("largest pair, Nm", self.torque_max_nm, 0.0, 100.0)?;
        within(
            "half the width of the tube, Nm",
            self.half_width_nm,
            0.1,
            50.0,
        )?;
        within("fastest change of speed, m/s²", self.rate_m_s2, 0.0, 5.0)?;
        within(
            "steepest schedule, Nm per m/s",
            self.slope_nm_per_m_s,
            0.1,
            500.0,
        )?;
        within(
            "growth after a loss, 1/s",
            self.loss_growth_per_s,
            -5.0,
            5.0,
        )?;
        within("friction", self.friction_ratio, 0.05, 1.2)
    }
}
