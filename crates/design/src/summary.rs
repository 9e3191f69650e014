//! A design in short, as JSON.

use crate::certificate::{Certificate, Node};
use crate::check;

/// The largest value of all riders and boxes at each node.
pub fn worst(certificate: &Certificate, value: fn(&Node) -> f64) -> Vec<f64> {
    (0..certificate.schedule.len())
        .map(|k| {
            let values = certificate.pieces.iter().map(|p| value(&p.nodes[k]));
            values.fold(f64::NEG_INFINITY, f64::max)
        })
        .collect()
}

/// Schedule, tube, what is proved and what stops it: what `twinhub design --json` prints.
pub fn summary(certificate: &Certificate) -> serde_json::Value {
    let nodes = |value| worst(certificate, value);
    serde_json::json!({
        "bicycle": certificate.plan.bicycle,
        "plan": certificate.plan,
        "schedule": certificate.schedule,
        "cells_proved": certificate.cells,
        "proved_m_s": check::stretches(&certificate.schedule, &certificate.cells),
        "growth_per_s": nodes(|n| n.growth_per_s),
        "loss_growth_per_s": nodes(|n| n.loss_growth_per_s),
        "stops": certificate.stops,
    })
}
