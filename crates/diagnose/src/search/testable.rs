//! Which mechanisms a study can look for at all.

use crate::data::RideData;
use crate::engine::Ride;
use crate::quantity::Quantity;
use crate::study::Role;
use twinhub_mechanism::{Card, Requirement};

/// Why a mechanism cannot be looked for in these rides; none if it can.
pub fn obstacle(card: &Card, rides: &[Ride], data: &[RideData]) -> Option<String> {
    card.requires
        .iter()
        .find_map(|requirement| missing(*requirement, rides, data))
}

fn missing(requirement: Requirement, rides: &[Ride], data: &[RideData]) -> Option<String> {
    let channels = || data.iter().flat_map(|d| &d.channels);
    let spread = |values: &mut dyn Iterator<Item = f64>| {
        let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| {
            (a.min(x), b.max(x))
        });
        high - low
    };
    match requirement {
        Requirement::Channel(q) => (!channels()
            .any(|c| c.spec.quantity == q && c.samples.len() > 2))
        .then(|| format!("no {q} in any ride")),
        Requirement::Input(q) => {
            let mut inputs = channels()
                .filter(|c| c.spec.quantity == q && c.spec.role == Role::Input)
                .peekable();
            if inputs.peek().is_none() {
                return Some(format!("no {q} drives the model in any ride"));
            }
            let varies = inputs.any(|c| spread(&mut c.samples.iter().map(|s| s.1)) > 0.0);
            (!varies).then(|| format!("{q} does not vary in any ride"))
        }
        Requirement::Output(q) => {
            let known = rides
                .iter()
                .any(|r| r.sensors.iter().any(|s| s.quantity == q));
            let input = q == Quantity::Speed && rides.iter().any(|r| r.speed.is_some());
            (!known && !input).then(|| format!("{q} is not compared in any ride"))
        }
        Requirement::HandsOn => {
            (!rides.iter().any(|r| r.hands_on)).then(|| "no ride with hands = \"on\"".to_owned())
        }
        Requirement::Rider => rides
            .iter()
            .all(|r| r.rider.is_empty() || r.rider == "none")
            .then(|| "no rider".to_owned()),
        Requirement::Law => rides
            .iter()
            .all(|r| r.laws.is_empty())
            .then(|| "no known feedback law in any ride".to_owned()),
        Requirement::Road => {
            (!rides.iter().any(|r| r.road)).then(|| "no ride with ground = \"road\"".to_owned())
        }
        Requirement::Treadmill => rides
            .iter()
            .all(|r| r.road)
            .then(|| "no ride on a treadmill".to_owned()),
        Requirement::PredictedSpeed => rides
            .iter()
            .all(|r| r.speed.is_some())
            .then(|| "the speed is prescribed in every ride".to_owned()),
        Requirement::SpeedRange(ratio) => {
            let mut values = channels()
                .filter(|c| c.spec.quantity == Quantity::Speed)
                .flat_map(|c| c.samples.iter().map(|s| s.1.abs()))
                .collect::<Vec<_>>();
            values.sort_by(f64::total_cmp);
            let at = |share: f64| {
                let index = (share * values.len() as f64) as usize;
                values
                    .get(index.min(values.len().saturating_sub(1)))
                    .copied()
            };
            let (low, high) = (at(0.05).unwrap_or(0.0), at(0.95).unwrap_or(0.0));
            (high < ratio * low.max(0.1))
                .then(|| format!("speeds from {low:.1} to {high:.1} m/s: too narrow a range"))
        }
    }
}
