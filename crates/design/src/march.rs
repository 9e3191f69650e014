//! What: the proof for one rider on one box of bicycles, from the highest speed down.
//!
//! Source: own; gains by `gains`, Lyapunov matrices by `cone`.

use crate::DesignError;
use crate::certificate::{Node, Piece, Plan, Point};
use crate::cone::{Climbed, climb_until};
use crate::family::{FactorBox, Family};
use crate::gains::gains;
use crate::loops::{Loop, worst_growth_per_s};
use crate::program::Cones;
use crate::proof::{At, Bicycles, Cell};
use crate::start::from_scratch;
use crate::symmetric::upper;
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
        let known = before
            .filter(|_| !changed)
            .map(|(_, piece)| &piece.nodes[k]);
        let (at, wider) = match known {
            Some(known) => (At::new(who, &bicycles, point, &known.gains)?, Vec::new()),
            None => {
                let around = wider.at(point.speed_m_s, [point.from_nm, point.to_nm])?;
                let (gains, _) = gains(who, &around, last.as_ref().map(|l| &l.at.gains));
                (
                    At::new(who, &bicycles, point, &gains)?,
                    who.close_all(&around, &gains),
                )
            }
        };
        let above = match &last {
            Some(Found {
                at: upper,
                p: Some(p),
            }) => Some(Above {
                cell: Cell::new(who, &bicycles, [&at, upper])?,
                at: upper,
                p,
                rate_m_s2: plan.rate_m_s2,
            }),
            _ => None,
        };
        let p = match known {
            Some(known) => known.matrix(),
            None if over || worst_growth_per_s(&wider) >= 0.0 => None,
            None => search(plan.cones, &wider, &at, above.as_ref(), last.is_none())?,
        };
        over |= p.is_none();
        if let (Some(p), Some(above)) = (&p, &above) {
            cells[k] = above.proves(&at, p);
        }
        let alone = who.close_all(&bicycles.alone(point.speed_m_s)?, &at.gains);
        nodes[k] = Some(Node {
            gains: at.gains,
            growth_per_s: worst_growth_per_s(&at.loops),
            loss_growth_per_s: worst_growth_per_s(&alone),
            lyapunov: p.as_ref().map_or_else(Vec::new, upper),
        });
        last = Some(Found { at, p });
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

struct Found {
    at: At,
    p: Option<DMatrix<f64>>,
}

/// The node above, with a matrix, and the cell up to it.
struct Above<'a> {
    cell: Cell,
    at: &'a At,
    p: &'a DMatrix<f64>,
    rate_m_s2: f64,
}

impl Above<'_> {
    fn proves(&self, at: &At, p: &DMatrix<f64>) -> bool {
        self.cell
            .is_proved([at, self.at], [p, self.p], self.rate_m_s2)
    }
}

/// A Lyapunov matrix for a node: near that of the node above, else from nothing at the `first` node and
/// where one was close.
fn search(
    cones: Cones,
    wider: &[Loop],
    at: &At,
    above: Option<&Above<'_>>,
    first: bool,
) -> Result<Option<DMatrix<f64>>, DesignError> {
    let (p, close) = match above {
        Some(above) => near(cones, wider, at, above)?,
        None => (None, first),
    };
    Ok(match p {
        None if close => lyapunov_matrix(cones, wider),
        p => p,
    })
}

/// A Lyapunov matrix near that of the node above: one that proves the cell between them, if the climb
/// comes by one; else the best for the node alone. And where there is none: was one close?
fn near(
    cones: Cones,
    wider: &[Loop],
    at: &At,
    above: &Above<'_>,
) -> Result<(Option<DMatrix<f64>>, bool), DesignError> {
    let mut best: Option<Climbed> = None;
    for reach in REACHES {
        let mut proving: Option<DMatrix<f64>> = None;
        let climbed = climb_until(
            cones,
            wider,
            above.p,
            GOAL_PER_S,
            reach,
            &mut |p, margin| {
                if margin <= 0.0 {
                    return false;
                }
                if above.proves(at, p) {
                    proving = Some(p.clone());
                    margin >= RESERVE_PER_S
                } else {
                    // Too far from the node above: further away it is no better.
                    proving.is_some()
                }
            },
        )?;
        if proving.is_some() {
            return Ok((proving, true));
        }
        if best
            .as_ref()
            .is_none_or(|b| climbed.margin_per_s > b.margin_per_s)
        {
            best = Some(climbed);
        }
    }
    let close = best.as_ref().is_some_and(|b| b.margin_per_s > CLOSE_PER_S);
    Ok((best.filter(|b| b.margin_per_s > 0.0).map(|b| b.p), close))
}

/// One Lyapunov matrix for these loops, from nothing.
pub fn lyapunov_matrix(cones: Cones, closed: &[Loop]) -> Option<DMatrix<f64>> {
    from_scratch(cones, closed, GOAL_PER_S)
        .ok()
        .filter(|c| c.margin_per_s > 0.0)
        .map(|c| c.p)
}
