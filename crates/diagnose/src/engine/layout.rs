//! Which states the predictor of a ride has, in which order, and how uncertain they are at first.

use super::ride::Ride;
use super::setup::{Latent, MOST_LATENT, Model};
use crate::quantity::Quantity;

/// Place of the heading, where there is one.
pub const HEADING: usize = 4;

/// Which state is what.
#[derive(Clone, Debug)]
pub struct Layout {
    pub heading: bool,
    /// Slow random forces, each with its state.
    pub latent: [Option<(usize, Latent)>; MOST_LATENT],
    /// First filter state of each sensor.
    pub filters: Vec<Option<usize>>,
    pub dynamic: usize,
    pub sensor_bias: Vec<Option<usize>>,
    pub drive_bias: Vec<Option<usize>>,
    pub states: usize,
}

impl Layout {
    /// The states that this ride needs.
    pub fn new(ride: &Ride, model: &Model) -> Self {
        let heading = ride.sensors.iter().any(|s| s.quantity == Quantity::Yaw);
        let mut next = 4 + usize::from(heading);
        let latent = model.latents(ride).map(|latent| {
            latent.map(|latent| {
                next += 1;
                (next - 1, latent)
            })
        });
        let filters = ride
            .sensors
            .iter()
            .map(|s| {
                let count = usize::from(s.lag_s > 0.0) + 2 * usize::from(s.moving_average_s > 0.0);
                let first = (count > 0 && !s.is_longitudinal()).then_some(next);
                if first.is_some() {
                    next += count;
                }
                first
            })
            .collect();
        let dynamic = next;
        let mut take = |sd: f64| {
            (sd > 0.0).then(|| {
                next += 1;
                next - 1
            })
        };
        let sensor_bias = ride
            .sensors
            .iter()
            .map(|s| take(if s.is_longitudinal() { 0.0 } else { s.bias_sd }))
            .collect();
        let drive_bias = ride.drives.iter().map(|d| take(d.bias_sd)).collect();
        Self {
            heading,
            latent,
            filters,
            dynamic,
            sensor_bias,
            drive_bias,
            states: next,
        }
    }

    /// Variances before the first reading; those of the angles and rates are wide guesses.
    pub fn prior(&self, ride: &Ride) -> Vec<f64> {
        let mut variance = vec![25.0; self.states];
        variance[..4].copy_from_slice(&[0.25, 0.25, 9.0, 9.0]);
        if self.heading {
            variance[HEADING] = 100.0;
        }
        for (index, latent) in self.latent.iter().flatten() {
            variance[*index] = latent.sd * latent.sd;
        }
        let sensors = self
            .sensor_bias
            .iter()
            .zip(ride.sensors.iter().map(|s| s.bias_sd));
        let drives = self
            .drive_bias
            .iter()
            .zip(ride.drives.iter().map(|d| d.bias_sd));
        for (index, sd) in sensors.chain(drives) {
            if let Some(index) = index {
                variance[*index] = sd * sd;
            }
        }
        variance
    }
}

/// The state of the latent torque on roll (0) or steer (1), if the model has it.
pub fn latent_state(ride: &Ride, model: &Model, axis: usize) -> Option<usize> {
    Layout::new(ride, model).latent[axis].map(|(state, _)| state)
}
