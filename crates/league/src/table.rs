//! The table: a row for each controller and class of riders.

use crate::interval::{Estimate, mean, quantile, rate, ratio};
use crate::league::Part;
use crate::population::Class;
use crate::spec::Spec;
use serde::Serialize;
use twinhub_sim::Metrics;

/// Riders that a row counts together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Group {
    /// Every rider.
    All,
    /// Those who give torque.
    Torque,
    /// Those who hold the bar firmly.
    Firm,
    /// One class.
    One(Class),
}

impl Group {
    /// The name in tables and JSON.
    pub const fn name(self) -> &'static str {
        match self {
            Self::All => "all",
            Self::Torque => "torque",
            Self::Firm => "firm",
            Self::One(class) => class.name(),
        }
    }

    /// True if riders of `class` belong to it. `all` are those who can ride: not the published ones.
    pub const fn has(self, class: Class) -> bool {
        match self {
            Self::All => !matches!(class, Class::Published),
            Self::Torque => class.gives_torque(),
            Self::Firm => matches!(class, Class::YoungFirm | Class::OlderFirm),
            Self::One(one) => one as u8 == class as u8,
        }
    }

    /// The groups of a league: sums of several classes first.
    pub fn of(spec: &Spec) -> Vec<Self> {
        let sums = [Self::All, Self::Torque, Self::Firm];
        let several = |group: &Self| {
            spec.classes
                .iter()
                .filter(|class| group.has(**class))
                .count()
                > 1
        };
        let classes = spec.classes.iter().map(|class| Self::One(*class));
        sums.into_iter().filter(several).chain(classes).collect()
    }
}

/// What a controller did for a group of riders.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// The controller.
    pub controller: String,
    /// The riders: a class, or `all`, `torque`, `firm`.
    pub class: &'static str,
    /// Rides.
    pub rides: usize,
    /// Rides that stayed up with every controller: those that effort, roll, bar and swing are taken
    /// from, so that all controllers are judged on the same ones.
    pub rides_up: usize,
    /// Distance, km.
    pub distance_km: f64,
    /// Falls.
    pub falls: u64,
    /// Falls per 1,000 km.
    pub falls_per_1000_km: Option<Estimate>,
    /// Rider's torque on the handlebar, mean of the rides' root mean squares, Nm.
    pub rider_effort_rms_nm: Option<Estimate>,
    /// Roll, mean of the rides' root mean squares, rad.
    pub roll_rms_rad: Option<Estimate>,
    /// Largest roll of a ride: what 99 of 100 rides stay below, rad.
    pub roll_worst_1_percent_rad: Option<Estimate>,
    /// Steer rate, mean of the rides' root mean squares, rad/s: how much the bar moves.
    pub steer_rate_rms_rad_s: Option<Estimate>,
    /// How much faster the bicycle swings than with the first controller, Hz.
    pub swing_shift_hz: Option<Estimate>,
    /// Energy out of the battery, net, Wh/km.
    pub energy_wh_per_km: Option<Estimate>,
    /// Ticks in which the front motor braked a standing wheel.
    pub front_locked_ticks: u64,
}

/// The table of what these parts came to.
pub fn table(spec: &Spec, parts: &[Part]) -> Vec<Row> {
    let mut rows = Vec::new();
    for group in Group::of(spec) {
        let of_group: Vec<&Part> = parts.iter().filter(|p| group.has(p.class)).collect();
        for (index, contestant) in spec.controllers.iter().enumerate() {
            rows.push(row(&contestant.name, index, group, &of_group));
        }
    }
    rows
}

fn row(controller: &str, index: usize, group: Group, parts: &[&Part]) -> Row {
    let of = |part: &Part| part.scores[index].metrics.clone();
    let up: Vec<&&Part> = parts
        .iter()
        .filter(|part| part.scores.iter().all(|s| !s.metrics.fell))
        .collect();
    let over_up =
        |what: fn(&Metrics) -> f64| -> Vec<f64> { up.iter().map(|part| what(&of(part))).collect() };
    let falls = parts.iter().filter(|part| of(part).fell).count() as u64;
    let distance_km: f64 = parts.iter().map(|part| of(part).distance_m / 1000.0).sum();
    let energy: Vec<(f64, f64)> = parts
        .iter()
        .map(|part| (of(part).energy_j / 3600.0, of(part).distance_m / 1000.0))
        .collect();
    let shift: Vec<f64> = up
        .iter()
        .map(|part| of(part).swing_hz - part.scores[0].metrics.swing_hz)
        .collect();
    Row {
        controller: controller.to_owned(),
        class: group.name(),
        rides: parts.len(),
        rides_up: up.len(),
        distance_km,
        falls,
        falls_per_1000_km: rate(falls, distance_km / 1000.0),
        rider_effort_rms_nm: mean(&over_up(|m| m.rider_effort_rms_nm)),
        roll_rms_rad: mean(&over_up(|m| m.roll_rms_rad)),
        roll_worst_1_percent_rad: quantile(&over_up(|m| m.roll_max_rad), 0.99),
        steer_rate_rms_rad_s: mean(&over_up(|m| m.steer_rate_rms_rad_s)),
        swing_shift_hz: mean(&shift),
        energy_wh_per_km: ratio(&energy),
        front_locked_ticks: parts.iter().map(|part| of(part).front_locked_ticks).sum(),
    }
}
