//! Heat of the winding.
//!
//! What: one lump of copper and stator iron. Equation: C dϑ/dt = P - (ϑ - ϑ_a)/R_th, stepped
//! implicitly (stable at any step). Source: first-order thermal model, any textbook. Assumes and
//! ignores: one temperature for copper and stator; cooling by the wind of riding is in R_th and
//! does not change with speed. Valid for: tens of seconds and longer; hot spots of short bursts
//! are underestimated. Checked by: the test below (steady state and time constant).

use serde::{Deserialize, Serialize};

use crate::admissible::{OutOfRange, within};

/// Thermal parameters of a motor.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Thermal {
    /// Heat capacity of winding and stator, J/K.
    pub heat_capacity_j_per_k: f64,
    /// Thermal resistance to the air, K/W.
    pub resistance_k_per_w: f64,
    /// Temperature of the air, °C; the winding starts at it.
    pub ambient_celsius: f64,
}

impl Thermal {
    /// Checks every parameter.
    pub fn validate(&self) -> Result<(), OutOfRange> {
        within(
            "heat_capacity_j_per_k",
            self.heat_capacity_j_per_k,
            1.0,
            1e6,
        )?;
        within("resistance_k_per_w", self.resistance_k_per_w, 1e-3, 1e3)?;
        within("ambient_celsius", self.ambient_celsius, -40.0, 60.0)
    }

    /// The temperature after `step_s` seconds of `heat_w`.
    pub fn step(&self, celsius: f64, heat_w: f64, step_s: f64) -> f64 {
        let gain = step_s / self.heat_capacity_j_per_k;
        let leak = gain / self.resistance_k_per_w;
        (celsius + gain * heat_w + leak * self.ambient_celsius) / (1.0 + leak)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_constant_loss_reaches_its_temperature_with_its_time_constant() {
        let t = Thermal {
            heat_capacity_j_per_k: 10.0,
            resistance_k_per_w: 0.5,
            ambient_celsius: 20.0,
        };
        let mut celsius = 20.0;
        for _ in 0..5_000 {
            celsius = t.step(celsius, 100.0, 1e-3);
        }
        assert!(
            (celsius - (20.0 + 50.0 * (1.0 - libm::exp(-1.0)))).abs() < 0.01,
            "{celsius}"
        );
        for _ in 0..100_000 {
            celsius = t.step(celsius, 100.0, 1e-3);
        }
        assert!((celsius - 70.0).abs() < 1e-6);
    }
}
