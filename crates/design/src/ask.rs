//! What: from what a user asks for to a plan.
//!
//! Source: own; riders are those of `twinhub_plant::rider::presets` who give torque.
//!
//! Assumes and ignores: sizes of boxes that can be proved as a rule.
//!
//! Valid for: what `Plan::check` accepts.
//!
//! Checked by: `tests` here, and the plan's own rules.

use crate::DesignError;
use crate::certificate::{Entry, Plan};
use crate::family::FactorBox;
use crate::loops::Rider;
use crate::program::Cones;
use serde::Deserialize;
use twinhub_plant::rider::design::Hands;
use twinhub_plant::rider::presets::{BICYCLE, PRESETS, preset};

/// Widest box of mass and of tyre load that is tried for a quick rider.
const BOX_WIDTH: f64 = 0.1;
/// Largest ratio of twisting torque in a box that is tried for a quick rider.
const BOX_RATIO: f64 = 1.26;
/// Riders with a longer delay get boxes half as large, s.
const QUICK_DELAY_S: f64 = 0.15;

/// What is asked for, in the units of the command line; what is left out has the command's defaults.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Ask {
    /// A multibody bicycle that ships, or its file.
    pub bicycle: String,
    /// Riders who give torque: young, older; or NAME:DELAY_S.
    pub riders: Vec<String>,
    /// Share by which the rider's mass may differ.
    pub mass: f64,
    /// Share by which side forces and moments of the tyres may differ.
    pub load: f64,
    /// Factors between which the twisting torque of the tyres may lie.
    pub twisting: [f64; 2],
    /// Boxes along mass, load and twisting torque; none: as many as usually can be proved.
    pub boxes: Option<[usize; 3]>,
    /// Nodes, m/s, rising.
    pub speeds_m_s: Vec<f64>,
    /// Largest pair, Nm.
    pub torque_nm: f64,
    /// Half the width of the tube, Nm.
    pub half_width_nm: f64,
    /// Fastest change of speed, m/s².
    pub rate_m_s2: f64,
    /// Steepest schedule, Nm per m/s.
    pub slope_nm_per_m_s: f64,
    /// Largest growth rate after the pair is lost at once, 1/s.
    pub loss_growth_per_s: f64,
    /// Least friction of the road that has to carry the pair.
    pub friction: f64,
    /// The joints of the rider move.
    pub free_joints: bool,
    /// What matrices are held positive by.
    pub cones: Cones,
}

impl Default for Ask {
    fn default() -> Self {
        Self {
            bicycle: BICYCLE.to_owned(),
            riders: vec!["young".to_owned()],
            mass: 0.1,
            load: 0.1,
            twisting: [0.5, 2.0],
            boxes: None,
            speeds_m_s: (0..=18).map(|k| 3.0 + 0.25 * f64::from(k)).collect(),
            torque_nm: 40.0,
            half_width_nm: 5.0,
            rate_m_s2: 0.3,
            slope_nm_per_m_s: 30.0,
            loss_growth_per_s: 0.7,
            friction: 0.6,
            free_joints: false,
            cones: Cones::default(),
        }
    }
}

impl Ask {
    /// The plan, checked.
    ///
    /// # Errors
    /// What is wrong, what was found and what would be accepted.
    pub fn plan(&self) -> Result<Plan, DesignError> {
        let around = |what: &str, share: f64| {
            if (0.0..=0.9).contains(&share) {
                Ok([1.0 - share, 1.0 + share])
            } else {
                Err(DesignError::Plan(format!(
                    "{what} {share}: accepted: 0 to 0.9"
                )))
            }
        };
        let uncertainty = FactorBox {
            mass: around("mass", self.mass)?,
            load: around("load", self.load)?,
            twisting: self.twisting,
        };
        let riders: Result<Vec<Entry>, DesignError> = self
            .riders
            .iter()
            .map(|text| {
                let rider = rider(text)?;
                let parts = self.boxes.unwrap_or_else(|| usual(&uncertainty, &rider));
                Ok(Entry { rider, parts })
            })
            .collect();
        let plan = Plan {
            bicycle: self.bicycle.clone(),
            joints_free: self.free_joints,
            riders: riders?,
            uncertainty,
            speeds_m_s: self.speeds_m_s.clone(),
            torque_max_nm: self.torque_nm,
            half_width_nm: self.half_width_nm,
            rate_m_s2: self.rate_m_s2,
            slope_nm_per_m_s: self.slope_nm_per_m_s,
            loss_growth_per_s: self.loss_growth_per_s,
            friction_ratio: self.friction,
            cones: self.cones,
        };
        plan.check()?;
        plan.cones.check()?;
        Ok(plan)
    }
}

/// Boxes of a size that can be proved as a rule.
fn usual(uncertainty: &FactorBox, rider: &Rider) -> [usize; 3] {
    let finer = if rider.delay_s <= QUICK_DELAY_S {
        1.0
    } else {
        2.0
    };
    let even = |[a, b]: [f64; 2]| ((b - a) / BOX_WIDTH * finer - 1e-9).ceil().max(1.0) as usize;
    let [a, b] = uncertainty.twisting;
    let ratio = ((b / a).ln() / BOX_RATIO.ln() * finer - 1e-9)
        .ceil()
        .max(1.0) as usize;
    [even(uncertainty.mass), even(uncertainty.load), ratio]
}

fn rider(text: &str) -> Result<Rider, DesignError> {
    let names = || {
        PRESETS
            .iter()
            .filter(|p| p.arms.is_none())
            .map(|p| p.name)
            .collect::<Vec<_>>()
            .join(", ")
    };
    let of = |name: &str, delay_s: Option<f64>| -> Option<Rider> {
        let preset = preset(name).filter(|p| p.arms.is_none())?;
        let Hands::Torque { channel, .. } = preset.hands() else {
            return None;
        };
        Some(Rider {
            name: text.to_owned(),
            delay_s: delay_s.unwrap_or(channel.delay_s),
            lag_rad_s: channel.neuromuscular_rad_s,
            lag_damping_ratio: channel.neuromuscular_damping_ratio,
        })
    };
    let found = match text.split_once(':') {
        None => of(text, None),
        // Another delay, the muscles of everybody.
        Some((_, delay)) => match delay.parse::<f64>() {
            Ok(delay_s) => of("young", Some(delay_s)),
            Err(_) => None,
        },
    };
    found.ok_or_else(|| {
        DesignError::Plan(format!(
            "rider `{text}`: accepted: {}, or NAME:DELAY_S as somebody:0.15",
            names()
        ))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_defaults_are_a_plan_of_24_boxes() {
        let plan = Ask::default().plan().unwrap();
        assert_eq!(plan.boxes().len(), 24);
        assert_eq!(plan.speeds_m_s.last(), Some(&7.5));
    }

    #[test]
    fn what_cannot_be_asked_for_is_said() {
        let wrong = |ask: Ask| ask.plan().unwrap_err().to_string();
        let heavy = Ask {
            mass: 2.0,
            ..Ask::default()
        };
        assert_eq!(wrong(heavy), "mass 2: accepted: 0 to 0.9");
        let nobody = Ask {
            riders: vec!["nobody".to_owned()],
            ..Ask::default()
        };
        assert!(wrong(nobody).contains("accepted: young"));
    }
}
