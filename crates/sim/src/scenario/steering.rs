//! Hands that keep the bicycle in a corner: state feedback on the handlebar's torque.
//!
//! T = T₀ + k_φ (φ - φ₀) + k_φ' φ' + k_δ (δ - δ₀) + k_δ' δ', where φ₀ rises to the roll that is
//! asked for and δ₀, T₀ are those of the steady turn at that roll. The source (section 7.2.2.2)
//! says that a controller kept the roll angle about constant, and not how; this one is ours.

use super::input::Wrong;
use serde::{Deserialize, Serialize};

/// One corner.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HoldRoll {
    /// Hands on, s.
    pub from_s: f64,
    /// Hands off, s.
    pub to_s: f64,
    /// Roll that is held, rad.
    pub roll_rad: f64,
    /// Time over which the roll that is asked for rises to it, s.
    pub rise_s: f64,
    /// Torque per roll, Nm/rad.
    pub roll_gain_nm_rad: f64,
    /// Torque per roll rate, Nm s/rad.
    pub roll_rate_gain_nm_s_rad: f64,
    /// Torque per steer angle, Nm/rad.
    pub steer_gain_nm_rad: f64,
    /// Torque per steer rate, Nm s/rad.
    pub steer_rate_gain_nm_s_rad: f64,
    /// Largest torque, Nm.
    pub limit_nm: f64,
}

/// The steady turn of a corner.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Turn {
    pub steer_rad: f64,
    pub steer_torque_nm: f64,
}

/// What the hands feel.
#[derive(Clone, Copy, Debug)]
pub(super) struct Felt {
    pub roll_rad: f64,
    pub roll_rate_rad_s: f64,
    pub steer_rad: f64,
    pub steer_rate_rad_s: f64,
}

impl HoldRoll {
    pub(super) fn check(&self) -> Result<(), Wrong> {
        let numbers = [
            ("from_s", self.from_s, 0.0, 3600.0, "0 to 3600 s"),
            ("to_s", self.to_s, self.from_s, 3600.0, "from_s to 3600 s"),
            ("roll_rad", self.roll_rad, -0.8, 0.8, "-0.8 to 0.8 rad"),
            ("rise_s", self.rise_s, 0.0, 60.0, "0 to 60 s"),
            ("limit_nm", self.limit_nm, 0.0, 1000.0, "0 to 1000 Nm"),
            (
                "roll_gain_nm_rad",
                self.roll_gain_nm_rad,
                -1e4,
                1e4,
                "-1e4 to 1e4",
            ),
            (
                "roll_rate_gain_nm_s_rad",
                self.roll_rate_gain_nm_s_rad,
                -1e4,
                1e4,
                "-1e4 to 1e4",
            ),
            (
                "steer_gain_nm_rad",
                self.steer_gain_nm_rad,
                -1e4,
                1e4,
                "-1e4 to 1e4",
            ),
            (
                "steer_rate_gain_nm_s_rad",
                self.steer_rate_gain_nm_s_rad,
                -1e4,
                1e4,
                "-1e4 to 1e4",
            ),
        ];
        for (key, value, low, high, accepted) in numbers {
            if !(value >= low && value <= high) {
                return Err((key.to_owned(), value, accepted));
            }
        }
        Ok(())
    }

    /// Torque on the handlebar at `t_s`, Nm.
    pub(super) fn torque_nm(&self, t_s: f64, turn: &Turn, felt: &Felt) -> f64 {
        if t_s < self.from_s - 1e-9 || t_s > self.to_s - 1e-9 {
            return 0.0;
        }
        let share = if self.rise_s > 0.0 {
            ((t_s - self.from_s) / self.rise_s).clamp(0.0, 1.0)
        } else {
            1.0
        };
        let torque = share * turn.steer_torque_nm
            + self.roll_gain_nm_rad * (felt.roll_rad - share * self.roll_rad)
            + self.roll_rate_gain_nm_s_rad * felt.roll_rate_rad_s
            + self.steer_gain_nm_rad * (felt.steer_rad - share * turn.steer_rad)
            + self.steer_rate_gain_nm_s_rad * felt.steer_rate_rad_s;
        torque.clamp(-self.limit_nm, self.limit_nm)
    }
}
