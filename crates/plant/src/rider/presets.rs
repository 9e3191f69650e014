//! The designed riders that ship, as goals of [`super::design`]: what `riders/young.toml` and its
//! neighbours came from.

use super::design::{Designed, Goal, Hands};
use super::{
    AngleGains, AngleParameters, Channels, PedalsParameters, RiderFile, SteerAngleParameters,
    SteerTorqueParameters, TorqueGains,
};

/// A rider that is designed rather than measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Preset {
    /// Name of the rider file that ships.
    pub name: &'static str,
    /// Who this is.
    pub who: &'static str,
    /// Delay, s.
    pub delay_s: f64,
    /// Where the delay comes from.
    pub delay_source: &'static str,
    /// Stiffness and damping of arms that hold an angle, Nm/rad and Nm s/rad; `None`: the rider
    /// gives torque.
    pub arms: Option<(f64, f64)>,
}

/// Stiffness and damping of arms that hold the bar firmly, Nm/rad and Nm s/rad: a guess, some ten
/// times the passive arms of the source.
const FIRM_ARMS: (f64, f64) = (60.0, 4.0);

/// Every designed rider that ships.
pub const PRESETS: [Preset; 4] = [
    Preset {
        name: "young",
        who: "Young rider who gives torque",
        delay_s: 0.12,
        delay_source: "Bulsink (2017), table 6.2, young riders at 3 and 4 m/s",
        arms: None,
    },
    Preset {
        name: "older",
        who: "Older rider who gives torque",
        delay_s: 0.21,
        delay_source: "Bulsink (2017), table 6.2, older riders at 4 m/s",
        arms: None,
    },
    Preset {
        name: "young_firm",
        who: "Young rider who holds the bar firmly",
        delay_s: 0.22,
        delay_source: "Bulsink (2017), table 6.3, young riders at 4 and 7 m/s",
        arms: Some(FIRM_ARMS),
    },
    Preset {
        name: "older_firm",
        who: "Older rider who holds the bar firmly",
        delay_s: 0.27,
        delay_source: "Bulsink (2017), table 6.3, older riders at 4 m/s",
        arms: Some(FIRM_ARMS),
    },
];

/// The designed rider called `name`.
pub fn preset(name: &str) -> Option<Preset> {
    PRESETS.into_iter().find(|p| p.name == name)
}

/// The bicycle for which the shipped ones are designed.
pub const BICYCLE: &str = "bulsink2017_bicycle1_full";

impl Preset {
    /// What the design has to reach: 3 to 8 m/s, without a pair and with 20 and 40 Nm.
    pub fn goal(&self) -> Goal {
        let speeds_m_s: Vec<f64> = (6..=16).map(|half| 0.5 * f64::from(half)).collect();
        Goal::everywhere(self.hands(), &speeds_m_s, &[0.0, 20.0, 40.0])
    }

    /// How the rider takes the bar, gains still to be found.
    pub fn hands(&self) -> Hands {
        let (neuromuscular_rad_s, neuromuscular_damping_ratio) = (30.0, 0.707);
        match self.arms {
            None => Hands::Torque {
                channel: SteerTorqueParameters {
                    delay_s: self.delay_s,
                    neuromuscular_rad_s,
                    neuromuscular_damping_ratio,
                    remnant_sd_nm: 0.15,
                    remnant_bandwidth_rad_s: 6.0,
                    torque_limit_nm: 30.0,
                    gains: vec![TorqueGains::default()],
                },
                feels_steer: true,
            },
            Some((stiffness_nm_rad, damping_nm_s_rad)) => Hands::Angle {
                channel: SteerAngleParameters(AngleParameters {
                    delay_s: self.delay_s,
                    neuromuscular_rad_s,
                    neuromuscular_damping_ratio,
                    remnant_sd_rad: 0.003,
                    remnant_bandwidth_rad_s: 6.0,
                    stiffness_nm_rad,
                    damping_nm_s_rad,
                    angle_limit_rad: 0.6,
                    torque_limit_nm: 40.0,
                    gains: vec![AngleGains::default()],
                }),
            },
        }
    }

    /// The rider file of a design for the bicycle called `bicycle`.
    pub fn file(&self, designed: &Designed, bicycle: &str) -> RiderFile {
        let gains = match &designed.hands {
            Hands::Torque { channel, .. } => speeds(channel.gains.iter().map(|g| g.speed_m_s)),
            Hands::Angle { channel } => speeds(channel.0.gains.iter().map(|g| g.speed_m_s)),
        };
        let pairs = designed.stability.iter().map(|s| s.pair_nm);
        let most = pairs.fold(0.0, f64::max);
        let mut channels = Channels::default();
        match &designed.hands {
            Hands::Torque { channel, .. } => channels.steer_torque = Some(channel.clone()),
            Hands::Angle { channel } => channels.steer_angle = Some(channel.clone()),
        }
        RiderFile {
            schema_version: 1,
            about: format!(
                "{}, {} s of delay, {gains} m/s, the same gains without a pair and with up to {most} Nm",
                self.who, self.delay_s
            ),
            source: format!(
                "Delay: {}. Gains: designed for {bicycle} (largest margin of growth over the pairs). \
                 Muscles: Hess, Moore and Hubbard (2012). Remnant, limits and firmness: guesses.",
                self.delay_source
            ),
            rider: channels,
            pedals: PedalsParameters {
                speed_gain_ns_m: 1000.0,
                force_limit_n: 150.0,
            },
        }
    }
}

/// `3 to 8` of a list of speeds.
fn speeds(list: impl Iterator<Item = f64>) -> String {
    let (low, high) = list.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| {
        (l.min(v), h.max(v))
    });
    format!("{low} to {high}")
}
