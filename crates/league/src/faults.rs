//! The fault matrix: what each fault of a sensor or of the link does to a ride.
//!
//! What: a rider on a straight, disturbed road at 4.5 m/s; at 6 s something breaks and stays broken.
//! Every fault is ridden by the same riders on the same roads, and so are the ride without the fault
//! and the ride of the same person on the same road who was never assisted. Each fault is
//! *detected* (within the time that [`Case`] states: by a health flag, or, where answers do not arrive,
//! by the drives, which take the torque out), *harmless* (no more falls than without it, and a pair
//! that is at most [`HARMLESS_NM`] larger than the healthy ride's and, where it is withdrawn, is
//! withdrawn no faster than [`WITHDRAWN_NM_S`]), or *open*.
//!
//! Assumes and ignores: one fault at a time.

mod cases;
mod finding;

pub use cases::{Case, What, cases};
pub use finding::{Finding, HARMLESS_NM, WITHDRAWN_NM_S};

use crate::error::LeagueError;
use crate::population::{Class, Person};
use crate::practice::Practice;
use crate::spec::{BICYCLE, Contestant};
use finding::{Seen, finding};
use rayon::prelude::*;
use std::cell::RefCell;
use std::sync::atomic::{AtomicUsize, Ordering};
use twinhub_control::{Config, Controller};
use twinhub_link::InProcess;
use twinhub_plant::disturbance::{Disturbance, Place, SideForce, Timed};
use twinhub_plant::multibody::{Multibody, Parameters};
use twinhub_plant::road::Road;
use twinhub_plant::sensor::{SuiteParameters, sets};
use twinhub_plant::wind::Wind;
use twinhub_sim::bicycle::ResolvedBicycle;
use twinhub_sim::choice::Choice;
use twinhub_sim::course::{Course, SpeedPoint};
use twinhub_sim::plant::{MultibodyChoice, PlantChoice};
use twinhub_sim::{Ride, Settings};
use twinhub_types::{ControllerFrame, PlantFrame};

/// When the fault comes, s.
pub const ONSET_S: f64 = 6.0;
/// Length of each ride, s.
pub const DURATION_S: f64 = 14.0;
/// Speed, m/s.
pub const SPEED_M_S: f64 = 4.5;
/// Everything that the rides share.
pub struct Matrix {
    law: Config,
    bicycle: ResolvedBicycle,
    practice: Practice,
    seeds: u64,
}

impl Matrix {
    /// For a law, `seeds` riders each: the mean older rider on roads of their own.
    ///
    /// # Errors
    /// If the bicycle or the law cannot be set up.
    pub fn new(name: &str, mut law: Config, seeds: u64) -> Result<Self, LeagueError> {
        let riders = |detail: String| LeagueError::Riders {
            bicycle: BICYCLE.into(),
            detail,
        };
        if !(1..=10_000).contains(&seeds) {
            return Err(LeagueError::OutOfRange {
                key: "riders",
                found: seeds.to_string(),
                accepted: "1 to 10000".into(),
            });
        }
        let none: [&str; 0] = [];
        let parameters: Parameters = twinhub_plant::bicycles::load_multibody(BICYCLE, &none)
            .map_err(|e| riders(e.to_string()))?;
        let model = Multibody::new(&parameters).map_err(|e| riders(e.to_string()))?;
        let bicycle = ResolvedBicycle::multibody(parameters);
        law.bicycle = bicycle.control();
        let contestant = |name: &str, law| Contestant {
            name: name.into(),
            law,
        };
        let off = twinhub_sim::setup::load_law("off", &[])?;
        let practice = Practice::new(model, &[contestant("off", off), contestant(name, law)])
            .map_err(riders)?;
        Ok(Self {
            law,
            bicycle,
            practice,
            seeds,
        })
    }

    /// Rides these cases on all cores; `done` hears how many are done.
    ///
    /// # Errors
    /// The first ride that cannot be ridden.
    pub fn run(
        &self,
        cases: &[Case],
        done: &(dyn Fn(usize) + Sync),
    ) -> Result<Vec<Finding>, LeagueError> {
        let mut references = Vec::new();
        for suite in ["as_bought", "laboratory"] {
            if cases.iter().any(|case| case.suite == suite) {
                references.push((suite, self.references(suite)?));
            }
        }
        let count = AtomicUsize::new(0);
        let one = |case: &Case| {
            let (_, (healthy, never)) = references
                .iter()
                .find(|(suite, _)| *suite == case.suite)
                .expect("made above for every suite of the cases");
            let rides: Result<Vec<Seen>, LeagueError> = (0..self.seeds)
                .map(|seed| self.ride(seed, case.suite, Some(&case.what), true))
                .collect();
            let finding = finding(case, &rides?, healthy, *never);
            done(count.fetch_add(1, Ordering::Relaxed) + 1);
            Ok(finding)
        };
        cases.par_iter().with_max_len(1).map(one).collect()
    }

    /// Rides without the fault, and how many of those who were never assisted fall.
    fn references(&self, suite: &str) -> Result<(Vec<Seen>, usize), LeagueError> {
        let rides = |assisted| -> Result<Vec<Seen>, LeagueError> {
            (0..self.seeds)
                .into_par_iter()
                .map(|seed| self.ride(seed, suite, None, assisted))
                .collect()
        };
        let never = rides(false)?.iter().filter(|seen| seen.fell).count();
        Ok((rides(true)?, never))
    }

    fn ride(
        &self,
        seed: u64,
        suite: &str,
        what: Option<&What>,
        assisted: bool,
    ) -> Result<Seen, LeagueError> {
        let person = Person {
            class: Class::Older,
            delay: 1,
            factors: [1.0; 3],
        };
        let hands = self
            .practice
            .hands_of(&person, usize::from(assisted))
            .map_err(|detail| LeagueError::Riders {
                bicycle: BICYCLE.into(),
                detail,
            })?;
        let mut sensors: SuiteParameters = sets::named(suite).unwrap_or(SuiteParameters {
            sensor: Vec::new(),
            fault: Vec::new(),
        });
        let mut course = course(seed);
        match what {
            Some(What::Sensor(fault)) => sensors.fault.push(*fault),
            Some(What::Link(fault)) => course.link_fault.push(*fault),
            None => {}
        }
        course.sensors = sensors.into();
        let ride = Ride {
            name: "faults".into(),
            stabilizer_on: assisted,
            course,
            rider: crate::league::file(hands),
            law: self.law,
            bicycle: self.bicycle.clone(),
        };
        let seen = RefCell::new(Seen::default());
        let mut controller = Controller::new(&self.law);
        let referee = Referee::new(&self.law);
        let answer = |frame: &PlantFrame| -> ControllerFrame {
            let answer = controller.answer(frame);
            let mut seen = seen.borrow_mut();
            let command = &answer.output.command;
            let last_nm = seen.front_nm.last().copied().unwrap_or(0.0);
            seen.limits_broken += u64::from(referee.broken(
                last_nm,
                command.front_brake_nm,
                command.rear_traction_nm,
            ));
            seen.front_nm.push(command.front_brake_nm);
            seen.drive_nm.push(frame.measurement.motors.front_brake_nm);
            seen.health.push(answer.output.health);
            answer
        };
        let settings = Settings {
            log: None,
            version: String::new(),
            git_hash: String::new(),
        };
        let mut port = InProcess::new(answer);
        let outcome = twinhub_sim::ride(&ride, &settings, &mut port, &mut |_| true);
        drop(port);
        let mut seen = seen.into_inner();
        seen.fell = outcome
            .map_err(|source| LeagueError::Ride {
                part: seed,
                controller: "faults".into(),
                source,
            })?
            .metrics
            .fell;
        Ok(seen)
    }
}

/// Limits as a bystander sees them: from the law file alone.
struct Referee {
    most_nm: f32,
    up_nm: f32,
}

impl Referee {
    fn new(law: &Config) -> Self {
        Self {
            most_nm: law.limits.torque_max_nm,
            // A tick of the fastest ramp, and rounding.
            up_nm: law.limits.ramp_up_nm_s * 1e-3 * 1.01 + 1e-4,
        }
    }

    fn broken(&self, last_nm: f32, front_nm: f32, rear_nm: f32) -> bool {
        let sound = front_nm >= 0.0 && front_nm <= self.most_nm && rear_nm.abs() <= self.most_nm;
        !sound || front_nm - last_nm > self.up_nm
    }
}

fn course(seed: u64) -> Course {
    Course {
        schema_version: 1,
        about: "straight, disturbed, something breaks".into(),
        duration_s: DURATION_S,
        seed: seed + 1,
        rider: "older".into(),
        law: "scheduled".into(),
        motors: Choice::Named("fixed_85_percent".into()),
        sensors: Choice::Named("as_bought".into()),
        speed: vec![SpeedPoint {
            t_s: 0.0,
            speed_m_s: SPEED_M_S,
        }],
        plant: PlantChoice::Multibody(MultibodyChoice {
            bicycle: Choice::Named(BICYCLE.into()),
            set: toml::Table::new(),
            road: Road::level(0.8).into(),
            wind: Wind::default().into(),
            sensor_at_m: None,
        }),
        disturbance: vec![Timed {
            start_s: 0.5,
            what: Disturbance::SideForce(SideForce {
                rms_n: 8.0,
                low_hz: 0.1,
                high_hz: 2.0,
                lines: 24,
                duration_s: DURATION_S - 1.0,
                fade_s: 0.5,
                place: Place::FrameCentre {},
            }),
        }],
        link_fault: Vec::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_referee_sees_what_breaks_a_limit() {
        let law = twinhub_sim::setup::load_law("constant", &[]).expect("ships");
        let referee = Referee::new(&law);
        assert!(!referee.broken(0.0, 0.02, 0.02));
        assert!(referee.broken(0.0, 0.1, 0.1), "faster than 20 Nm/s");
        assert!(referee.broken(40.0, 40.1, 40.0) && referee.broken(0.0, -0.1, 0.0));
        assert!(referee.broken(0.0, f32::NAN, 0.0) && referee.broken(0.0, 0.0, f32::NAN));
        assert!(!referee.broken(40.0, 0.0, 0.0), "down at once is allowed");
    }
}
