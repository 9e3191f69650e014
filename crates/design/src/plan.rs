//! What: from a plan to a schedule with its certificate.
//!
//! Equation: caps on the pair at every speed from the loss limit (a rider used to the pair loses it at
//! once) and from friction; the largest schedule under them (`schedule`); its tube proved for every
//! rider and box (`march`); where it is not, or where a loss is worse than allowed, the caps fall and
//! it is done again. What is left unproved has no pair.
//!
//! Source: own.
//!
//! Assumes and ignores: caps fall and never rise: a larger schedule may exist.
//!
//! Valid for: plans that pass `Plan::check`.
//!
//! Checked by: `check`, which trusts none of this.

use crate::DesignError;
use crate::certificate::{Certificate, Piece, Plan, Point, SCHEMA_VERSION, proved_at};
use crate::family::{Factors, Family, Vehicle};
use crate::gains::gains;
use crate::loops::{Gains, growth_per_s};
use crate::march::{Marched, march};
use crate::schedule::largest;
use crate::stops::stops;
use rayon::prelude::*;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicUsize, Ordering};
use twinhub_plant::multibody::Parameters;

/// Caps that are tried for the loss limit.
const LEVELS: usize = 8;
/// Share of a pair that is left where it is not proved, in the first passes; then none.
const UNPROVED_SHARE: f64 = 0.6;
const UNPROVED_PASSES: usize = 1;
/// Share of a pair that is left where its loss is worse than allowed, in the first passes; then none.
const LOSS_SHARE: f64 = 0.8;
const LOSS_PASSES: usize = 3;
/// Share of the friction that the pair may take.
const FRICTION_SHARE: f64 = 0.8;
/// A pair smaller than this is not worth having, Nm.
const LEAST_NM: f64 = 2.0;

/// How far a design is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress {
    /// What is being done.
    pub doing: &'static str,
    /// Parts done.
    pub done: usize,
    /// Parts in all.
    pub of: usize,
}

/// The bicycle as the certificate sees it.
pub fn family(plan: &Plan, parameters: &Parameters) -> Family {
    let mut p = parameters.clone();
    if !plan.joints_free {
        let j = &mut p.joints;
        for joint in [
            &mut j.trunk_lean,
            &mut j.trunk_pitch,
            &mut j.trunk_twist,
            &mut j.legs,
        ] {
            joint.free = false;
        }
    }
    Family::new(p)
}

/// Load of the front wheel at rest, N.
pub fn front_load_n(parameters: &Parameters) -> f64 {
    let (mass_kg, [x_m, _]) = parameters.mass_and_centre();
    mass_kg * parameters.gravity_m_s2 * x_m / parameters.geometry.wheelbase_m
}

/// Largest pair that the declared friction carries, Nm.
pub fn friction_cap_nm(plan: &Plan, parameters: &Parameters) -> f64 {
    FRICTION_SHARE
        * plan.friction_ratio
        * plan.uncertainty.load[0]
        * front_load_n(parameters)
        * parameters.front_wheel.radius_m
}

/// Finds a schedule and proves it. `watch` hears how far it is and says whether to go on.
///
/// # Errors
/// If the plan breaks a rule, the bicycle has no model, or `watch` stops it.
pub fn run(
    plan: &Plan,
    parameters: &Parameters,
    watch: &(dyn Fn(Progress) -> bool + Sync),
) -> Result<Certificate, DesignError> {
    plan.check()?;
    plan.cones.check()?;
    let family = family(plan, parameters);
    let speeds = &plan.speeds_m_s;
    let mut caps = loss_caps(plan, &family, watch)?;
    let friction_nm = friction_cap_nm(plan, parameters);
    for cap in &mut caps {
        *cap = cap.min(friction_nm).min(plan.torque_max_nm);
    }
    let boxes = plan.boxes();
    let mut before: Option<(Vec<Point>, Vec<Marched>)> = None;
    let mut pass = 0;
    loop {
        let schedule = tube(plan, &largest(speeds, &caps, plan.slope_nm_per_m_s)?);
        let stopped = || {
            !watch(Progress {
                doing: "proof",
                done: 0,
                of: 0,
            })
        };
        let marched = parallel(boxes.len(), "proof", watch, &|k, go_on| {
            let (rider, factors) = boxes[k];
            let known = before
                .as_ref()
                .map(|(points, pieces)| (points.as_slice(), &pieces[k].piece));
            march(&family, plan, rider, &factors, &schedule, known, go_on)
        })?;
        let cells: Vec<bool> = (0..speeds.len() - 1)
            .map(|c| marched.iter().all(|m| m.cells[c]))
            .collect();
        let mut fell = false;
        for k in 0..speeds.len() {
            let torque_nm = schedule[k].torque_nm;
            if torque_nm <= 0.0 {
                continue;
            }
            let proved = proved_at(&cells, k);
            let loss = marched
                .iter()
                .map(|m| m.piece.nodes[k].loss_growth_per_s)
                .fold(f64::NEG_INFINITY, f64::max);
            let (share, passes) = match (proved, loss > plan.loss_growth_per_s) {
                (false, _) => (UNPROVED_SHARE, UNPROVED_PASSES),
                (true, true) => (LOSS_SHARE, LOSS_PASSES),
                (true, false) => continue,
            };
            let less_nm = share * torque_nm;
            let gentle = pass < passes && less_nm >= LEAST_NM;
            caps[k] = if gentle { less_nm } else { 0.0 };
            fell = true;
        }
        if !fell {
            let pieces: Vec<Piece> = marched.into_iter().map(|m| m.piece).collect();
            let stops = stops(plan, &family, &schedule, &cells, &pieces, &stopped)?;
            return Ok(Certificate {
                schema_version: SCHEMA_VERSION,
                plan: plan.clone(),
                bicycle_toml: parameters.to_toml(),
                schedule,
                cells,
                pieces,
                stops,
            });
        }
        // Caps only fall, in the end to zero: it settles.
        before = Some((schedule, marched));
        pass += 1;
    }
}

/// The tube around a schedule.
fn tube(plan: &Plan, torque_nm: &[f64]) -> Vec<Point> {
    plan.speeds_m_s
        .iter()
        .zip(torque_nm)
        .map(|(&speed_m_s, &torque_nm)| Point {
            speed_m_s,
            torque_nm,
            from_nm: (torque_nm - plan.half_width_nm).max(0.0),
            to_nm: torque_nm + plan.half_width_nm,
        })
        .collect()
}

/// At each speed the largest pair whose loss a rider who is used to it survives as asked, for bicycles
/// with the least, the same and the most twisting torque.
fn loss_caps(
    plan: &Plan,
    family: &Family,
    watch: &(dyn Fn(Progress) -> bool + Sync),
) -> Result<Vec<f64>, DesignError> {
    let [least, most] = plan.uncertainty.twisting;
    let mut twisting = vec![least, 1.0, most];
    twisting.dedup();
    let cases: Vec<(usize, f64)> = (0..plan.riders.len())
        .flat_map(|r| twisting.iter().map(move |t| (r, *t)))
        .collect();
    let found = parallel(cases.len(), "loss", watch, &|k, go_on| {
        let (rider, twisting) = cases[k];
        let who = &plan.riders[rider].rider;
        let member = family.member(&Factors {
            mass: 1.0,
            load: 1.0,
            twisting,
        })?;
        let mut known: [Option<Gains>; LEVELS + 1] = [None; LEVELS + 1];
        let mut caps = vec![0.0; plan.speeds_m_s.len()];
        for (i, &speed_m_s) in plan.speeds_m_s.iter().enumerate().rev() {
            if !go_on() {
                return Err(DesignError::Stopped);
            }
            let alone = member.at(speed_m_s, 0.0)?;
            for level in (1..=LEVELS).rev() {
                let pair_nm = plan.torque_max_nm * level as f64 / LEVELS as f64;
                let vehicle: [Vehicle; 1] = [member.at(speed_m_s, pair_nm)?];
                let (k, growth) = gains(who, &vehicle, known[level].as_ref());
                known[level] = Some(k);
                let loss = growth_per_s(&who.close(&alone, &k));
                if growth < 0.0 && loss <= plan.loss_growth_per_s {
                    caps[i] = pair_nm;
                    break;
                }
            }
        }
        Ok(caps)
    })?;
    Ok((0..plan.speeds_m_s.len())
        .map(|i| {
            found
                .iter()
                .map(|caps| caps[i])
                .fold(f64::INFINITY, f64::min)
        })
        .collect())
}

/// Work on all cores, in the order of its numbers; ends at the first error.
fn parallel<T: Send>(
    count: usize,
    doing: &'static str,
    watch: &(dyn Fn(Progress) -> bool + Sync),
    work: &(dyn Fn(usize, &(dyn Fn() -> bool + Sync)) -> Result<T, DesignError> + Sync),
) -> Result<Vec<T>, DesignError> {
    let done = AtomicUsize::new(0);
    // What ends the others comes first.
    let failed: OnceLock<DesignError> = OnceLock::new();
    let go_on = || {
        let done = done.load(Ordering::Relaxed);
        watch(Progress {
            doing,
            done,
            of: count,
        }) && failed.get().is_none()
    };
    let one = |k: usize| {
        if failed.get().is_some() {
            return None;
        }
        let result = work(k, &go_on);
        done.fetch_add(1, Ordering::Relaxed);
        result.map_err(|error| failed.set(error)).ok()
    };
    let found: Vec<Option<T>> = (0..count)
        .into_par_iter()
        .with_max_len(1)
        .map(one)
        .collect();
    match failed.into_inner() {
        Some(error) => Err(error),
        None => Ok(found.into_iter().flatten().collect()),
    }
}
