//! What: the proof for one rider on one box of bicycles, from the highest speed down.
//!
//! Source: own; gains by `gains`, Lyapunov matrices by `cone`.

use crate::DesignError;
use crate::certificate::{Node, Piece, Plan, Point};
use crate::cone::{Climbed, climb_until};
use crate::family::{FactorBox, Family};
use crate::gains::gains;
use crate::loops::{Gains, Loop, Rider, growth_per_s};
use crate::proof::{At, Bicycles, cell, loops};
use crate::start::from_scratch;
use nalgebra::DMatrix;

/// Margin at which a climb from nothing ends, 1/s: what the next nodes live on.
const GOAL_PER_S: f64 = 0.9;
/// Margin with which a proved cell is good enough for the next one, 1/s.
const RESERVE_PER_S: f64 = 0.4;
/// How far an entry of the Lyapunov matrix may move in a round, tried in turn: the rate of speed has
/// to bear it.
const REACHES: [f64; 3] = [0.1, 0.03, 0.3];
/// Margin from which on it is worth to begin anew where no climb from the node above succeeds, 1/s.
const CLOSE_PER_S: f64 = -1.0;

/// A piece, and which of its cells are proved.
pub struct Marched {
    /// The piece.
    pub piece: Piece,
    /// Cells between its nodes.
    pub cells: Vec<bool>,
}

/// Walks through the nodes. Nodes whose tube is that of `before` are taken from there; `go_on` says
/// whether to.
///
/// # Errors
/// If the bicycle has no steady state at a node, or the user stops it.
pub fn march(
    family: &Family,
    plan: &Plan,
    rider: usize,
    factors: &FactorBox,
    schedule: &[Point],
    before: Option<(&[Point], &Piece)>,
    go_on: &(dyn Fn() -> bool + Sync),
) -> Result<Marched, DesignError> {
    let who = &plan.riders[rider].rider;
    let bicycles = Bicycles::new(family, factors)?;
    let wider = Bicycles::new(family, &factors.widened())?;
    let count = schedule.len();
    let mut nodes: Vec<Option<Node>> = vec![None; count];
    let mut cells = vec![false; count.saturating_sub(1)];
    let mut last: Option<Found> = None;
    // Below the first node without a matrix it only gets harder.
    let mut over = false;
    // From the first node that has changed on, all are found anew: each leans on the one above.
    let mut changed = false;
    for k in (0..count).rev() {
        if !go_on() {
            return Err(DesignError::Stopped);
        }
        let point = &schedule[k];
        changed |= before.is_none_or(|(points, _)| points[k] != *point);
        let known = before.filter(|_| !changed).map(|(_, piece)| &piece.nodes[k]);
        let mut found = node(who, [&bicycles, &wider], point, last.as_ref(), known)?;
        if known.is_none() && !over && worst(&found.wider) < 0.0 {
            let (p, close) = match &last {
                Some(upper) => near(who, &bicycles, &found, upper, plan.rate_m_s2)?,
                None => (None, true),
            };
            found.p = match p {
                None if close => lyapunov_matrix(&found.wider),
                p => p,
            };
        }
        over |= found.p.is_none();
        if let (Some(p), Some(upper)) = (&found.p, &last)
            && let Some(above) = &upper.p
        {
            cells[k] = cell(who, &bicycles, [&found.at(p), &upper.at(above)], plan.rate_m_s2)?;
        }
        let alone = loops(who, &bicycles.alone(point.speed_m_s)?, &found.gains);
        nodes[k] = Some(Node {
            gains: found.gains,
            growth_per_s: worst(&found.loops),
            loss_growth_per_s: worst(&alone),
            lyapunov: found.p.as_ref().map_or_else(Vec::new, Node::upper),
        });
        last = Some(found);
    }
    Ok(Marched {
        piece: Piece {
            rider,
            factors: *factors,
            nodes: nodes.into_iter().flatten().collect(),
        },
        cells,
    })
}

/// A Lyapunov matrix near that of the node above: one that proves the cell between them, if the climb
/// comes by one; else the best for the node alone. And where there is none: was one close?
fn near(
    rider: &Rider,
    bicycles: &Bicycles,
    found: &Found,
    upper: &Found,
    rate_m_s2: f64,
) -> Result<(Option<DMatrix<f64>>, bool), DesignError> {
    let Some(above) = &upper.p else {
        return Ok((None, false));
    };
    let second = upper.at(above);
    let mut best: Option<Climbed> = None;
    for reach in REACHES {
        let mut proving: Option<DMatrix<f64>> = None;
        let mut failed = None;
        let climbed = climb_until(&found.wider, above, GOAL_PER_S, reach, &mut |p, margin| {
            if margin <= 0.0 {
                return false;
            }
            match cell(rider, bicycles, [&found.at(p), &second], rate_m_s2) {
                Ok(true) => {
                    proving = Some(p.clone());
                    margin >= RESERVE_PER_S
                }
                // Too far from the node above: further away it is no better.
                Ok(false) => proving.is_some(),
                Err(error) => {
                    failed = Some(error);
                    true
                }
            }
        })?;
        if let Some(error) = failed {
            return Err(error);
        }
        if proving.is_some() {
            return Ok((proving, true));
        }
        if best.as_ref().is_none_or(|b| climbed.margin_per_s > b.margin_per_s) {
            best = Some(climbed);
        }
    }
    let close = best.as_ref().is_some_and(|b| b.margin_per_s > CLOSE_PER_S);
    Ok((best.filter(|b| b.margin_per_s > 0.0).map(|b| b.p), close))
}

struct Found {
    point: Point,
    gains: Gains,
    /// At the corners of the box.
    loops: Vec<Loop>,
    /// At those of the wider one in which a matrix is looked for; empty if it is known.
    wider: Vec<Loop>,
    p: Option<DMatrix<f64>>,
}

impl Found {
    fn at<'a>(&'a self, p: &'a DMatrix<f64>) -> At<'a> {
        At {
            point: &self.point,
            gains: &self.gains,
            loops: &self.loops,
            p,
        }
    }
}

fn node(
    rider: &Rider,
    [bicycles, wider]: [&Bicycles; 2],
    point: &Point,
    last: Option<&Found>,
    known: Option<&Node>,
) -> Result<Found, DesignError> {
    let vehicles = bicycles.at(point.speed_m_s, [point.from_nm, point.to_nm])?;
    if let Some(known) = known {
        return Ok(Found {
            point: *point,
            gains: known.gains,
            loops: loops(rider, &vehicles, &known.gains),
            wider: Vec::new(),
            p: known.matrix(),
        });
    }
    let around = wider.at(point.speed_m_s, [point.from_nm, point.to_nm])?;
    let (found, _) = gains(rider, &around, last.map(|l| &l.gains));
    Ok(Found {
        point: *point,
        gains: found,
        loops: loops(rider, &vehicles, &found),
        wider: loops(rider, &around, &found),
        p: None,
    })
}

/// One Lyapunov matrix for these loops, from nothing.
pub fn lyapunov_matrix(closed: &[Loop]) -> Option<DMatrix<f64>> {
    from_scratch(closed, GOAL_PER_S)
        .ok()
        .filter(|c| c.margin_per_s > 0.0)
        .map(|c| c.p)
}

/// Largest growth rate of these loops, 1/s.
pub fn worst(loops: &[Loop]) -> f64 {
    loops.iter().map(growth_per_s).fold(f64::NEG_INFINITY, f64::max)
}
