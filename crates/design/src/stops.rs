//! What: which uncertainty stops a certificate.
//!
//! Equation: at the fastest speed of each stretch without proof, for the first rider and box that has
//! none: is there one if mass, load, twisting torque, the width of the tube, the delay's error or the
//! rate of speed were not uncertain, one at a time?
//!
//! Source: own.
//!
//! Assumes and ignores: other boxes of the stretch may be stopped by something else.

use crate::DesignError;
use crate::certificate::{Piece, Plan, Point, Stop};
use crate::family::{FactorBox, Family};
use crate::gains::gains;
use crate::loops::Loop;
use crate::march::{lyapunov_matrix, march};
use crate::proof::Bicycles;

/// Why each stretch of cells is not proved.
///
/// # Errors
/// If the user stops it.
pub fn stops(
    plan: &Plan,
    family: &Family,
    schedule: &[Point],
    cells: &[bool],
    pieces: &[Piece],
    stopped: &dyn Fn() -> bool,
) -> Result<Vec<Stop>, DesignError> {
    let mut found = Vec::new();
    let mut end = cells.len();
    while end > 0 {
        if cells[end - 1] {
            end -= 1;
            continue;
        }
        let start = (0..end).rev().find(|&c| cells[c]).map_or(0, |c| c + 1);
        if stopped() {
            return Err(DesignError::Stopped);
        }
        let cell = end - 1;
        let lacking = pieces
            .iter()
            .find(|p| p.nodes[cell].lyapunov.is_empty() || p.nodes[end].lyapunov.is_empty());
        let (rider, because) = match lacking {
            Some(piece) => {
                let node = if piece.nodes[end].lyapunov.is_empty() {
                    end
                } else {
                    cell
                };
                (piece.rider, at_node(plan, family, piece, &schedule[node])?)
            }
            None => {
                let open = |plan: &Plan, piece: &Piece| -> Result<bool, DesignError> {
                    let points = &schedule[cell..=end];
                    let known = Piece {
                        nodes: piece.nodes[cell..=end].to_vec(),
                        ..piece.clone()
                    };
                    let marched = march(
                        family,
                        plan,
                        piece.rider,
                        &piece.factors,
                        points,
                        Some((points, &known)),
                        &|| true,
                    )?;
                    Ok(!marched.cells[0])
                };
                let mut first = (0, Vec::new());
                for piece in pieces {
                    if open(plan, piece)? {
                        let slow = Plan {
                            rate_m_s2: 0.0,
                            ..plan.clone()
                        };
                        let because = if open(&slow, piece)? {
                            "the distance of the nodes"
                        } else {
                            "the rate of speed"
                        };
                        first = (piece.rider, vec![because.to_owned()]);
                        break;
                    }
                }
                first
            }
        };
        found.push(Stop {
            speeds_m_s: [schedule[start].speed_m_s, schedule[end].speed_m_s],
            rider: plan.riders[rider].rider.name.clone(),
            because,
        });
        end = start;
    }
    found.reverse();
    Ok(found)
}

/// What would have to be certain for a node to have its matrix.
fn at_node(
    plan: &Plan,
    family: &Family,
    piece: &Piece,
    point: &Point,
) -> Result<Vec<String>, DesignError> {
    let rider = &plan.riders[piece.rider].rider;
    let middle = piece.factors.middle();
    let all = piece.factors;
    let edges = [point.from_nm, point.to_nm];
    let cases: [(&str, FactorBox, [f64; 2], bool); 5] = [
        (
            "mass",
            FactorBox {
                mass: [middle.mass; 2],
                ..all
            },
            edges,
            true,
        ),
        (
            "tyre load",
            FactorBox {
                load: [middle.load; 2],
                ..all
            },
            edges,
            true,
        ),
        (
            "twisting torque",
            FactorBox {
                twisting: [middle.twisting; 2],
                ..all
            },
            edges,
            true,
        ),
        ("the width of the tube", all, [point.torque_nm; 2], true),
        ("the delay's error", all, edges, false),
    ];
    let mut because = Vec::new();
    for (name, factors, edges, error) in cases {
        let bicycles = Bicycles::new(family, &factors)?;
        let vehicles = bicycles.at(point.speed_m_s, edges)?;
        let (k, growth) = gains(rider, &vehicles, None);
        if growth >= 0.0 {
            continue;
        }
        let mut closed: Vec<Loop> = rider.close_all(&vehicles, &k);
        if !error {
            for closed in &mut closed {
                closed.c *= 1e-6;
            }
        }
        if lyapunov_matrix(plan.cones, &closed).is_some() {
            because.push(name.to_owned());
        }
    }
    Ok(because)
}
