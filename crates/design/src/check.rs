//! What: a certificate checked without a solver: everything is formed again from the bicycle's
//! parameters, and every inequality is held against a bound on its rounding.
//!
//! Equation: as in `inequality`. Beside it: the boxes fill the declared uncertainty, the schedule lies
//! in its tube, its slope is no steeper than declared, it is zero where nothing is proved, and the
//! loss of the pair is no worse than declared.
//!
//! Source: Rump (2006) for the rounding.
//!
//! Assumes and ignores: what the model ignores. Along a cell and inside a box the bicycle is taken for
//! the parabola and the mean of the corners; how far it is from that is measured and reported.

use crate::DesignError;
use crate::certificate::{Certificate, Piece, Point, SCHEMA_VERSION, proved_at};
use crate::family::{Family, Member};
use crate::loops::{Gains, worst_growth_per_s};
use crate::plan::{family, friction_cap_nm};
use crate::proof::{At, Bicycles, Cell};
use nalgebra::DMatrix;
use serde::Serialize;
use twinhub_plant::multibody::Parameters;

/// What a check found.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Checked {
    /// Everything holds.
    pub holds: bool,
    /// What does not.
    pub wrong: Vec<String>,
    /// Stretches of speed that are proved, m/s.
    pub proved_m_s: Vec<[f64; 2]>,
    /// Inequalities that were held against their rounding.
    pub inequalities: usize,
    /// Largest distance of the bicycle's state matrix from the model between corners and nodes, as a
    /// share of the matrix.
    pub interpolation_ratio: f64,
}

/// Checks `certificate` against the bicycle as it is now. `watch` hears of parts done and says whether
/// to go on.
///
/// # Errors
/// If the bicycle has no model, or `watch` stops it.
pub fn check(
    certificate: &Certificate,
    parameters: &Parameters,
    watch: &dyn Fn(usize, usize) -> bool,
) -> Result<Checked, DesignError> {
    let mut wrong = Vec::new();
    let plan = &certificate.plan;
    if certificate.schema_version != SCHEMA_VERSION {
        wrong.push(format!(
            "the file is of version {}; this program reads {SCHEMA_VERSION}",
            certificate.schema_version
        ));
    }
    if let Err(error) = plan.check() {
        wrong.push(error.to_string());
    }
    if let Some(difference) = difference(&certificate.bicycle_toml, &parameters.to_toml()) {
        wrong.push(format!(
            "the bicycle {} is another one now: {difference}",
            plan.bicycle
        ));
    }
    shape(certificate, &mut wrong);
    if !wrong.is_empty() {
        return Ok(refused(wrong));
    }
    let family = family(plan, parameters);
    let mut inequalities = 0;
    for (number, piece) in certificate.pieces.iter().enumerate() {
        if !watch(number, certificate.pieces.len()) {
            return Err(DesignError::Stopped);
        }
        inequalities += check_piece(certificate, &family, piece, &mut wrong)?;
    }
    check_schedule(certificate, parameters, &mut wrong);
    Ok(Checked {
        holds: wrong.is_empty(),
        wrong,
        proved_m_s: stretches(&certificate.schedule, &certificate.cells),
        inequalities,
        interpolation_ratio: interpolation(certificate, &family)?,
    })
}

fn refused(wrong: Vec<String>) -> Checked {
    Checked {
        holds: false,
        wrong,
        proved_m_s: Vec::new(),
        inequalities: 0,
        interpolation_ratio: 0.0,
    }
}

/// The first line in which two bicycles differ.
fn difference(then: &str, now: &str) -> Option<String> {
    if then == now {
        return None;
    }
    let mut section = String::new();
    for (a, b) in then.lines().zip(now.lines()) {
        if a.starts_with('[') && a == b {
            a.clone_into(&mut section);
        }
        if a != b {
            return Some(format!("`{section} {a}` then, `{section} {b}` now"));
        }
    }
    Some("one has more parameters".to_owned())
}

/// Is everything there that the proof needs?
fn shape(certificate: &Certificate, wrong: &mut Vec<String>) {
    let plan = &certificate.plan;
    let count = plan.speeds_m_s.len();
    let speeds: Vec<f64> = certificate.schedule.iter().map(|p| p.speed_m_s).collect();
    if speeds != plan.speeds_m_s || certificate.cells.len() + 1 != count {
        wrong.push("schedule and cells do not fit the speeds of the plan".to_owned());
    }
    let pieces: Vec<_> = certificate
        .pieces
        .iter()
        .map(|p| (p.rider, p.factors))
        .collect();
    let whole = certificate
        .pieces
        .iter()
        .all(|piece| piece.nodes.len() == count);
    if pieces != plan.boxes() || !whole {
        wrong.push("the boxes do not fill the declared uncertainty for every rider".to_owned());
    }
}

/// Every cell of a piece that is said to be proved.
fn check_piece(
    certificate: &Certificate,
    family: &Family,
    piece: &Piece,
    wrong: &mut Vec<String>,
) -> Result<usize, DesignError> {
    let plan = &certificate.plan;
    let rider = &plan.riders[piece.rider].rider;
    let bicycles = Bicycles::new(family, &piece.factors)?;
    let place = |k: usize| {
        let p = &certificate.schedule;
        format!(
            "rider {}, mass {:?}, load {:?}, twisting {:?}, {} to {} m/s",
            rider.name,
            piece.factors.mass,
            piece.factors.load,
            piece.factors.twisting,
            p[k].speed_m_s,
            p[k + 1].speed_m_s
        )
    };
    let mut count = 0;
    for k in 0..certificate.cells.len() {
        if !certificate.cells[k] {
            continue;
        }
        let nodes = [&piece.nodes[k], &piece.nodes[k + 1]];
        let points = [&certificate.schedule[k], &certificate.schedule[k + 1]];
        let mut ends = Vec::new();
        for (node, point) in nodes.iter().zip(points) {
            ends.push(At::new(rider, &bicycles, point, &node.gains)?);
            if point.torque_nm > 0.0 {
                let alone = rider.close_all(&bicycles.alone(point.speed_m_s)?, &node.gains);
                let loss = worst_growth_per_s(&alone);
                if loss > plan.loss_growth_per_s + 1e-6 {
                    wrong.push(format!(
                        "{}: after a loss of the pair growth is {loss:.3} 1/s",
                        place(k)
                    ));
                }
            }
        }
        let ends = [&ends[0], &ends[1]];
        let size = ends[0].loops.first().map_or(0, |l| l.a.nrows());
        let matrices: Vec<DMatrix<f64>> = nodes
            .iter()
            .filter_map(|n| n.matrix())
            .filter(|p| p.nrows() == size)
            .collect();
        let [first, second] = &matrices[..] else {
            wrong.push(format!("{}: a Lyapunov matrix is missing", place(k)));
            continue;
        };
        let cell = Cell::new(rider, &bicycles, ends)?;
        if !cell.is_proved(ends, [first, second], plan.rate_m_s2) {
            wrong.push(format!("{}: the inequality does not hold", place(k)));
        }
        count += 8 * ends[0].loops.len();
    }
    Ok(count)
}

fn check_schedule(certificate: &Certificate, parameters: &Parameters, wrong: &mut Vec<String>) {
    let plan = &certificate.plan;
    let points = &certificate.schedule;
    let cap_nm = friction_cap_nm(plan, parameters).min(plan.torque_max_nm);
    for (k, p) in points.iter().enumerate() {
        let ends = k == 0 || k + 1 == points.len();
        if p.torque_nm > 0.0 && (ends || !proved_at(&certificate.cells, k)) {
            wrong.push(format!(
                "{} Nm at {} m/s, where nothing is proved",
                p.torque_nm, p.speed_m_s
            ));
        }
        if !(p.from_nm >= 0.0 && p.from_nm <= p.torque_nm && p.torque_nm <= p.to_nm) {
            wrong.push(format!(
                "the schedule leaves its tube at {} m/s",
                p.speed_m_s
            ));
        }
        if p.torque_nm > cap_nm + 1e-9 {
            wrong.push(format!(
                "{} Nm at {} m/s; friction and the plan allow {cap_nm:.1}",
                p.torque_nm, p.speed_m_s
            ));
        }
        if let Some(q) = points.get(k + 1) {
            let slope = (q.torque_nm - p.torque_nm).abs() / (q.speed_m_s - p.speed_m_s);
            // Schedules are written in tenths of a newton metre.
            if slope > plan.slope_nm_per_m_s + 0.11 / (q.speed_m_s - p.speed_m_s) {
                wrong.push(format!(
                    "the schedule is too steep above {} m/s",
                    p.speed_m_s
                ));
            }
        }
    }
}

/// Stretches of proved cells.
pub fn stretches(points: &[Point], cells: &[bool]) -> Vec<[f64; 2]> {
    let mut found: Vec<[f64; 2]> = Vec::new();
    for (k, proved) in cells.iter().enumerate() {
        if !proved {
            continue;
        }
        let (from, to) = (points[k].speed_m_s, points[k + 1].speed_m_s);
        match found.last_mut() {
            Some(last) if last[1] == from => last[1] = to,
            _ => found.push([from, to]),
        }
    }
    found
}

/// Stretches of speed in words.
pub fn in_words(stretches_m_s: &[[f64; 2]]) -> String {
    if stretches_m_s.is_empty() {
        return "nowhere".to_owned();
    }
    let parts: Vec<String> = stretches_m_s
        .iter()
        .map(|[a, b]| format!("{a} to {b} m/s"))
        .collect();
    parts.join(", ")
}

/// How far the state matrix is from what lies between corners and nodes, at worst over the first
/// rider's boxes: in the middle of the box, and at a quarter of the cell.
fn interpolation(certificate: &Certificate, family: &Family) -> Result<f64, DesignError> {
    let plan = &certificate.plan;
    let rider = &plan.riders[0].rider;
    let none: Gains = [0.0; 4];
    let mut worst: f64 = 0.0;
    for piece in certificate.pieces.iter().filter(|p| p.rider == 0) {
        let middle = family.member(&piece.factors.middle())?;
        let corners: Result<Vec<Member>, _> = piece
            .factors
            .corners()
            .iter()
            .map(|f| family.member(f))
            .collect();
        let corners = corners?;
        let matrix = |member: &Member, v: f64, t: f64| -> Result<DMatrix<f64>, DesignError> {
            Ok(rider.close(&member.at(v, t)?, &none).a)
        };
        for (pair, proved) in certificate.schedule.windows(2).zip(&certificate.cells) {
            if !proved {
                continue;
            }
            let [p, q] = [pair[0], pair[1]];
            let (v, t) = (p.speed_m_s, p.torque_nm);
            let true_one = matrix(&middle, v, t)?;
            let mut mean = DMatrix::zeros(true_one.nrows(), true_one.ncols());
            for corner in &corners {
                mean += matrix(corner, v, t)? / corners.len() as f64;
            }
            worst = worst.max((&true_one - mean).amax() / true_one.amax());
            let between = |s: f64| {
                matrix(
                    &middle,
                    v + s * (q.speed_m_s - v),
                    t + s * (q.torque_nm - t),
                )
            };
            let (a0, am, a1) = (&true_one, between(0.5)?, between(1.0)?);
            let s = 0.25;
            let parabola = a0 * ((1.0 - s) * (1.0 - 2.0 * s))
                + &am * (4.0 * s * (1.0 - s))
                + &a1 * (s * (2.0 * s - 1.0));
            worst = worst.max((between(s)? - parabola).amax() / true_one.amax());
        }
    }
    Ok(worst)
}
