//! What: a rider who applies torque to the handlebar.
//!
//! Equation: T(t) = lag[ -k_p φ - k_d φ' - k_h ψ - k_s δ - k_r δ' + n(t) ], everything perceived at
//! t - τ, limited. φ roll, ψ heading, δ steer, n the remnant. `k_p > 0` steers out of the lean,
//! `k_p < 0` into it.
//!
//! Source: proportional-derivative form with delay of Bulsink (2017), section 6.2.1 and table 6.2;
//! the lag of Hess, Moore and Hubbard (2012).
//!
//! Assumes and ignores: perception without error beyond the remnant, one delay for all of it; arms
//! have no stiffness of their own here (the plant has arms).
//!
//! Valid for: small roll; the torque limit makes it finite everywhere.
//!
//! Checked by: `rider/tests` (signs, delay, mirror, growth against the closed loop's eigenvalues).

use super::gains::{TorqueGains, check_table, gains_at};
use super::muscle::{Muscle, MuscleParameters};
use super::{
    Action, ChannelKind, ChannelModel, LinearChannel, Perception, RiderError, Signals, in_range,
};
use crate::explain::Explain;
use serde::{Deserialize, Serialize};

/// Numbers of [`SteerTorque`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SteerTorqueParameters {
    /// Delay τ from perception to action, s; 0 to 1.
    pub delay_s: f64,
    /// Natural frequency of the muscles, rad/s.
    pub neuromuscular_rad_s: f64,
    /// Damping ratio of the muscles.
    pub neuromuscular_damping_ratio: f64,
    /// Standard deviation of the remnant, Nm.
    pub remnant_sd_nm: f64,
    /// Bandwidth of the remnant, rad/s.
    pub remnant_bandwidth_rad_s: f64,
    /// The largest torque that the arms give, Nm.
    pub torque_limit_nm: f64,
    /// Gains by speed, rising.
    pub gains: Vec<TorqueGains>,
}

/// A rider who applies torque to the handlebar.
#[derive(Clone, Debug)]
pub struct SteerTorque {
    gains: Vec<TorqueGains>,
    muscle: Muscle,
}

impl SteerTorque {
    /// The gains at a speed.
    pub fn gains_at(&self, speed_m_s: f64) -> TorqueGains {
        gains_at(&self.gains, speed_m_s)
    }
}

impl SteerTorqueParameters {
    fn muscle(&self) -> MuscleParameters {
        MuscleParameters {
            delay_s: self.delay_s,
            neuromuscular_rad_s: self.neuromuscular_rad_s,
            neuromuscular_damping_ratio: self.neuromuscular_damping_ratio,
            remnant_sd: self.remnant_sd_nm,
            remnant_bandwidth_rad_s: self.remnant_bandwidth_rad_s,
            limit: self.torque_limit_nm,
        }
    }
}

impl ChannelKind for SteerTorqueParameters {
    type Started = SteerTorque;

    fn explain() -> Explain {
        Explain {
            name: "steer_torque",
            what: "a rider who applies torque to the handlebar",
            equation: "T = lag[-k_p φ - k_d φ' - k_h ψ - k_s δ - k_r δ' + n], perceived τ earlier, limited",
            source: "Bulsink (2017), section 6.2.1; lag: Hess, Moore and Hubbard (2012)",
            assumes: "one delay for everything perceived; no error of perception beyond the remnant",
        }
    }

    fn validate(&self) -> Result<(), RiderError> {
        self.muscle()
            .validate(["remnant_sd_nm", "torque_limit_nm"])?;
        in_range("remnant_sd_nm", self.remnant_sd_nm, 0.0, 20.0, "0 to 20 Nm")?;
        in_range(
            "torque_limit_nm",
            self.torque_limit_nm,
            0.0,
            100.0,
            "0 to 100 Nm",
        )?;
        check_table(&self.gains)
    }

    fn start(&self, seed: u64, step_s: f64) -> SteerTorque {
        SteerTorque {
            gains: self.gains.clone(),
            muscle: Muscle::new(&self.muscle(), seed, "rider.remnant", step_s),
        }
    }

    fn linear(&self, speed_m_s: f64) -> LinearChannel {
        let k = gains_at(&self.gains, speed_m_s);
        LinearChannel {
            limb: super::Limb::Bar,
            lag: Some((self.neuromuscular_rad_s, self.neuromuscular_damping_ratio)),
            delay_s: self.delay_s,
            delayed: Signals {
                roll: k.roll_nm_rad,
                roll_rate: k.roll_rate_nms_rad,
                heading: k.heading_nm_rad,
                steer: k.steer_nm_rad,
                steer_rate: k.steer_rate_nms_rad,
            },
            stiffness_nm_rad: 0.0,
            damping_nm_s_rad: 0.0,
        }
    }
}

impl ChannelModel for SteerTorque {
    fn act(&mut self, now: &Perception, step_s: f64) -> Action {
        let k = self.gains_at(now.speed_m_s);
        let perceived = self.muscle.perceive(now);
        let wanted = -k.roll_nm_rad * perceived.roll
            - k.roll_rate_nms_rad * perceived.roll_rate
            - k.heading_nm_rad * perceived.heading
            - k.steer_nm_rad * perceived.steer
            - k.steer_rate_nms_rad * perceived.steer_rate;
        Action {
            steer_torque_nm: self.muscle.pull(wanted, step_s),
            ..Action::default()
        }
    }
}
