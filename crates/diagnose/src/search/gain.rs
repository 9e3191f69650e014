//! How much better the extended model predicts, on held-out rides.

use super::answer::{Answer, ChannelGain};
use super::phases;
use super::pictures::Trace;
use super::rides::Rides;
use crate::compare::{HORIZONS_S, MAIN_HORIZON};
use crate::engine::Model;
use crate::engine::forecast::{Forecast, forecast};

/// Length of the stretch that is drawn.
const STRETCH_S: f64 = 10.0;

/// Fills the gain table.
pub fn fill(
    answer: &mut Answer,
    held: &Rides,
    nominal: &Model,
    calibrated: &Model,
    extended: &Model,
) {
    if held.0.is_empty() {
        return;
    }
    let all: Vec<Forecast> = [nominal, calibrated, extended]
        .iter()
        .filter_map(|model| forecast(&held.0, &phases::found(held, model)?))
        .collect();
    let [nominal, calibrated, extended] = &all[..] else {
        return;
    };
    for (channel, scores) in &extended.scores {
        let (Some(a), Some(b)) = (nominal.scores.get(channel), calibrated.scores.get(channel))
        else {
            continue;
        };
        let rmse = HORIZONS_S.iter().enumerate().map(|(k, h)| {
            let three = a.rmse(k).zip(b.rmse(k)).zip(scores.rmse(k));
            (h.to_string(), three.map(|((x, y), z)| [x, y, z]))
        });
        answer.gain.insert(
            channel.clone(),
            ChannelGain {
                nominal_vaf: a.vaf(MAIN_HORIZON),
                calibrated_vaf: b.vaf(MAIN_HORIZON),
                extended_vaf: scores.vaf(MAIN_HORIZON),
                ceiling_vaf: scores.ceiling(),
                rmse_by_horizon_s: rmse.collect(),
            },
        );
    }
    answer.pictures.traces = worst(held, calibrated, extended);
}

/// The stretch where the calibrated model errs most, relative to each channel's spread.
fn worst(held: &Rides, calibrated: &Forecast, extended: &Forecast) -> Vec<Trace> {
    let mut best: Option<(f64, usize, f64)> = None;
    for (index, ride) in held.0.iter().enumerate() {
        for window in &ride.ride.windows {
            let mut from = window[0];
            loop {
                let to = from + STRETCH_S;
                let ratio: f64 = calibrated
                    .traces
                    .iter()
                    .filter(|t| t.ride == index)
                    .map(|t| {
                        let inside = t.points.iter().filter(|p| p[0] >= from && p[0] < to);
                        let errors = inside.map(|p| (p[1] - p[2]) * (p[1] - p[2])).sum::<f64>();
                        let spread: f64 = t.points.iter().map(|p| p[1] * p[1]).sum();
                        if spread > 0.0 { errors / spread } else { 0.0 }
                    })
                    .sum();
                if best.is_none_or(|b| ratio > b.0) {
                    best = Some((ratio, index, from));
                }
                from += 0.5 * STRETCH_S;
                if from + STRETCH_S > window[1] {
                    break;
                }
            }
        }
    }
    let Some((_, ride, from)) = best else {
        return vec![];
    };
    let inside = |p: &&[f64; 3]| p[0] >= from && p[0] < from + STRETCH_S;
    calibrated
        .traces
        .iter()
        .zip(&extended.traces)
        .filter(|(a, _)| a.ride == ride)
        .map(|(a, b)| {
            let of = |t: &crate::engine::forecast::Trace, k: usize| -> Vec<f64> {
                t.points.iter().filter(inside).map(|p| p[k]).collect()
            };
            Trace {
                ride: held.0[ride].ride.file.clone(),
                quantity: a.quantity.clone(),
                t_s: of(a, 0),
                measured: of(a, 1),
                calibrated: of(a, 2),
                extended: of(b, 2),
            }
        })
        .collect()
}
