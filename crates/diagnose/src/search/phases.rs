//! What: phases that only a ride can tell: how a wheel stood when it was switched on.
//!
//! Equation: the effect is a cos(angle) + b sin(angle) in each ride; (a, b) by least squares on the ride's
//! innovations without the effect; its amplitude is the same in all rides, its phase atan2(b, a) belongs to
//! the ride. Each phase is one more parameter: score tests count two columns a ride.
//!
//! Source: own, elementary; unknown constants of a held-out ride are found from it, as biases are.
//!
//! Assumes and ignores: effects small enough for the innovations to be linear in them; held-out rides pay
//! nothing for their phases, half a nat each.
//!
//! Valid for: rides of several turns.
//!
//! Checked by: `tests`, and the wheels out of balance of the blind suite.

use super::rides::{Column, Passes, Rides};
use crate::engine::small::{dot, solve};
use crate::engine::{Active, Model};
use std::collections::BTreeMap;
use twinhub_linear::Parameters;
use twinhub_mechanism::Mechanism;

/// The columns of each ride for itself, those of the first probe first.
pub fn by_ride(columns: &[Column], ride: &[usize], rides: usize) -> Vec<Column> {
    let only = |column: &Column, k: usize| -> Column {
        let entries = column.iter().zip(ride);
        entries
            .map(|(x, r)| if *r == k { *x } else { 0.0 })
            .collect()
    };
    columns
        .iter()
        .flat_map(|c| (0..rides).map(move |k| only(c, k)))
        .collect()
}

/// The mechanism with the amplitude and the phases that sizes by ride say: those of `by_ride`'s columns.
pub fn active(
    mechanism: &'static dyn Mechanism,
    size: &[f64],
    rides: &Rides,
    bicycle: &Parameters,
) -> Active {
    let count = rides.0.len();
    let mut active = Active::new(mechanism, mechanism.null(bicycle));
    let mut squares = 0.0;
    for (k, prepared) in rides.0.iter().enumerate() {
        let own = mechanism.from_probes(&[size[k], size[count + k]], bicycle);
        squares += own[0] * own[0];
        active.phase_rad.insert(prepared.ride.file.clone(), own[1]);
    }
    active.p[0] = (squares / count as f64).sqrt();
    active
}

/// The model with phases for these rides, where it needs some and has none.
pub fn found(rides: &Rides, model: &Model) -> Option<Model> {
    let mut model = model.clone();
    for index in 0..model.active.len() {
        let active = &model.active[index];
        let is_known = |file: &str| active.phase_rad.contains_key(file);
        if !active.mechanism.has_phase_by_ride() || rides.0.iter().all(|r| is_known(&r.ride.file)) {
            continue;
        }
        let phases = phases(rides, &model, index)?;
        for (file, phase) in phases {
            model.active[index].phase_rad.entry(file).or_insert(phase);
        }
    }
    Some(model)
}

fn phases(rides: &Rides, model: &Model, index: usize) -> Option<BTreeMap<String, f64>> {
    let mechanism = model.active[index].mechanism;
    let bicycle = &model.bicycle.parameters;
    let mut absent = model.clone();
    absent.active[index] = Active::new(mechanism, mechanism.null(bicycle));
    let passes = Passes::run(rides, &absent, true)?;
    let residual = passes.whitened();
    let columns = mechanism
        .probes(bicycle)
        .into_iter()
        .map(|p| {
            let mut there = absent.clone();
            there.active[index].p = p;
            let plant = there.plant().ok()?;
            Some(passes.column(rides, &absent, &plant))
        })
        .collect::<Option<Vec<Column>>>()?;
    let ride: Vec<usize> = passes.stamps(rides).iter().map(|s| s.0).collect();
    let count = rides.0.len();
    let split = by_ride(&columns, &ride, count);
    let mut size = vec![0.0; 2 * count];
    for k in 0..count {
        let (a, b) = (&split[k], &split[count + k]);
        let normal = [dot(a, a), dot(a, b), dot(a, b), dot(b, b)];
        // A ride in which the wheel stands tells nothing: any phase will do.
        if let Some(found) = solve(&normal, &[vec![dot(a, &residual), dot(b, &residual)]]) {
            (size[k], size[count + k]) = (-found[0][0], -found[0][1]);
        }
    }
    Some(active(mechanism, &size, rides, bicycle).phase_rad)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_of_each_ride() {
        let columns = vec![vec![1.0, 2.0, 3.0], vec![4.0, 5.0, 6.0]];
        let split = by_ride(&columns, &[0, 1, 1], 2);
        let expected = [
            [1.0, 0.0, 0.0],
            [0.0, 2.0, 3.0],
            [4.0, 0.0, 0.0],
            [0.0, 5.0, 6.0],
        ];
        assert_eq!(split, expected.map(|c| c.to_vec()));
    }
}
