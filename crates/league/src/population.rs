//! Who rides.
//!
//! What: classes of riders with the published delays and spreads, around gains that keep this
//! bicycle up. A person has a delay, and gains that are the best for that delay times factors of
//! their own; people who could not ride this bicycle without a stabilizer are not in the population, as
//! far as there is anybody who can: by roll alone nobody can below some 4 m/s.
//!
//! Source: delays and spreads: Bulsink (2017), tables 6.2 and 6.3, at 4 m/s. That the spread of the
//! gains is that of lognormal factors, and that a person's factors are the same at all speeds, is
//! ours. Delays take three values with the published mean and variance, within 0.05 to 0.35 s.
//!
//! Assumes and ignores: the class `published` rides as printed; it is expected to fall
//! (`twinhub rider check`).

use serde::{Deserialize, Serialize};
use twinhub_plant::noise::{Gaussian, stream};
use twinhub_plant::rider::design::Hands;
use twinhub_plant::rider::presets::{Preset, preset};
use twinhub_plant::rider::published::{Group, Spread, Table, rows};

/// Classes of riders.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Class {
    /// Young riders who give torque by roll and by the steer that they feel.
    Young,
    /// Older riders who do.
    Older,
    /// Young riders who give torque by roll alone: the form that was published.
    YoungRoll,
    /// Older riders who do.
    OlderRoll,
    /// Young riders who hold the bar firmly.
    YoungFirm,
    /// Older riders who hold the bar firmly.
    OlderFirm,
    /// The printed torque riders of table 6.2, who keep no variant of this bicycle up.
    Published,
}

/// Probabilities of a normal distribution in three equally likely values: mean, and as far from it.
const THREE_POINTS: [f64; 3] = [-1.224_744_871_391_589, 0.0, 1.224_744_871_391_589];
/// Delays that occur, s.
const DELAYS_S: [f64; 2] = [0.05, 0.35];
/// Of so many people drawn, the one who can ride best stands for all, if none can ride.
const TRIES: u32 = 300;
/// Slowest decay of somebody who can ride without a stabilizer, 1/s.
pub const RIDES_PER_S: f64 = -0.1;

/// A rider of the population.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Person {
    /// Class.
    pub class: Class,
    /// Which of the class's delays: 0 to 2.
    pub delay: usize,
    /// Factors on the gains of roll, roll rate, and steer with its rate.
    pub factors: [f64; 3],
}

impl Class {
    /// Every class.
    pub const ALL: [Self; 7] = [
        Self::Young,
        Self::Older,
        Self::YoungRoll,
        Self::OlderRoll,
        Self::YoungFirm,
        Self::OlderFirm,
        Self::Published,
    ];

    /// The name.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Young => "young",
            Self::Older => "older",
            Self::YoungRoll => "young_roll",
            Self::OlderRoll => "older_roll",
            Self::YoungFirm => "young_firm",
            Self::OlderFirm => "older_firm",
            Self::Published => "published",
        }
    }

    /// The class with that name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|class| class.name() == name)
    }

    /// True for riders who give torque, with gains for this bicycle.
    pub const fn gives_torque(self) -> bool {
        matches!(
            self,
            Self::Young | Self::Older | Self::YoungRoll | Self::OlderRoll
        )
    }

    /// The designed rider that stands for the class; none for the published one.
    pub fn preset(self) -> Option<Preset> {
        preset(match self {
            Self::YoungRoll => "young",
            Self::OlderRoll => "older",
            other => other.name(),
        })
    }

    /// How riders of the class with this delay take the bar, gains still to be found.
    pub fn hands(self, delay_s: f64) -> Option<Hands> {
        let mut hands = Preset {
            delay_s,
            ..self.preset()?
        }
        .hands();
        if let Hands::Torque { feels_steer, .. } = &mut hands {
            *feels_steer = matches!(self, Self::Young | Self::Older);
        }
        Some(hands)
    }

    /// Published delay, and spreads of the gains on roll and roll rate relative to their means.
    fn published(self) -> (Spread, [f64; 2]) {
        let (table, group) = match self {
            Self::Young | Self::YoungRoll | Self::Published => (Table::SteerTorque, Group::Young),
            Self::Older | Self::OlderRoll => (Table::SteerTorque, Group::Older),
            Self::YoungFirm => (Table::SteerAngle, Group::Young),
            Self::OlderFirm => (Table::SteerAngle, Group::Older),
        };
        let row = rows(table)
            .into_iter()
            .find(|row| row.group == group && row.speed_m_s == 4.0)
            .expect("both tables have both groups at 4 m/s");
        let relative = |s: Spread| s.sd / s.mean.abs();
        (row.delay_s, [relative(row.p), relative(row.d)])
    }

    /// The delays of the class, s.
    pub fn delays_s(self) -> [f64; 3] {
        let (delay, _) = self.published();
        THREE_POINTS.map(|z| (delay.mean + z * delay.sd).clamp(DELAYS_S[0], DELAYS_S[1]))
    }
}

impl Person {
    /// Rider `number` of the class. `growth` says how fast the bicycle falls under a person, 1/s.
    pub fn draw(seed: u64, class: Class, number: u64, growth: impl Fn(&Self) -> f64) -> Self {
        let mut noise = stream(seed, &format!("league.rider.{}.{number}", class.name()));
        let delay = ((noise.uniform() * 3.0) as usize).min(2);
        let mut best: Option<(f64, Self)> = None;
        for _ in 0..TRIES {
            let person = Self {
                class,
                delay,
                factors: class.factors(&mut noise),
            };
            let grows_per_s = growth(&person);
            if grows_per_s <= RIDES_PER_S {
                return person;
            }
            if best.is_none_or(|(least, _)| grows_per_s < least) {
                best = Some((grows_per_s, person));
            }
        }
        best.map_or(
            Self {
                class,
                delay,
                factors: [1.0; 3],
            },
            |(_, person)| person,
        )
    }

    /// `hands` with this person's gains.
    pub fn with_factors(&self, hands: &Hands) -> Hands {
        let [roll, rate, steer] = self.factors;
        let mut hands = hands.clone();
        match &mut hands {
            Hands::Torque { channel, .. } => {
                for row in &mut channel.gains {
                    row.roll_nm_rad *= roll;
                    row.roll_rate_nms_rad *= rate;
                    row.steer_nm_rad *= steer;
                    row.steer_rate_nms_rad *= steer;
                }
            }
            Hands::Angle { channel } => {
                for row in &mut channel.0.gains {
                    row.roll_ratio *= roll;
                    row.roll_rate_s *= rate;
                }
            }
        }
        hands
    }
}

impl Class {
    fn factors(self, noise: &mut Gaussian) -> [f64; 3] {
        let (_, [p, d]) = self.published();
        // Mean 1 and the published relative standard deviation.
        let mut factor = |relative: f64| {
            let variance = libm::log(1.0 + relative * relative);
            libm::exp(libm::sqrt(variance) * noise.normal() - 0.5 * variance)
        };
        [factor(p), factor(d), factor(p)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn classes_have_the_published_delays() {
        let [low, mean, high] = Class::YoungFirm.delays_s();
        assert_eq!(mean, 0.22);
        assert!(
            (high - mean - 1.2247 * 0.02).abs() < 1e-4
                && (mean - low - (high - mean)).abs() < 1e-12
        );
        assert_eq!(
            Class::Older.delays_s()[2],
            0.35,
            "0.21 + 1.22 * 0.13 is cut off"
        );
        for class in Class::ALL {
            assert_eq!(Class::named(class.name()), Some(class));
            assert_eq!(class.preset().is_none(), class == Class::Published);
        }
    }

    #[test]
    fn people_are_their_own_and_the_same_every_time() {
        let calm = |_: &Person| -1.0;
        let first = Person::draw(1, Class::Older, 7, calm);
        assert_eq!(Person::draw(1, Class::Older, 7, calm), first);
        assert_ne!(Person::draw(1, Class::Older, 8, calm), first);
        assert_ne!(Person::draw(2, Class::Older, 7, calm), first);
    }

    #[test]
    fn who_cannot_ride_is_not_in_the_population() {
        // Can ride: nobody who pulls more than half as hard as the best gains.
        let weak = Person::draw(3, Class::Young, 0, |p| p.factors[0] - 0.6);
        assert!(weak.factors[0] <= 0.5);
        // Nobody can: the best of all stands for them.
        let best = Person::draw(3, Class::Young, 0, |p| p.factors[0]);
        assert!(best.factors[0] < 0.4, "the least of 300: {best:?}");
    }
}
