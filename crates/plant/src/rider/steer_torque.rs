//! A rider who applies torque to the handlebar.
//!
//! Equation: T(t) = lag[ -k_p φ(t - τ) - k_d φ'(t - τ) - k_h ψ(t - τ) + n(t) ], limited; gains
//! linear in speed between the rows of the table and constant beyond it. φ roll, ψ heading, n the
//! remnant. `k_p > 0` steers out of the lean, `k_p < 0` into it.
//!
//! Source: proportional-derivative form with delay of Bulsink (2017), equation 6.1 and tables 6.2
//! to 6.4; the lag of Hess, Moore and Hubbard (2012).
//!
//! Assumes and ignores: the rider perceives roll, roll rate and heading without error beyond the
//! remnant; arms have no stiffness of their own here (the plant has arms).
//!
//! Valid for: small roll; the torque limit makes it finite everywhere.
//!
//! Checked by: the unit tests below and the closed-loop rides.

use super::{
    Action, DelayLine, NeuromuscularLag, Pedals, Perception, RiderError, RiderModel, in_range,
};
use crate::noise::{ColouredNoise, stream};
use serde::{Deserialize, Serialize};

/// One row of the gain table.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Gains {
    /// Speed of this row, m/s.
    pub speed_m_s: f64,
    /// k_p, Nm/rad: torque out of the lean per roll angle.
    pub roll_nm_rad: f64,
    /// k_d, Nm s/rad: torque out of the lean per roll rate.
    pub roll_rate_nms_rad: f64,
    /// k_h, Nm/rad: torque against the heading error.
    pub heading_nm_rad: f64,
}

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
    pub gains: Vec<Gains>,
}

/// A rider who applies torque to the handlebar.
#[derive(Clone, Debug)]
pub struct SteerTorque {
    gains: Vec<Gains>,
    delay: DelayLine<3>,
    lag: NeuromuscularLag,
    remnant: ColouredNoise,
    torque_limit_nm: f64,
    pedals: Pedals,
}

impl SteerTorque {
    /// # Errors
    /// Where a number is out of range; the message names the key.
    pub fn new(
        p: &SteerTorqueParameters,
        pedals: Pedals,
        seed: u64,
        step_s: f64,
    ) -> Result<Self, RiderError> {
        in_range("delay_s", p.delay_s, 0.0, super::MAX_DELAY_S, "0 to 1 s")?;
        in_range(
            "neuromuscular_rad_s",
            p.neuromuscular_rad_s,
            1.0,
            200.0,
            "1 to 200 rad/s",
        )?;
        in_range(
            "neuromuscular_damping_ratio",
            p.neuromuscular_damping_ratio,
            0.1,
            5.0,
            "0.1 to 5",
        )?;
        in_range("remnant_sd_nm", p.remnant_sd_nm, 0.0, 20.0, "0 to 20 Nm")?;
        in_range(
            "remnant_bandwidth_rad_s",
            p.remnant_bandwidth_rad_s,
            0.1,
            200.0,
            "0.1 to 200 rad/s",
        )?;
        in_range(
            "torque_limit_nm",
            p.torque_limit_nm,
            0.0,
            100.0,
            "0 to 100 Nm",
        )?;
        if p.gains.is_empty() || p.gains.windows(2).any(|w| w[0].speed_m_s >= w[1].speed_m_s) {
            return Err(RiderError::GainTable);
        }
        for row in &p.gains {
            in_range("gains.speed_m_s", row.speed_m_s, 0.0, 30.0, "0 to 30 m/s")?;
            in_range(
                "gains.roll_nm_rad",
                row.roll_nm_rad,
                -1e3,
                1e3,
                "-1000 to 1000 Nm/rad",
            )?;
            in_range(
                "gains.roll_rate_nms_rad",
                row.roll_rate_nms_rad,
                -1e3,
                1e3,
                "-1000 to 1000 Nm s/rad",
            )?;
            in_range(
                "gains.heading_nm_rad",
                row.heading_nm_rad,
                -1e3,
                1e3,
                "-1000 to 1000 Nm/rad",
            )?;
        }
        Ok(Self {
            gains: p.gains.clone(),
            delay: DelayLine::new(p.delay_s, step_s),
            lag: NeuromuscularLag::new(p.neuromuscular_rad_s, p.neuromuscular_damping_ratio),
            remnant: ColouredNoise::new(
                p.remnant_sd_nm,
                p.remnant_bandwidth_rad_s,
                stream(seed, "rider.remnant"),
            ),
            torque_limit_nm: p.torque_limit_nm,
            pedals,
        })
    }

    /// The gains at a speed.
    pub fn gains_at(&self, speed_m_s: f64) -> Gains {
        gains_at(&self.gains, speed_m_s)
    }
}

fn gains_at(table: &[Gains], speed_m_s: f64) -> Gains {
    let above = table.iter().position(|row| row.speed_m_s > speed_m_s);
    match above {
        None => table[table.len() - 1],
        Some(0) => table[0],
        Some(i) => {
            let (a, b) = (table[i - 1], table[i]);
            let s = (speed_m_s - a.speed_m_s) / (b.speed_m_s - a.speed_m_s);
            let mix = |x: f64, y: f64| x + s * (y - x);
            Gains {
                speed_m_s,
                roll_nm_rad: mix(a.roll_nm_rad, b.roll_nm_rad),
                roll_rate_nms_rad: mix(a.roll_rate_nms_rad, b.roll_rate_nms_rad),
                heading_nm_rad: mix(a.heading_nm_rad, b.heading_nm_rad),
            }
        }
    }
}

impl RiderModel for SteerTorque {
    fn act(&mut self, now: &Perception, step_s: f64) -> Action {
        let [roll, roll_rate, yaw] =
            self.delay
                .push([now.roll_rad, now.roll_rate_rad_s, now.yaw_rad]);
        let k = self.gains_at(now.speed_m_s);
        let wanted =
            -k.roll_nm_rad * roll - k.roll_rate_nms_rad * roll_rate - k.heading_nm_rad * yaw
                + self.remnant.step(step_s);
        let limit = self.torque_limit_nm;
        let torque = self.lag.step(wanted.clamp(-limit, limit), step_s);
        Action {
            steer_torque_nm: torque,
            pedal_force_n: self.pedals.force_n(now),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rider::PedalsParameters;

    fn rider(delay_s: f64) -> SteerTorque {
        let p = SteerTorqueParameters {
            delay_s,
            neuromuscular_rad_s: 30.0,
            neuromuscular_damping_ratio: 0.707,
            remnant_sd_nm: 0.0,
            remnant_bandwidth_rad_s: 10.0,
            torque_limit_nm: 20.0,
            gains: vec![
                Gains {
                    speed_m_s: 4.0,
                    roll_nm_rad: 20.0,
                    roll_rate_nms_rad: 2.0,
                    heading_nm_rad: 0.0,
                },
                Gains {
                    speed_m_s: 6.0,
                    roll_nm_rad: 10.0,
                    roll_rate_nms_rad: 0.0,
                    heading_nm_rad: 0.0,
                },
            ],
        };
        let pedals = Pedals::new(&PedalsParameters {
            speed_gain_ns_m: 50.0,
            force_limit_n: 100.0,
        });
        SteerTorque::new(&p, pedals.expect("valid"), 1, 0.001).expect("valid")
    }

    #[test]
    fn gains_follow_speed_and_stay_constant_beyond_the_table() {
        let r = rider(0.1);
        assert_eq!(r.gains_at(5.0).roll_nm_rad, 15.0);
        assert_eq!(r.gains_at(1.0).roll_nm_rad, 20.0);
        assert_eq!(r.gains_at(9.0).roll_nm_rad, 10.0);
    }

    #[test]
    fn leaning_right_a_positive_gain_steers_left_after_the_delay() {
        let mut r = rider(0.2);
        let lean = Perception {
            roll_rad: 0.1,
            speed_m_s: 6.0,
            ..Perception::default()
        };
        let torque: Vec<f64> = (0..600)
            .map(|_| r.act(&lean, 0.001).steer_torque_nm)
            .collect();
        assert!(
            torque[..200].iter().all(|&t| t == 0.0),
            "nothing before the delay"
        );
        assert!(
            (torque[599] + 1.0).abs() < 0.01,
            "-10 Nm/rad times 0.1 rad, got {}",
            torque[599]
        );
    }

    #[test]
    fn unordered_gains_are_refused() {
        let mut p = SteerTorqueParameters {
            delay_s: 0.2,
            neuromuscular_rad_s: 30.0,
            neuromuscular_damping_ratio: 0.7,
            remnant_sd_nm: 0.0,
            remnant_bandwidth_rad_s: 1.0,
            torque_limit_nm: 1.0,
            gains: vec![],
        };
        let pedals = Pedals::new(&PedalsParameters {
            speed_gain_ns_m: 0.0,
            force_limit_n: 0.0,
        })
        .expect("valid");
        assert_eq!(
            SteerTorque::new(&p, pedals, 1, 0.001).err(),
            Some(RiderError::GainTable)
        );
        p.delay_s = f64::NAN;
        let err = SteerTorque::new(&p, pedals, 1, 0.001).expect_err("NaN delay");
        assert!(err.to_string().contains("delay_s"), "{err}");
    }
}
