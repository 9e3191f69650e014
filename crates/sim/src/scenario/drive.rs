//! What drives the bicycle all the time, beside the inputs.

use super::input::Wrong;
use serde::{Deserialize, Serialize};

/// What drives the bicycle.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Drive {
    /// Nothing: it slows down.
    Coast {},
    /// A constant rear torque, that which holds the speed of the start.
    Steady {},
    /// A force at the rear contact on top of that torque, in proportion to the speed that is
    /// missing.
    HoldSpeed {
        /// Force per missing speed, N s/m.
        gain_n_s_m: f64,
        /// Largest force forward or backward, N.
        limit_n: f64,
    },
}

impl Drive {
    pub(super) fn check(&self) -> Result<(), Wrong> {
        if let Self::HoldSpeed {
            gain_n_s_m,
            limit_n,
        } = *self
        {
            if !(0.0..=1e4).contains(&gain_n_s_m) {
                return Err((
                    "hold_speed.gain_n_s_m".to_owned(),
                    gain_n_s_m,
                    "0 to 10000 N s/m",
                ));
            }
            if !(0.0..=1e3).contains(&limit_n) {
                return Err(("hold_speed.limit_n".to_owned(), limit_n, "0 to 1000 N"));
            }
        }
        Ok(())
    }

    /// Torque on the rear wheel, Nm, where `steady_nm` holds the speed.
    pub(super) fn torque_nm(
        &self,
        steady_nm: f64,
        wanted_m_s: f64,
        speed_m_s: f64,
        radius_m: f64,
    ) -> f64 {
        match *self {
            Self::Coast {} => 0.0,
            Self::Steady {} => steady_nm,
            Self::HoldSpeed {
                gain_n_s_m,
                limit_n,
            } => {
                let force = gain_n_s_m * (wanted_m_s - speed_m_s);
                steady_nm + force.clamp(-limit_n, limit_n) * radius_m
            }
        }
    }
}
