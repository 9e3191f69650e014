//! What: the pieces of a proof, as they are found and as they are checked: loops at corners and edges
//! of a box, along a cell.
//!
//! Assumes and ignores: beside its corners every box is looked at in its middle, where the bicycle
//! need not be the mean of the corners.

use crate::DesignError;
use crate::certificate::Point;
use crate::family::{FactorBox, Factors, Family, Member, Vehicle};
use crate::inequality::{Along, proved};
use crate::loops::{Gains, Loop, Rider};
use nalgebra::DMatrix;

/// The bicycles of a box: its corners, and its middle.
pub struct Bicycles {
    members: Vec<Member>,
}

impl Bicycles {
    /// Of this box.
    ///
    /// # Errors
    /// If a parameter leaves its range.
    pub fn new(family: &Family, factors: &FactorBox) -> Result<Self, DesignError> {
        let mut all: Vec<Factors> = factors.corners();
        if all.len() > 1 {
            all.push(factors.middle());
        }
        let members: Result<Vec<Member>, _> = all.iter().map(|f| family.member(f)).collect();
        Ok(Self { members: members? })
    }

    /// Each of them at both edges of the tube.
    ///
    /// # Errors
    /// If there is no steady state there.
    pub fn at(&self, speed_m_s: f64, edges_nm: [f64; 2]) -> Result<Vec<Vehicle>, DesignError> {
        let mut vehicles = Vec::with_capacity(2 * self.members.len());
        for member in &self.members {
            for edge_nm in edges_nm {
                vehicles.push(member.at(speed_m_s, edge_nm)?);
            }
        }
        Ok(vehicles)
    }

    /// Each of them without a pair.
    ///
    /// # Errors
    /// If there is no steady state there.
    pub fn alone(&self, speed_m_s: f64) -> Result<Vec<Vehicle>, DesignError> {
        self.members.iter().map(|m| m.at(speed_m_s, 0.0)).collect()
    }
}

/// A rider's node: where it is, and the loops at corners and edges.
pub struct At {
    /// Schedule and tube.
    pub point: Point,
    /// Gains.
    pub gains: Gains,
    /// Loops at corners and edges.
    pub loops: Vec<Loop>,
}

impl At {
    /// The node of `rider` with `gains` on these bicycles.
    ///
    /// # Errors
    /// If there is no steady state there.
    pub fn new(
        rider: &Rider,
        bicycles: &Bicycles,
        point: &Point,
        gains: &Gains,
    ) -> Result<Self, DesignError> {
        let vehicles = bicycles.at(point.speed_m_s, [point.from_nm, point.to_nm])?;
        Ok(Self {
            point: *point,
            gains: *gains,
            loops: rider.close_all(&vehicles, gains),
        })
    }
}

/// What lies between two nodes.
pub struct Cell {
    /// Loops halfway, at corners and edges.
    middle: Vec<Loop>,
    width_m_s: f64,
}

impl Cell {
    /// Between these nodes, for one rider and box.
    ///
    /// # Errors
    /// If there is no steady state in its middle.
    pub fn new(
        rider: &Rider,
        bicycles: &Bicycles,
        [first, second]: [&At; 2],
    ) -> Result<Self, DesignError> {
        let mean = |a: f64, b: f64| 0.5 * (a + b);
        let speed_m_s = mean(first.point.speed_m_s, second.point.speed_m_s);
        let edges_nm = [
            mean(first.point.from_nm, second.point.from_nm),
            mean(first.point.to_nm, second.point.to_nm),
        ];
        let gains: Gains = core::array::from_fn(|k| mean(first.gains[k], second.gains[k]));
        Ok(Self {
            middle: rider.close_all(&bicycles.at(speed_m_s, edges_nm)?, &gains),
            width_m_s: (second.point.speed_m_s - first.point.speed_m_s).abs(),
        })
    }

    /// Is it proved by these Lyapunov matrices at its nodes?
    pub fn is_proved(
        &self,
        [first, second]: [&At; 2],
        p: [&DMatrix<f64>; 2],
        rate_m_s2: f64,
    ) -> bool {
        let ends = first.loops.iter().zip(&second.loops);
        ends.zip(&self.middle).all(|((first, second), middle)| {
            let along = Along {
                first,
                middle,
                second,
            };
            proved(&along, p, rate_m_s2, self.width_m_s)
        })
    }
}
