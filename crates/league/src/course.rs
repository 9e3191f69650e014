//! What is ridden: mixed courses that are mostly quiet.
//!
//! What: straight roads at 3 to 8 m/s with friction from 0.15 to 1.0 and patches of other friction,
//! banks, gusts, kicks, stretches of side force and of the laboratory's multisine.
//!
//! Source: sizes and shares are ours, but the multisine (Bulsink 2017, section 6.2.2) and the drag
//! area of an upright city rider (as in the course `three_to_eight`).

use serde::{Deserialize, Serialize};
use twinhub_plant::disturbance::{Disturbance, Gust, Kick, Place, RigMultisine, SideForce, Timed};
use twinhub_plant::noise::{Gaussian, stream};
use twinhub_plant::road::{Patch, Road};
use twinhub_plant::wind::Wind;
use twinhub_sim::choice::Choice;
use twinhub_sim::course::{Course, SpeedPoint};
use twinhub_sim::plant::{MultibodyChoice, PlantChoice};

/// How slippery a course is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Surface {
    /// Friction 0.8 to 1.0 all along.
    Dry,
    /// Friction 0.45 to 0.7, or dry with wet patches.
    Wet,
    /// Friction 0.15 to 0.35, or patches of it.
    Slippery,
}

impl Surface {
    /// Every surface.
    pub const ALL: [Self; 3] = [Self::Dry, Self::Wet, Self::Slippery];

    /// The name.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Dry => "dry",
            Self::Wet => "wet",
            Self::Slippery => "slippery",
        }
    }

    /// Smallest and largest friction.
    const fn friction(self) -> [f64; 2] {
        match self {
            Self::Dry => [0.8, 1.0],
            Self::Wet => [0.45, 0.7],
            Self::Slippery => [0.15, 0.35],
        }
    }
}

/// A course that was drawn.
#[derive(Clone, Debug, PartialEq)]
pub struct Drawn {
    /// Speed at its beginning and end, m/s.
    pub speeds_m_s: [f64; 2],
    /// The most slippery spot.
    pub surface: Surface,
    /// The course; its rider and law are named for the report alone.
    pub course: Course,
}

/// Uniform between two bounds.
fn between(noise: &mut Gaussian, low: f64, high: f64) -> f64 {
    low + (high - low) * noise.uniform()
}

/// A sign.
fn side(noise: &mut Gaussian) -> f64 {
    if noise.uniform() < 0.5 { -1.0 } else { 1.0 }
}

/// Course number `number` of the league with seed `seed`, for a rider of the class called `class`.
pub fn draw(seed: u64, class: &str, number: u64, duration_s: f64, bicycle: &str) -> Drawn {
    let name = format!("league.course.{class}.{number}");
    let mut noise = stream(seed, &name);
    let from_m_s = between(&mut noise, 3.0, 8.0);
    let to_m_s = (from_m_s + between(&mut noise, -1.5, 1.5)).clamp(3.0, 8.0);
    let surface = match noise.uniform() {
        u if u < 0.5 => Surface::Dry,
        u if u < 0.8 => Surface::Wet,
        _ => Surface::Slippery,
    };
    let length_m = 0.5 * (from_m_s + to_m_s) * duration_s;
    let mut speed = vec![(0.0, from_m_s), (0.2 * duration_s, from_m_s)];
    speed.push((0.8 * duration_s, to_m_s));
    let course = Course {
        schema_version: 1,
        about: format!("course {number} of a league, class {class}"),
        duration_s,
        seed: twinhub_types::wire::hash_u64(
            twinhub_types::wire::hash_str(twinhub_types::wire::HASH_START, &name),
            seed,
        ),
        rider: class.to_owned(),
        law: String::new(),
        motors: Choice::Named("fixed_85_percent".into()),
        sensors: Choice::Named("as_bought".into()),
        speed: speed
            .into_iter()
            .map(|(t_s, speed_m_s)| SpeedPoint { t_s, speed_m_s })
            .collect(),
        plant: PlantChoice::Multibody(MultibodyChoice {
            bicycle: Choice::Named(bicycle.to_owned()),
            set: toml::Table::new(),
            road: road(&mut noise, surface, length_m).into(),
            wind: Wind::default().into(),
            sensor_at_m: None,
        }),
        disturbance: disturbances(&mut noise, duration_s, 0.5 * (from_m_s + to_m_s)),
        link_fault: Vec::new(),
    };
    Drawn {
        speeds_m_s: [from_m_s, to_m_s],
        surface,
        course,
    }
}

fn road(noise: &mut Gaussian, surface: Surface, length_m: f64) -> Road {
    let [low, high] = surface.friction();
    let friction = between(noise, low, high);
    // Half of what is not dry is dry with patches: friction jumps under the wheels.
    let patchy = surface != Surface::Dry && noise.uniform() < 0.5;
    let mut road = Road::level(if patchy {
        between(noise, 0.8, 1.0)
    } else {
        friction
    });
    if patchy {
        for _ in 0..3 {
            let from_m = between(noise, 0.1, 0.9) * length_m;
            let long_m = between(noise, 2.0, 15.0);
            road.patches.push(Patch {
                x_m: [from_m, from_m + long_m],
                y_m: None,
                friction_ratio: friction,
                edge_m: 0.1,
            });
        }
    }
    if noise.uniform() < 0.25 {
        // Up to 5 degrees.
        road.bank_rad = between(noise, -0.0873, 0.0873);
    }
    road
}

fn disturbances(noise: &mut Gaussian, duration_s: f64, speed_m_s: f64) -> Vec<Timed> {
    let mut list = Vec::new();
    let mut at = |start_s: f64, what: Disturbance| list.push(Timed { start_s, what });
    let side_force = |rms_n, duration_s| {
        Disturbance::SideForce(SideForce {
            rms_n,
            low_hz: 0.1,
            high_hz: 2.0,
            lines: 24,
            duration_s,
            fade_s: 1.0,
            place: Place::FrameCentre {},
        })
    };
    let room_s = duration_s - 2.0;
    // Always a little: road and air.
    at(1.0, side_force(between(noise, 1.0, 4.0), room_s));
    // The rest comes and goes, within a fifth of the ride each.
    let fifth_s = 0.2 * room_s;
    let start = |noise: &mut Gaussian| 1.0 + between(noise, 0.1, 0.75) * room_s;
    if noise.uniform() < 0.5 {
        let start_s = start(noise);
        at(
            start_s,
            side_force(between(noise, 6.0, 14.0), fifth_s.max(3.0)),
        );
    }
    if noise.uniform() < 0.4 {
        let impulse_n_s = side(noise) * between(noise, 2.0, 12.0);
        let start_s = start(noise);
        at(
            start_s,
            Disturbance::Kick(Kick {
                impulse_n_s,
                duration_s: 0.2,
                place: Place::Saddle {},
            }),
        );
    }
    if noise.uniform() < 0.3 {
        let wind_m_s = side(noise) * between(noise, 2.0, 7.0);
        let start_s = start(noise);
        at(
            start_s,
            Disturbance::Gust(Gust {
                wind_m_s,
                duration_s: between(noise, 0.5, 3.0),
                speed_m_s,
                side_area_m2: 0.8,
                air_density_kg_m3: 1.2,
                place: Place::Point {
                    x_m: 0.4,
                    height_m: 1.0,
                },
            }),
        );
    }
    if noise.uniform() < 0.15 {
        let start_s = start(noise);
        at(
            start_s,
            Disturbance::RigMultisine(RigMultisine {
                amplitude_m: 0.0125,
                slope: 1.0,
                duration_s: fifth_s.max(3.0),
                fade_s: 1.0,
            }),
        );
    }
    list
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn courses_are_legal_and_reach_every_surface_and_speed() {
        let mut seen = std::collections::BTreeSet::new();
        let (mut slowest, mut fastest) = (f64::INFINITY, 0.0f64);
        for number in 0..200 {
            let drawn = draw(1, "older", number, 60.0, crate::spec::BICYCLE);
            drawn.course.check("drawn").expect("legal");
            drawn.course.plant.clone_road().validate().expect("legal");
            seen.insert(drawn.surface);
            for v in drawn.speeds_m_s {
                (slowest, fastest) = (slowest.min(v), fastest.max(v));
            }
            assert_eq!(drawn, draw(1, "older", number, 60.0, crate::spec::BICYCLE));
        }
        assert_eq!(seen.len(), Surface::ALL.len());
        assert!(slowest < 3.2 && fastest > 7.8);
    }

    trait CloneRoad {
        fn clone_road(&self) -> Road;
    }

    impl CloneRoad for PlantChoice {
        fn clone_road(&self) -> Road {
            let PlantChoice::Multibody(choice) = self else {
                panic!("courses of a league are multibody")
            };
            choice.road.given().expect("drawn, not named").clone()
        }
    }
}
