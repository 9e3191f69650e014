//! Power of what acts on the model, group by group.

use super::dynamics::Forces;
use super::model::{Input, Multibody};
use super::state::{LEG_RATE, SPIN, STEER_RATE, State, StateAccess, TRUNK_RATE};

/// Power of what acts, W.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct InputPower {
    /// Torques on the wheels: motors and pedals.
    pub wheels_w: f64,
    /// The rider's torques on bar, trunk and legs.
    pub rider_w: f64,
    /// Forces and moments on the frame.
    pub disturbances_w: f64,
}

impl Multibody {
    /// Power of `input` in state `x`. What acts without any input (springs, dampers, air) counts
    /// nowhere.
    pub fn input_power(&self, x: &State, input: &Input) -> InputPower {
        let pose = self.tree.pose(x);
        let power = |part: &Input| power(&self.applied(x, part, &pose), x);
        let still = Input {
            wind_m_s: input.wind_m_s,
            ..Input::default()
        };
        let none = power(&still);
        InputPower {
            wheels_w: power(&Input {
                front_brake_nm: input.front_brake_nm,
                rear_traction_nm: input.rear_traction_nm,
                ..still
            }) - none,
            rider_w: power(&Input {
                steer_torque_nm: input.steer_torque_nm,
                trunk_torque_nm: input.trunk_torque_nm,
                leg_torque_nm: input.leg_torque_nm,
                ..still
            }) - none,
            disturbances_w: power(&Input {
                force_n: input.force_n,
                force_at_m: input.force_at_m,
                moment_nm: input.moment_nm,
                ..still
            }) - none,
        }
    }
}

fn power(f: &Forces<f64>, x: &State) -> f64 {
    let v = x.base_motion();
    let base: f64 = (0..6).map(|k| f.wrench[k] * v[k]).sum();
    let trunk: f64 = (0..3).map(|k| f.trunk[k] * x[TRUNK_RATE + k]).sum();
    let pairs: f64 = (0..2)
        .map(|k| f.legs[k] * x[LEG_RATE + k] + f.spin[k] * x[SPIN + k])
        .sum();
    base + trunk + pairs + f.steer * x[STEER_RATE]
}
