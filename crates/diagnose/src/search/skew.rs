//! What: channels that are a little apart in time, as the declared jitter of the clock lets them: a nuisance
//! of every test, and part of every uncertainty.
//!
//! Equation: the delay of one channel, the same in all rides, with mean 0 and standard deviation jitter over
//! the root of the number of rides.
//!
//! Source: own.
//!
//! Assumes and ignores: rides that know equally much; for them a delay drawn for each ride has the same
//! variance. Channels of the longitudinal equation are left alone: they are slow.
//!
//! Valid for: delays far shorter than a sampling time.
//!
//! Checked by: the p-values of clean sets in `twinhub blind`.

use super::rides::{Column, Passes, Rides};
use crate::engine::Model;
use crate::engine::small::dot;
use crate::quantity::Quantity;
use twinhub_mechanism::{Card, Equation, Family, InputModel, Mechanism, SensorModel};

/// Delay with which the column is formed, s.
const STEP_S: f64 = 1e-3;

/// One channel that comes late.
#[derive(Debug)]
struct Late(Quantity);

static CARD: Card = Card {
    name: "latent_force",
    family: Family::Sensor,
    equations: &[Equation::Sensor],
    claim: "a channel lies a little beside the others in time",
    equation: "reading of a little earlier",
    source: "own",
    parameters: &[],
    requires: &[],
    confounded_with: &[],
    separated_by: "",
};

static CHANNELS: [Late; 10] = [
    Late(Quantity::Roll),
    Late(Quantity::RollRate),
    Late(Quantity::Steer),
    Late(Quantity::SteerRate),
    Late(Quantity::Yaw),
    Late(Quantity::YawRate),
    Late(Quantity::LateralAccel),
    Late(Quantity::SteerTorque),
    Late(Quantity::RollTorque),
    Late(Quantity::LateralForce),
];

impl Mechanism for Late {
    fn card(&self) -> &'static Card {
        &CARD
    }

    fn input(&self, _p: &[f64], quantity: Quantity, model: &mut InputModel) {
        if quantity == self.0 {
            model.delay_s += STEP_S;
        }
    }

    fn sensor(&self, _p: &[f64], quantity: Quantity, model: &mut SensorModel) {
        if quantity == self.0 {
            model.delay_s += STEP_S;
        }
    }
}

/// What every channel does to the innovations when it comes one standard deviation late; nothing where the
/// clocks declare no jitter.
pub fn columns(rides: &Rides, model: &Model, passes: &Passes) -> Vec<Column> {
    let jitters = rides.0.iter().map(|r| r.ride.clock_jitter_sd_s);
    let sd_s = jitters.fold(0.0, f64::max) / (rides.0.len() as f64).sqrt();
    if sd_s <= 0.0 {
        return vec![];
    }
    let is_there = |late: &&Late| {
        rides.0.iter().any(|r| {
            r.ride.sensors.iter().any(|s| s.quantity == late.0)
                || r.ride.drives.iter().any(|d| d.quantity == late.0)
        })
    };
    CHANNELS
        .iter()
        .filter(is_there)
        .filter_map(|late| {
            let plant = model.with(late, vec![]).plant().ok()?;
            let column = passes.column(rides, model, &plant);
            let column: Column = column.iter().map(|x| x * sd_s / STEP_S).collect();
            (dot(&column, &column) > 0.0).then_some(column)
        })
        .collect()
}
