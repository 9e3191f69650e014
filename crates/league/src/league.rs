//! Parts: a rider on a course, once with every controller.

use crate::course::{Drawn, Surface, draw};
use crate::error::LeagueError;
use crate::population::{Class, Person};
use crate::practice::Practice;
use crate::spec::Spec;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use twinhub_control::Config;
use twinhub_link::InProcess;
use twinhub_plant::multibody::Multibody;
use twinhub_plant::rider::design::Hands;
use twinhub_plant::rider::published::{Group, Table, rider};
use twinhub_plant::rider::{Action, Channels, PedalsParameters, Perception, RiderFile};
use twinhub_sim::bicycle::ResolvedBicycle;
use twinhub_sim::{Metrics, OwnRider, Ride, Settings, in_process};
use twinhub_types::{ControllerFrame, PlantFrame};

/// What came out of one ride.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Score {
    /// The controller.
    pub controller: String,
    /// The numbers of the ride.
    pub metrics: Metrics,
}

/// A rider on a course, with every controller.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Part {
    /// Number of the part.
    pub part: u64,
    /// Class of the rider.
    pub class: Class,
    /// Number of the rider within the class.
    pub rider: u64,
    /// Delay of the rider, s.
    pub delay_s: f64,
    /// Mean speed that the course asks for, m/s.
    pub speed_m_s: f64,
    /// The most slippery spot.
    pub surface: Surface,
    /// What came out, in the order of the spec's controllers.
    pub scores: Vec<Score>,
}

/// What answers the frames of a ride.
pub type Answers<'a> = Box<dyn FnMut(&PlantFrame) -> ControllerFrame + 'a>;

/// What takes a rider's place: perceives, and acts, once a tick of so many seconds.
pub type Hand<'a> = Box<dyn FnMut(&Perception, f64) -> Action + Send + 'a>;

/// A league that can be run.
pub struct League {
    spec: Spec,
    bicycle: ResolvedBicycle,
    practice: Practice,
}

impl League {
    /// Sets up the league.
    ///
    /// # Errors
    /// If the spec breaks a rule, or its bicycle cannot be ridden at 3 to 8 m/s.
    pub fn new(spec: Spec) -> Result<Self, LeagueError> {
        spec.check()?;
        let riders = |detail: String| LeagueError::Riders {
            bicycle: spec.bicycle.clone(),
            detail,
        };
        let none: [&str; 0] = [];
        let parameters = twinhub_plant::bicycles::load_multibody(&spec.bicycle, &none)
            .map_err(|e| riders(e.to_string()))?;
        let model = Multibody::new(&parameters).map_err(|e| riders(e.to_string()))?;
        let practice = Practice::new(model, &spec.controllers).map_err(riders)?;
        Ok(Self {
            bicycle: ResolvedBicycle::multibody(parameters),
            practice,
            spec,
        })
    }

    /// What the league is.
    pub fn spec(&self) -> &Spec {
        &self.spec
    }

    /// Runs these parts on all cores, in any order; `done` hears each, and the runs end soon after
    /// `stop` turns true. Parts come back in the order of `parts`; those that were not run are left
    /// out.
    ///
    /// # Errors
    /// The first ride that cannot be ridden.
    pub fn run(
        &self,
        parts: &[u64],
        stop: &AtomicBool,
        done: &(dyn Fn(&Part, u64) + Sync),
    ) -> Result<Vec<Part>, LeagueError> {
        let count = AtomicU64::new(0);
        let one = |part: &u64| -> Option<Result<Part, LeagueError>> {
            if stop.load(Ordering::Relaxed) {
                return None;
            }
            let result = self.part(*part);
            if let Ok(result) = &result {
                done(result, count.fetch_add(1, Ordering::Relaxed) + 1);
            }
            Some(result)
        };
        parts.par_iter().with_max_len(1).filter_map(one).collect()
    }

    /// Runs part number `part`: the same bits wherever it is run.
    ///
    /// # Errors
    /// If a ride cannot be ridden.
    pub fn part(&self, part: u64) -> Result<Part, LeagueError> {
        self.part_by(part, &|_, law| Box::new(in_process(law)), None)
    }

    /// The same with controllers of the caller's own: `start` is told the controller's name and law,
    /// and gives what answers a ride's frames. `hand` gives a rider of the caller's own for each ride,
    /// in place of the population's; the courses stay those of the class.
    ///
    /// # Errors
    /// If a ride cannot be ridden.
    pub fn part_by<'a>(
        &self,
        part: u64,
        start: &dyn Fn(&str, &Config) -> Answers<'a>,
        hand: Option<&dyn Fn() -> Hand<'a>>,
    ) -> Result<Part, LeagueError> {
        let classes = self.spec.classes.len() as u64;
        let class = self.spec.classes[(part % classes) as usize];
        let number = part / classes;
        let drawn = draw(
            self.spec.seed,
            class.name(),
            number,
            self.spec.duration_s,
            &self.spec.bicycle,
        );
        let printed = || rider(Table::SteerTorque, group(number));
        let riders = match hand {
            None => self.riders(class, number, &drawn)?,
            // The file says how the pedals hold the speed; the hand does the rest.
            Some(_) => vec![printed(); self.spec.controllers.len()],
        };
        let mut scores = Vec::new();
        for (contestant, rider) in self.spec.controllers.iter().zip(riders) {
            let mut law = contestant.law;
            law.bicycle = self.bicycle.control();
            let mut course = drawn.course.clone();
            course.law.clone_from(&contestant.name);
            let ride = Ride {
                name: format!("part {part}"),
                stabilizer_on: true,
                course,
                rider,
                law,
                bicycle: self.bicycle.clone(),
            };
            let settings = Settings {
                log: None,
                version: String::new(),
                git_hash: String::new(),
            };
            let mut port = InProcess::new(start(&contestant.name, &law));
            let mut own = hand.map(|hand| hand());
            let own: Option<OwnRider<'_>> = own.as_mut().map(|hand| &mut **hand as OwnRider<'_>);
            let outcome = twinhub_sim::ride_as(&ride, &settings, &mut port, own, &mut |_| true)
                .map_err(|source| LeagueError::Ride {
                    part,
                    controller: contestant.name.clone(),
                    source,
                })?;
            scores.push(Score {
                controller: contestant.name.clone(),
                metrics: outcome.metrics,
            });
        }
        let delay_s = match class {
            Class::Published => printed().rider.linear(4.0)[0].delay_s,
            // Whatever it does, it does not say how late.
            _ if hand.is_some() => 0.0,
            _ => class.delays_s()[self.person(class, number, &drawn)?.delay],
        };
        let [from, to] = drawn.speeds_m_s;
        Ok(Part {
            part,
            class,
            rider: number,
            delay_s,
            speed_m_s: 0.5 * (from + to),
            surface: drawn.surface,
            scores,
        })
    }

    /// The person: somebody who can ride this course's speeds without a stabilizer.
    fn person(&self, class: Class, number: u64, drawn: &Drawn) -> Result<Person, LeagueError> {
        let [from, to] = drawn.speeds_m_s;
        // The best gains of each delay, found once.
        let best: Result<Vec<Hands>, String> = (0..class.delays_s().len())
            .map(|delay| self.practice.hands(class, delay, 0))
            .collect();
        let best = best.map_err(|detail| self.no_riders(detail))?;
        Ok(Person::draw(self.spec.seed, class, number, |person| {
            let hands = person.with_factors(&best[person.delay]);
            self.practice.growth_alone_per_s(&hands, from, to)
        }))
    }

    fn no_riders(&self, detail: String) -> LeagueError {
        LeagueError::Riders {
            bicycle: self.spec.bicycle.clone(),
            detail,
        }
    }

    /// The rider's file for each controller.
    fn riders(
        &self,
        class: Class,
        number: u64,
        drawn: &Drawn,
    ) -> Result<Vec<RiderFile>, LeagueError> {
        let count = self.spec.controllers.len();
        if class == Class::Published {
            return Ok(vec![rider(Table::SteerTorque, group(number)); count]);
        }
        let person = self.person(class, number, drawn)?;
        (0..count)
            .map(|contestant| {
                let hands = self
                    .practice
                    .hands_of(&person, contestant)
                    .map_err(|detail| self.no_riders(detail))?;
                Ok(file(hands))
            })
            .collect()
    }
}

/// Printed riders take turns.
fn group(number: u64) -> Group {
    if number.is_multiple_of(2) {
        Group::Young
    } else {
        Group::Older
    }
}

/// The rider file of these hands.
pub(crate) fn file(hands: Hands) -> RiderFile {
    let mut channels = Channels::default();
    match hands {
        Hands::Torque { channel, .. } => channels.steer_torque = Some(channel),
        Hands::Angle { channel } => channels.steer_angle = Some(channel),
    }
    RiderFile {
        schema_version: 1,
        about: "a rider of a league".into(),
        source: "twinhub-league".into(),
        rider: channels,
        pedals: PedalsParameters {
            speed_gain_ns_m: 1000.0,
            force_limit_n: 150.0,
        },
    }
}
