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

use crate::error::LeagueError;
use crate::population::{Class, Person};
use crate::practice::Practice;
use crate::spec::{BICYCLE, Contestant};
use rayon::prelude::*;
use serde::Serialize;
use std::cell::RefCell;
use std::sync::atomic::{AtomicUsize, Ordering};
use twinhub_control::{Config, Controller};
use twinhub_link::fault::{Channel, LinkFault, LinkFaultKind};
use twinhub_link::InProcess;
use twinhub_plant::disturbance::{Disturbance, Place, SideForce, Timed};
use twinhub_plant::multibody::{Multibody, Parameters};
use twinhub_plant::road::Road;
use twinhub_plant::sensor::{Fault, FaultKind, FaultTarget, SuiteParameters, sets};
use twinhub_plant::wind::Wind;
use twinhub_sim::bicycle::ResolvedBicycle;
use twinhub_sim::choice::Choice;
use twinhub_sim::course::{Course, SpeedPoint};
use twinhub_sim::plant::{MultibodyChoice, PlantChoice};
use twinhub_sim::{Ride, Settings};
use twinhub_types::{ControllerFrame, Health, PlantFrame};

/// When the fault comes, s.
pub const ONSET_S: f64 = 6.0;
/// Length of each ride, s.
pub const DURATION_S: f64 = 14.0;
/// Speed, m/s.
pub const SPEED_M_S: f64 = 4.5;
/// How much larger than that of the healthy ride the pair may be, Nm, if nobody notices: what the
/// schedule itself changes within half a metre per second.
pub const HARMLESS_NM: f32 = 10.0;
/// How fast the pair may be withdrawn without being called a fault's harm, Nm/s: the ramp of a healthy
/// torque path, 2 s from 40 Nm, and a quarter.
pub const WITHDRAWN_NM_S: f32 = 25.0;
/// Over which time the withdrawal is measured, ticks.
const WITHDRAWN_TICKS: usize = 100;
/// Torque that counts as out, Nm.
const OUT_NM: f32 = 1.0;

/// Within which time a value that contradicts another sensor is doubted, s.
const DOUBT_S: f64 = 1.0;
/// Within which time the drives take the torque out when answers do not arrive, s: watchdog and ramp.
const DRIVES_S: f64 = 0.25;

/// What breaks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum What {
    /// A sensor.
    Sensor(Fault),
    /// The link.
    Link(LinkFault),
}

/// A line of the matrix: what breaks, and what is promised.
#[derive(Clone, Debug, PartialEq)]
pub struct Case {
    /// `steer_angle sign_swap`.
    pub name: String,
    /// What breaks.
    pub what: What,
    /// The sensors of the bicycle: `as_bought`, or `laboratory` for what measures roll itself.
    pub suite: &'static str,
    /// Within which time a flag is promised, s; `None`: the fault cannot be told from a ride by its
    /// values alone, it has to be harmless.
    pub stated_s: Option<f64>,
}

/// What a fault came to.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Finding {
    /// The case.
    pub fault: String,
    /// Rides.
    pub rides: usize,
    /// Promised time to a flag, s.
    pub stated_s: Option<f64>,
    /// Longest time to a flag over the rides that had one, s.
    pub detected_s: Option<f64>,
    /// Rides in which a flag rose after the onset.
    pub detected: usize,
    /// Flags that rose.
    pub flags: Vec<&'static str>,
    /// Largest excess of the commanded pair over the healthy ride's, Nm.
    pub pair_more_nm: f32,
    /// Fastest withdrawal of the pair over a tenth of a second, Nm/s.
    pub withdrawn_nm_s: f32,
    /// Ticks in which a command broke a limit: magnitude, sign, or slew upwards.
    pub limits_broken: u64,
    /// Falls with the fault.
    pub falls: usize,
    /// Falls of the same riders, assisted, without the fault.
    pub falls_healthy: usize,
    /// Falls of the same people who were never assisted.
    pub falls_never_assisted: usize,
    /// `detected`, `harmless` or `open`.
    pub verdict: &'static str,
}

/// Every fault: each sensor stuck, offset, spiked, not a number, late, gone, and wrong in sign; each
/// way of the link lossy, late, repeating, corrupting, stuck, dead.
pub fn cases() -> Vec<Case> {
    use FaultTarget as T;
    // Channels with the size of an offset that is large for them, and the flag's patience.
    let channels = [
        (T::GyroX, "gyro_x", 0.2, "as_bought"),
        (T::GyroZ, "gyro_z", 0.2, "as_bought"),
        (T::AccelY, "accel_y", 1.0, "as_bought"),
        (T::RollAngle, "roll_angle", 0.1, "laboratory"),
        (T::RollRate, "roll_rate", 0.2, "laboratory"),
        (T::SteerAngle, "steer_angle", 0.1, "as_bought"),
        (T::SteerRate, "steer_rate", 0.5, "as_bought"),
        (T::FrontWheel, "front_wheel", 3.0, "as_bought"),
        (T::RearWheel, "rear_wheel", 3.0, "as_bought"),
        (T::Speed, "speed", 1.5, "as_bought"),
        (T::FrontTorque, "front_torque", 10.0, "as_bought"),
        (T::BusVoltage, "bus_voltage", 5.0, "as_bought"),
    ];
    let sensors = [
        (T::Imu, "imu", 0.025, "as_bought"),
        (T::Roll, "roll", 0.025, "laboratory"),
        (T::Steer, "steer", 0.025, "as_bought"),
        (T::Wheels, "wheels", 0.055, "as_bought"),
        (T::Motors, "motors", 0.025, "as_bought"),
    ];
    let mut list = Vec::new();
    let mut sensor = |target, name: &str, kind: FaultKind, word: &str, suite, stated_s| {
        list.push(Case {
            name: format!("{name} {word}"),
            what: What::Sensor(Fault {
                target,
                start_s: ONSET_S,
                end_s: None,
                kind,
            }),
            suite,
            stated_s,
        });
    };
    for (target, name, amount, suite) in channels {
        let spike = FaultKind::Spike {
            amount: 10.0 * amount,
            share_ratio: 0.05,
        };
        // What contradicts another sensor is doubted; what is no number is missed.
        let wheel = matches!(target, T::FrontWheel | T::RearWheel | T::Speed);
        let doubted_s = (wheel || target == T::SteerAngle).then_some(DOUBT_S);
        let missed_s = match target {
            T::GyroX | T::GyroZ | T::AccelY | T::SteerAngle => Some(0.025),
            _ if wheel => Some(0.055),
            _ => None,
        };
        let by_wheels_s = doubted_s.filter(|_| wheel);
        sensor(target, name, FaultKind::Stuck {}, "stuck", suite, None);
        sensor(target, name, FaultKind::Offset { amount }, "offset", suite, doubted_s);
        sensor(target, name, spike, "spiked", suite, by_wheels_s);
        sensor(target, name, FaultKind::SignSwap {}, "sign_swap", suite, by_wheels_s);
        sensor(target, name, FaultKind::Nan {}, "nan", suite, missed_s);
    }
    for (target, name, patience_s, suite) in sensors {
        let late = FaultKind::Late { delay_s: 0.1 };
        let gone = FaultKind::Dropout { share_ratio: 1.0 };
        // What the motors report is not fed back: nothing is promised about it.
        let stated_s = (target != T::Motors).then_some(patience_s);
        sensor(target, name, late, "late", suite, stated_s);
        sensor(target, name, gone, "gone", suite, stated_s);
    }
    for channel in [Channel::ToController, Channel::ToPlant] {
        let kinds = [
            ("lost 20 %", LinkFaultKind::Dropout { share_ratio: 0.2 }, None),
            ("lost", LinkFaultKind::Dropout { share_ratio: 1.0 }, Some(0.025)),
            (
                "late 10 ms",
                LinkFaultKind::Late {
                    delay_s: 0.01,
                    jitter_s: 0.005,
                },
                None,
            ),
            (
                "late 50 ms",
                LinkFaultKind::Late {
                    delay_s: 0.05,
                    jitter_s: 0.0,
                },
                Some(0.025),
            ),
            ("repeated", LinkFaultKind::Repeat { share_ratio: 0.2 }, None),
            // Nobody can tell a flipped bit of a plausible number; what lies beyond is missed.
            ("corrupted", LinkFaultKind::Corrupt { share_ratio: 0.2 }, Some(0.1)),
            ("stuck", LinkFaultKind::Stuck {}, Some(0.025)),
        ];
        for (word, kind, stated_s) in kinds {
            list.push(Case {
                name: format!("{} {word}", channel.name()),
                what: What::Link(LinkFault {
                    channel,
                    start_s: ONSET_S,
                    end_s: None,
                    kind,
                }),
                suite: "as_bought",
                stated_s: match channel {
                    Channel::ToController => stated_s,
                    // Wrong answers are refused one by one; none at all is for the drives.
                    Channel::ToPlant if word == "corrupted" => None,
                    Channel::ToPlant => stated_s.map(|_| DRIVES_S),
                },
            });
        }
    }
    list
}

/// What was seen of a ride.
#[derive(Clone, Debug, Default)]
struct Seen {
    fell: bool,
    /// Front torque that is asked for, by tick, Nm.
    front_nm: Vec<f32>,
    /// Front torque that the drive reports, by tick, Nm.
    drive_nm: Vec<f32>,
    /// Health bits by tick.
    health: Vec<u32>,
    limits_broken: u64,
}

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

fn finding(case: &Case, rides: &[Seen], healthy: &[Seen], never: usize) -> Finding {
    let onset = (ONSET_S * 1e3) as usize;
    let mut times = Vec::new();
    let mut bits = 0u32;
    let by_drives = matches!(case.what, What::Link(fault) if fault.channel == Channel::ToPlant);
    let (mut pair_more_nm, mut withdrawn_nm_s) = (0.0f32, 0.0f32);
    for (ride, reference) in rides.iter().zip(healthy) {
        let flagged = (onset..ride.health.len()).find(|tick| {
            if by_drives {
                // Out and out for good, not for the tick of a wrong answer.
                let until = (*tick + WITHDRAWN_TICKS).min(ride.drive_nm.len());
                return ride.drive_nm[*tick..until].iter().all(|nm| nm.abs() < OUT_NM);
            }
            let before = reference.health.get(*tick).copied().unwrap_or(0);
            ride.health[*tick] & !before != 0
        });
        if let Some(tick) = flagged {
            times.push((tick - onset) as f64 * 1e-3);
            bits |= ride.health[tick];
        }
        // What goes wrong after the controller shows at the drive; a tick of it moves nothing, so the
        // mean over a tenth of a second is looked at.
        let (mine, theirs) = if by_drives {
            (smooth(&ride.drive_nm), smooth(&reference.drive_nm))
        } else {
            (ride.front_nm.clone(), reference.front_nm.clone())
        };
        let until = mine.len().min(theirs.len());
        for tick in onset..until {
            pair_more_nm = pair_more_nm.max(mine[tick] - theirs[tick]);
            let lost_nm_s = (mine[tick - WITHDRAWN_TICKS] - mine[tick]) / (1e-3 * WITHDRAWN_TICKS as f32);
            withdrawn_nm_s = withdrawn_nm_s.max(lost_nm_s);
        }
    }
    let falls = rides.iter().filter(|r| r.fell).count();
    let falls_healthy = healthy.iter().filter(|r| r.fell).count();
    let detected_s = times.iter().copied().reduce(f64::max);
    let in_time = case.stated_s.is_some_and(|stated_s| {
        times.len() == rides.len() && times.iter().all(|t| *t <= stated_s)
    });
    let harmless = falls <= falls_healthy
        && pair_more_nm <= HARMLESS_NM
        && withdrawn_nm_s <= WITHDRAWN_NM_S;
    let raised = Health::from_bits(bits);
    Finding {
        fault: case.name.clone(),
        rides: rides.len(),
        stated_s: case.stated_s,
        detected_s,
        detected: times.len(),
        flags: Health::TABLE
            .iter()
            .filter(|entry| raised.any(entry.flag))
            .map(|entry| entry.code)
            .collect(),
        pair_more_nm,
        withdrawn_nm_s,
        limits_broken: rides.iter().map(|r| r.limits_broken).sum(),
        falls,
        falls_healthy,
        falls_never_assisted: never,
        verdict: if in_time {
            "detected"
        } else if harmless {
            "harmless"
        } else {
            "open"
        },
    }
}

/// Mean over the last tenth of a second.
fn smooth(values: &[f32]) -> Vec<f32> {
    let mut sum = 0.0f64;
    let mut mean = |i: usize, value: &f32| {
        sum += f64::from(*value);
        if let Some(old) = i.checked_sub(WITHDRAWN_TICKS) {
            sum -= f64::from(values[old]);
        }
        (sum / (i + 1).min(WITHDRAWN_TICKS) as f64) as f32
    };
    values.iter().enumerate().map(|(i, v)| mean(i, v)).collect()
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

    #[test]
    fn every_sensor_and_both_ways_of_the_link_break_in_every_way() {
        let cases = cases();
        for word in ["stuck", "offset", "spiked", "nan", "sign_swap", "late", "gone"] {
            assert!(cases.iter().filter(|c| c.name.ends_with(word)).count() >= 5, "{word}");
        }
        for word in ["lost", "late 10 ms", "repeated", "corrupted"] {
            for way in ["to_controller", "to_plant"] {
                assert!(cases.iter().any(|c| c.name == format!("{way} {word}")));
            }
        }
        let mut names: Vec<&String> = cases.iter().map(|c| &c.name).collect();
        names.sort();
        names.dedup();
        assert_eq!(names.len(), cases.len());
    }
}
