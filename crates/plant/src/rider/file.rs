//! Rider files.

use super::{
    Channel, ChannelKind, KneesParameters, LinearChannel, Pedals, PedalsParameters, Rider,
    RiderError, SteerAngleParameters, SteerTorqueParameters, TrunkLeanParameters,
};
use crate::explain::Explain;
use serde::{Deserialize, Serialize};

/// A rider file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RiderFile {
    /// Version of the format: 1.
    pub schema_version: u32,
    /// One sentence: who this is.
    pub about: String,
    /// Where the numbers come from.
    pub source: String,
    /// The channels that the rider uses.
    pub rider: Channels,
    /// How the rider holds the speed.
    pub pedals: PedalsParameters,
}

/// The channels of a rider, each at most once. One that is absent is not used.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Channels {
    /// Hands off the bar: says that no channel is meant.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub hands_off: Option<HandsOff>,
    /// Torque on the handlebar.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub steer_torque: Option<SteerTorqueParameters>,
    /// Angle of the handlebar.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub steer_angle: Option<SteerAngleParameters>,
    /// Lean of the trunk.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub trunk_lean: Option<TrunkLeanParameters>,
    /// Both knees to one side.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub knees: Option<KneesParameters>,
}

/// Hands off the bar has no numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HandsOff {}

/// What the rider of a plant can move beside the handlebar.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Limbs {
    /// The trunk leans at the waist.
    pub trunk: bool,
    /// The legs turn about the hip-ankle line.
    pub legs: bool,
}

impl Channels {
    /// Names of the channels that are used.
    pub fn names(&self) -> Vec<&'static str> {
        let mut names = Vec::new();
        let mut add = |used: bool, name| names.extend(used.then_some(name));
        add(self.steer_torque.is_some(), "steer_torque");
        add(self.steer_angle.is_some(), "steer_angle");
        add(self.trunk_lean.is_some(), "trunk_lean");
        add(self.knees.is_some(), "knees");
        names
    }

    /// What `twinhub explain` says about a channel.
    pub fn explain(name: &str) -> Option<Explain> {
        Some(match name {
            "steer_torque" => SteerTorqueParameters::explain(),
            "steer_angle" => SteerAngleParameters::explain(),
            "trunk_lean" => TrunkLeanParameters::explain(),
            "knees" => KneesParameters::explain(),
            _ => return None,
        })
    }

    /// Checks every number.
    ///
    /// # Errors
    /// Where a number is out of range, or channels exclude each other.
    pub fn validate(&self) -> Result<(), RiderError> {
        if self.hands_off.is_some()
            && let Some(found) = self.names().first()
        {
            return Err(RiderError::HandsOffAndOn { found });
        }
        if self.steer_torque.is_some() && self.steer_angle.is_some() {
            return Err(RiderError::TwoHands);
        }
        self.steer_torque
            .as_ref()
            .map_or(Ok(()), ChannelKind::validate)?;
        self.steer_angle
            .as_ref()
            .map_or(Ok(()), ChannelKind::validate)?;
        self.trunk_lean
            .as_ref()
            .map_or(Ok(()), ChannelKind::validate)?;
        self.knees.as_ref().map_or(Ok(()), ChannelKind::validate)
    }

    fn start(&self, seed: u64, step_s: f64) -> Vec<Channel> {
        fn started<P: ChannelKind>(
            p: &Option<P>,
            wrap: fn(P::Started) -> Channel,
            (seed, step_s): (u64, f64),
        ) -> Option<Channel> {
            p.as_ref().map(|p| wrap(p.start(seed, step_s)))
        }
        let at = (seed, step_s);
        [
            started(&self.steer_torque, Channel::SteerTorque, at),
            started(&self.steer_angle, Channel::SteerAngle, at),
            started(&self.trunk_lean, Channel::TrunkLean, at),
            started(&self.knees, Channel::Knees, at),
        ]
        .into_iter()
        .flatten()
        .collect()
    }

    /// The channels about zero at one speed.
    pub fn linear(&self, speed_m_s: f64) -> Vec<LinearChannel> {
        fn at<P: ChannelKind>(p: &Option<P>, speed_m_s: f64) -> Option<LinearChannel> {
            p.as_ref().map(|p| p.linear(speed_m_s))
        }
        [
            at(&self.steer_torque, speed_m_s),
            at(&self.steer_angle, speed_m_s),
            at(&self.trunk_lean, speed_m_s),
            at(&self.knees, speed_m_s),
        ]
        .into_iter()
        .flatten()
        .collect()
    }
}

impl RiderFile {
    /// Checks every number.
    ///
    /// # Errors
    /// Where a number is out of range; the message names the key.
    pub fn validate(&self) -> Result<(), RiderError> {
        if self.schema_version != 1 {
            return Err(RiderError::Version {
                found: self.schema_version,
            });
        }
        Pedals::new(&self.pedals)?;
        self.rider.validate()
    }

    /// The rider at the start of a ride; `seed` sets its remnant noise, `step_s` its tick.
    ///
    /// # Errors
    /// Where a number is out of range; the message names the key.
    pub fn start(&self, seed: u64, step_s: f64) -> Result<Rider, RiderError> {
        self.validate()?;
        Ok(Rider {
            channels: self.rider.start(seed, step_s),
            pedals: Pedals::new(&self.pedals)?,
        })
    }

    /// Refuses channels for limbs that the plant's rider does not have.
    ///
    /// # Errors
    /// The first such channel.
    pub fn fits(&self, limbs: Limbs) -> Result<(), RiderError> {
        let wanted = [
            (
                self.rider.trunk_lean.is_some(),
                limbs.trunk,
                "trunk_lean",
                "trunk",
                "trunk_lean",
            ),
            (
                self.rider.knees.is_some(),
                limbs.legs,
                "knees",
                "legs",
                "legs",
            ),
        ];
        match wanted.iter().find(|(used, there, ..)| *used && !there) {
            Some((_, _, channel, limb, joint)) => Err(RiderError::NoSuchLimb {
                channel,
                limb,
                joint,
            }),
            None => Ok(()),
        }
    }
}
