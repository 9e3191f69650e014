//! What: the force that has no name: what the final model lacks, as a slow random torque on roll or on
//! steer, its course over the rides, and what it goes with.
//!
//! Equation: the torque is a state of the predictor; its course is the filtered mean. The curve is the
//! mean torque over bins of the quantity with which it correlates most.
//!
//! Source: latent forces as in `random`; the curve after N. R. Kristensen, H. Madsen and S. B.
//! Jørgensen (2004), Automatica 40.
//!
//! Assumes and ignores: the filtered course lags the true torque by some hundredths of a second;
//! samples of a curve are taken for independent once in a correlation time.
//!
//! Valid for: torques that last longer than 0.1 s.
//!
//! Checked by: `tests` of the search.

use super::answer::{Answer, LatentForce, Verdict};
use super::contender::{Material, held_blocks};
use super::decide::Gain;
use super::fitting::Baseline;
use super::levels::fit_levels;
use super::pictures::{Curve, ForceTrace, LatentPicture};
use super::random;
use super::rides::{Passes, Rides};
use crate::engine::latent_state;
use crate::quantity::Quantity;

/// Length of the stretch that is drawn.
const STRETCH_S: f64 = 10.0;
/// Bins of the curve, and samples that one must hold.
const BINS: usize = 15;
const LEAST_SAMPLES: usize = 30;
/// Weaker correlations are not told.
const LEAST_CORRELATION: f64 = 0.3;

const NAMES: [[&str; 2]; 6] = [
    ["roll", "rad"],
    ["steer", "rad"],
    ["roll rate", "rad/s"],
    ["steer rate", "rad/s"],
    ["speed", "m/s"],
    ["steer torque", "Nm"],
];

/// One moment of a ride: time, torque, and the quantities of `NAMES`.
struct Sample {
    ride: usize,
    t_s: f64,
    torque_nm: f64,
    with: [f64; NAMES.len()],
}

/// Fills the latent force where a name is missing or not confirmed.
pub fn fill(answer: &mut Answer, material: &Material<'_>, baseline: &Baseline) {
    if !matches!(answer.verdict, Verdict::Unknown | Verdict::Partial) {
        return;
    }
    let best = [0, 1]
        .into_iter()
        .filter_map(|axis| Some((axis, random::latent(material.fit, baseline, axis)?)))
        .max_by(|a, b| a.1.1.total_cmp(&b.1.1));
    let Some((axis, (latent, _))) = best else {
        return;
    };
    let mut with = baseline.clone();
    with.model.latent[axis] = Some(latent);
    with.model = fit_levels(material.fit, material.free, &with.model, 1);
    let [before, after] = [baseline, &with].map(|b| held_blocks(material.held, b));
    let gain = Gain::between(before.as_ref(), after.as_ref()).map(|g| g.nats);
    let shown = if material.held.0.is_empty() {
        material.fit
    } else {
        material.held
    };
    let samples = samples(shown, &with, axis).unwrap_or_default();
    let strongest = (0..NAMES.len())
        .map(|k| (k, correlation(&samples, k)))
        .max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))
        .filter(|(_, r)| r.abs() > LEAST_CORRELATION);
    let equation = ["roll", "steer"][axis].to_owned();
    answer.pictures.latent = Some(LatentPicture {
        equation: equation.clone(),
        trace: worst(shown, &samples),
        curve: strongest.map(|(k, _)| curve(&samples, k, latent.time_s)),
    });
    answer.latent_force = Some(LatentForce {
        equation,
        sd_nm: latent.sd,
        time_s: latent.time_s,
        held_out_gain_nats: gain,
        goes_with: strongest.map(|(k, _)| NAMES[k][0].to_owned()),
        correlation: strongest.map(|(_, r)| r),
    });
}

fn samples(rides: &Rides, baseline: &Baseline, axis: usize) -> Option<Vec<Sample>> {
    let passes = Passes::run(rides, &baseline.model, true)?;
    let mut all = vec![];
    for (index, pass) in passes.passes.iter().enumerate() {
        let prepared = &rides.0[index];
        let state = latent_state(&prepared.ride, &baseline.model, axis)?;
        let record = pass.record.as_ref()?;
        let torque = prepared
            .ride
            .drives
            .iter()
            .position(|d| d.quantity == Quantity::SteerTorque);
        let steps = &passes.course(rides, index).steps;
        for (step, (x, pace)) in steps
            .iter()
            .zip(record.x2.chunks_exact(record.n).zip(&record.pace))
        {
            all.push(Sample {
                ride: index,
                t_s: step.t_s,
                torque_nm: x[state],
                with: [
                    x[0],
                    x[1],
                    x[2],
                    x[3],
                    pace.speed_m_s,
                    torque.map_or(0.0, |k| step.to.drive[k]),
                ],
            });
        }
    }
    Some(all)
}

fn mean(values: impl Iterator<Item = f64> + Clone) -> f64 {
    let count = values.clone().count().max(1) as f64;
    values.sum::<f64>() / count
}

fn correlation(samples: &[Sample], k: usize) -> f64 {
    let (torque, other) = (
        mean(samples.iter().map(|s| s.torque_nm)),
        mean(samples.iter().map(|s| s.with[k])),
    );
    let mut sums = [0.0; 3];
    for s in samples {
        let (a, b) = (s.torque_nm - torque, s.with[k] - other);
        sums[0] += a * b;
        sums[1] += a * a;
        sums[2] += b * b;
    }
    let scale = (sums[1] * sums[2]).sqrt();
    if scale > 0.0 { sums[0] / scale } else { 0.0 }
}

/// Mean torque by bins of a quantity, with the 95 % interval of each mean.
fn curve(samples: &[Sample], k: usize, time_s: f64) -> Curve {
    let mut values: Vec<f64> = samples.iter().map(|s| s.with[k]).collect();
    values.sort_by(f64::total_cmp);
    let at = |share: f64| values[((values.len() - 1) as f64 * share) as usize];
    let (low, high) = (at(0.01), at(0.99));
    let width = (high - low) / BINS as f64;
    let step_s = samples
        .windows(2)
        .map(|w| w[1].t_s - w[0].t_s)
        .find(|dt| *dt > 0.0)
        .unwrap_or(0.01);
    let mut found = Curve {
        over: NAMES[k][0].to_owned(),
        unit: NAMES[k][1].to_owned(),
        ..Curve::default()
    };
    for bin in 0..BINS {
        let from = low + width * bin as f64;
        let inside: Vec<f64> = samples
            .iter()
            .filter(|s| s.with[k] >= from && s.with[k] < from + width)
            .map(|s| s.torque_nm)
            .collect();
        if inside.len() < LEAST_SAMPLES {
            continue;
        }
        let middle = mean(inside.iter().copied());
        let variance = mean(inside.iter().map(|x| (x - middle) * (x - middle)));
        let independent = (inside.len() as f64 * step_s / time_s.max(step_s)).max(1.0);
        let half = 1.96 * (variance / independent).sqrt();
        found.x.push(from + 0.5 * width);
        found.torque_nm.push(middle);
        found.low_nm.push(middle - half);
        found.high_nm.push(middle + half);
    }
    found
}

/// The stretch where the torque is largest.
fn worst(rides: &Rides, samples: &[Sample]) -> ForceTrace {
    let key = |s: &Sample| (s.ride, (s.t_s / STRETCH_S).floor() as i64);
    let mut power = std::collections::BTreeMap::new();
    for s in samples {
        *power.entry(key(s)).or_insert(0.0) += s.torque_nm * s.torque_nm;
    }
    let most = power
        .into_iter()
        .max_by(|a: &(_, f64), b| a.1.total_cmp(&b.1));
    let Some((place, _)) = most else {
        return ForceTrace::default();
    };
    let inside = || samples.iter().filter(|s| key(s) == place);
    ForceTrace {
        ride: rides.0[place.0].ride.file.clone(),
        t_s: inside().map(|s| s.t_s).collect(),
        torque_nm: inside().map(|s| s.torque_nm).collect(),
    }
}
