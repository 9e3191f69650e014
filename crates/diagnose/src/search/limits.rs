//! What the rides could have shown: smallest detectable size of every mechanism.
//!
//! Size at which the expected held-out gain reaches `limit_nats` and the expected score z reaches
//! `limit_z`, with the width that the blocks say. Of a gain it is the deviation from 1.

use super::answer::Answer;
use super::contender::Material;
use super::greedy::Found;
use super::rides::Rides;
use super::score::Score;
use super::thresholds::THRESHOLDS;

/// Time over which rides are used.
pub fn duration_s(rides: &Rides) -> f64 {
    let windows = rides.0.iter().flat_map(|r| &r.ride.windows);
    windows.map(|w| w[1] - w[0]).sum()
}

/// Why a mechanism has no limit.
pub const SAME_AS_TOLERANCE: &str =
    "its effect is the same as that of parameters within tolerance, or none in these rides";

/// Whether a mechanism's size is a time that clocks have to tell.
pub fn is_delay(name: &str) -> bool {
    name.ends_with("_lag") || name.ends_with("_delay")
}

/// Smallest size of a mechanism that would be seen; `ratio` is held-out time over fit time, `clock_s` the
/// shortest delay that the clocks tell.
pub fn limit(score: &Score, ratio: f64, clock_s: f64) -> f64 {
    let information = score.first_information() / score.widening;
    let by_score = THRESHOLDS.limit_z / information.sqrt();
    let by_gain = if ratio > 0.0 {
        (2.0 * THRESHOLDS.limit_nats / (information * ratio)).sqrt()
    } else {
        0.0
    };
    let by_clock = if is_delay(score.mechanism.card().name) {
        clock_s
    } else {
        0.0
    };
    (score.unit.abs() * by_score.max(by_gain)).max(by_clock)
}

/// Fills the detection limits.
pub fn fill(answer: &mut Answer, found: &Found, material: &Material<'_>) {
    let ratio = duration_s(material.held) / duration_s(material.fit).max(1e-9);
    let clock_s = material.clock_s();
    for score in found.first.iter().filter_map(|t| t.score.as_ref()) {
        let card = score.mechanism.card();
        if super::tolerance::is_candidate(score.mechanism) {
            continue;
        }
        answer
            .detection_limits
            .entry(card.name.to_owned())
            .or_default()
            .insert(
                card.parameters[0].name.to_owned(),
                limit(score, ratio, clock_s),
            );
    }
}
