//! What: a rider who asks for an angle of the handlebar, the trunk or the knees, and holds it.
//!
//! Equation: the angle asked for is q_d(t) = lag[ -(k_p φ + k_d φ' + k_h ψ)(t - τ) + n(t) ],
//! limited; the torque on the joint is T = K (q_d - q) - C q', limited. K and C belong to the limb
//! and act at once. For the handlebar q is the steer angle, for the trunk its lean relative to the
//! pelvis, for the knees half of the right leg's outward angle less the left one's. All are positive
//! to the right, so k > 0 moves against the lean and k < 0 into it.
//!
//! Source: Bulsink (2017), section 6.2.1 and tables 6.3 and 6.4 (angles from roll, PD with delay);
//! holding an angle through the stiffness of the limb is ours, since the thesis prints no torque.
//!
//! Assumes and ignores: stiffness and damping of the limb do not change with force; heading is
//! perceived like roll.
//!
//! Valid for: small roll; the limits make it finite everywhere.
//!
//! Checked by: `rider/tests` (signs, delay, mirror, growth against the closed loop's eigenvalues).

use super::gains::{AngleGains, check_table, gains_at};
use super::muscle::{Muscle, MuscleParameters};
use super::{
    Action, ChannelKind, ChannelModel, Limb, LinearChannel, Perception, RiderError, Signals,
    in_range,
};
use crate::explain::Explain;
use serde::{Deserialize, Serialize};

/// Numbers of a channel that asks for an angle.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AngleParameters {
    /// Delay τ from perception to action, s; 0 to 1.
    pub delay_s: f64,
    /// Natural frequency of the muscles, rad/s.
    pub neuromuscular_rad_s: f64,
    /// Damping ratio of the muscles.
    pub neuromuscular_damping_ratio: f64,
    /// Standard deviation of the remnant, rad.
    pub remnant_sd_rad: f64,
    /// Bandwidth of the remnant, rad/s.
    pub remnant_bandwidth_rad_s: f64,
    /// Stiffness K with which the limb holds the angle, Nm/rad.
    pub stiffness_nm_rad: f64,
    /// Damping C of the limb, Nm s/rad.
    pub damping_nm_s_rad: f64,
    /// The largest angle that is asked for, rad.
    pub angle_limit_rad: f64,
    /// The largest torque that the limb gives, Nm.
    pub torque_limit_nm: f64,
    /// Gains by speed, rising.
    pub gains: Vec<AngleGains>,
}

impl AngleParameters {
    fn muscle(&self) -> MuscleParameters {
        MuscleParameters {
            delay_s: self.delay_s,
            neuromuscular_rad_s: self.neuromuscular_rad_s,
            neuromuscular_damping_ratio: self.neuromuscular_damping_ratio,
            remnant_sd: self.remnant_sd_rad,
            remnant_bandwidth_rad_s: self.remnant_bandwidth_rad_s,
            limit: self.angle_limit_rad,
        }
    }

    fn check(&self) -> Result<(), RiderError> {
        self.muscle()
            .validate(["remnant_sd_rad", "angle_limit_rad"])?;
        in_range(
            "remnant_sd_rad",
            self.remnant_sd_rad,
            0.0,
            1.0,
            "0 to 1 rad",
        )?;
        in_range(
            "angle_limit_rad",
            self.angle_limit_rad,
            0.0,
            1.5,
            "0 to 1.5 rad",
        )?;
        in_range(
            "stiffness_nm_rad",
            self.stiffness_nm_rad,
            0.0,
            5e3,
            "0 to 5000 Nm/rad",
        )?;
        in_range(
            "damping_nm_s_rad",
            self.damping_nm_s_rad,
            0.0,
            500.0,
            "0 to 500 Nm s/rad",
        )?;
        in_range(
            "torque_limit_nm",
            self.torque_limit_nm,
            0.0,
            500.0,
            "0 to 500 Nm",
        )?;
        check_table(&self.gains)
    }
}

/// A limb that holds an angle.
#[derive(Clone, Debug)]
pub struct Angle {
    limb: Limb,
    gains: Vec<AngleGains>,
    muscle: Muscle,
    stiffness_nm_rad: f64,
    damping_nm_s_rad: f64,
    torque_limit_nm: f64,
}

impl Angle {
    fn new(p: &AngleParameters, limb: Limb, stream: &str, seed: u64, step_s: f64) -> Self {
        Self {
            limb,
            gains: p.gains.clone(),
            muscle: Muscle::new(&p.muscle(), seed, stream, step_s),
            stiffness_nm_rad: p.stiffness_nm_rad,
            damping_nm_s_rad: p.damping_nm_s_rad,
            torque_limit_nm: p.torque_limit_nm,
        }
    }
}

impl ChannelModel for Angle {
    fn act(&mut self, now: &Perception, step_s: f64) -> Action {
        let k = gains_at(&self.gains, now.speed_m_s);
        let perceived = self.muscle.perceive(now);
        let wanted = -k.roll_ratio * perceived.roll
            - k.roll_rate_s * perceived.roll_rate
            - k.heading_ratio * perceived.heading;
        let wanted = self.muscle.pull(wanted, step_s);
        let (angle, rate) = self.limb.angle_and_rate(now);
        let torque = self.stiffness_nm_rad * (wanted - angle) - self.damping_nm_s_rad * rate;
        let limit = self.torque_limit_nm;
        self.limb.action(torque.clamp(-limit, limit))
    }
}

/// Declares a channel of the registry that holds the angle of one limb.
macro_rules! angle_channel {
    ($(#[$meta:meta])* $parameters:ident, $limb:expr, $name:literal, $stream:literal, $what:literal, $assumes:literal) => {
        $(#[$meta])*
        #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
        #[serde(transparent)]
        pub struct $parameters(
            /// Its numbers.
            pub AngleParameters,
        );

        impl ChannelKind for $parameters {
            type Started = Angle;

            fn explain() -> Explain {
                Explain {
                    name: $name,
                    what: $what,
                    equation: "q_d = lag[-(k_p φ + k_d φ' + k_h ψ)(t - τ) + n]; T = K (q_d - q) - C q', limited",
                    source: "Bulsink (2017), section 6.2.1, tables 6.3 and 6.4; the limb's stiffness is ours",
                    assumes: $assumes,
                }
            }

            fn validate(&self) -> Result<(), RiderError> {
                self.0.check()
            }

            fn start(&self, seed: u64, step_s: f64) -> Angle {
                Angle::new(&self.0, $limb, $stream, seed, step_s)
            }

            fn linear(&self, speed_m_s: f64) -> LinearChannel {
                let (p, k) = (&self.0, gains_at(&self.0.gains, speed_m_s));
                LinearChannel {
                    limb: $limb,
                    lag: Some((p.neuromuscular_rad_s, p.neuromuscular_damping_ratio)),
                    delay_s: p.delay_s,
                    delayed: Signals {
                        roll: p.stiffness_nm_rad * k.roll_ratio,
                        roll_rate: p.stiffness_nm_rad * k.roll_rate_s,
                        heading: p.stiffness_nm_rad * k.heading_ratio,
                        ..Signals::default()
                    },
                    stiffness_nm_rad: p.stiffness_nm_rad,
                    damping_nm_s_rad: p.damping_nm_s_rad,
                }
            }
        }
    };
}

angle_channel!(
    /// A rider who holds the handlebar at an angle.
    SteerAngleParameters,
    Limb::Bar,
    "steer_angle",
    "rider.steer_angle.remnant",
    "a rider who asks for a steer angle and holds the handlebar there with stiff arms",
    "arms of constant stiffness and damping between frame and handlebar"
);
angle_channel!(
    /// A rider who leans the trunk.
    TrunkLeanParameters,
    Limb::Trunk,
    "trunk_lean",
    "rider.trunk_lean.remnant",
    "a rider who leans the trunk; frame and pelvis feel the reaction",
    "stiffness on top of the passive one of the plant's waist, which pulls towards upright"
);
angle_channel!(
    /// A rider who moves both knees to one side.
    KneesParameters,
    Limb::Knees,
    "knees",
    "rider.knees.remnant",
    "a rider who moves both knees to one side: one outward, the other inward",
    "both legs alike; stiffness on top of the passive one of the plant's legs"
);
