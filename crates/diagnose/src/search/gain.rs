//! How much better the extended model predicts, on held-out rides.

use super::answer::{Answer, ChannelGain};
use super::fitting::Rides;
use crate::compare::{HORIZONS_S, MAIN_HORIZON};
use crate::engine::forecast::{Scores, forecast};
use crate::engine::Model;
use std::collections::BTreeMap;

/// Fills the gain table.
pub fn fill(answer: &mut Answer, held: &Rides, nominal: &Model, calibrated: &Model, extended: &Model) {
    if held.0.is_empty() {
        return;
    }
    let all: Vec<BTreeMap<String, Scores>> = [nominal, calibrated, extended]
        .iter()
        .filter_map(|model| forecast(&held.0, model))
        .collect();
    let [nominal, calibrated, extended] = &all[..] else {
        return;
    };
    for (channel, scores) in extended {
        let (Some(a), Some(b)) = (nominal.get(channel), calibrated.get(channel)) else {
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
}
