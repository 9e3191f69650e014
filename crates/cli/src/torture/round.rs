//! One ride that is tortured, and what was found.

use super::blow::{Draw, Side, send};
use super::half::{HANGS, Half, lost_after};
use super::{Place, length};
use crate::processes::{CONTROLLER, Job, PLANT, Report};
use anyhow::Context;
use std::path::PathBuf;
use std::time::{Duration, Instant};
use twinhub_log::{CONTROL_OUTPUT, PLANT_TRUTH};
use twinhub_sim::Ride;

/// Ticks after the last command after which no drive drives any more.
const QUIET_TICKS_MAX: u64 = 200;
/// A stop that is shorter need not be noticed, ms.
const NOTICEABLE_MS: u64 = 30;

/// What one or more rides came to.
#[derive(Debug, Default)]
pub struct Found {
    pub kills: u64,
    pub stops: u64,
    pub continues: u64,
    pub controllers: u64,
    pub plants: u64,
    pub both: u64,
    pub real_time: u64,
    pub deadlocks: u64,
    pub leaks: u64,
    pub logs: u64,
    pub with_torque: u64,
    pub controller_quiet_ticks: u64,
    pub drives_quiet_ticks: u64,
    /// From the signal to the notice, real time.
    pub noticed_ns: Vec<u64>,
    /// From the kill to the notice, lockstep.
    pub lockstep_ns: Vec<u64>,
    pub failures: Vec<String>,
}

impl Found {
    /// Adds what another ride came to.
    pub fn add(&mut self, other: Self) {
        self.kills += other.kills;
        self.stops += other.stops;
        self.continues += other.continues;
        self.controllers += other.controllers;
        self.plants += other.plants;
        self.both += other.both;
        self.real_time += other.real_time;
        self.deadlocks += other.deadlocks;
        self.leaks += other.leaks;
        self.logs += other.logs;
        self.with_torque += other.with_torque;
        self.controller_quiet_ticks = self
            .controller_quiet_ticks
            .max(other.controller_quiet_ticks);
        self.drives_quiet_ticks = self.drives_quiet_ticks.max(other.drives_quiet_ticks);
        self.noticed_ns.extend(other.noticed_ns);
        self.lockstep_ns.extend(other.lockstep_ns);
        self.failures.extend(other.failures);
    }
}

/// Shared memory of the session.
fn shared_memory(session: Option<&str>) -> Vec<PathBuf> {
    std::fs::read_dir("/dev/shm")
        .into_iter()
        .flatten()
        .flatten()
        .map(|entry| entry.path())
        .filter(|path| session.is_some_and(|session| path.to_string_lossy().contains(session)))
        .collect()
}

/// One ride.
pub struct Round<'a> {
    number: u64,
    draw: Draw,
    place: &'a Place,
    link: String,
    log: PathBuf,
    real_time: bool,
    found: Found,
}

impl<'a> Round<'a> {
    /// Ride `number` of the torture with `seed`.
    pub fn new(seed: u64, number: u64, place: &'a Place) -> Self {
        let mut draw = Draw::new(seed, number);
        let real_time = draw.one_in_100(75);
        let link = format!("torture-{number}");
        Self {
            number,
            log: place.log(&link),
            draw,
            place,
            link,
            real_time,
            found: Found {
                real_time: real_time.into(),
                ..Found::default()
            },
        }
    }

    fn fail(&mut self, what: impl std::fmt::Display) {
        let pacing = if self.real_time {
            "realtime"
        } else {
            "lockstep"
        };
        self.found
            .failures
            .push(format!("ride {} ({pacing}): {what}", self.number));
    }

    /// Rides, strikes, looks.
    ///
    /// # Errors
    /// If the processes cannot be started at all.
    pub fn ride(mut self, ride: &Ride) -> anyhow::Result<Found> {
        let spin = self.draw.one_in_100(50);
        let job = serde_json::to_string(&Job {
            link: self.link.clone(),
            pacing: if self.real_time {
                "realtime"
            } else {
                "lockstep"
            }
            .into(),
            waiting: if spin { "spin" } else { "block" }.into(),
            ride_toml: ride.to_toml(),
            log: Some(self.log.clone()),
            report_every: 20,
            run_dir: Some(self.place.run_dir().path().to_owned()),
        })?;
        let mut plant = Half::start(PLANT, &job)?;
        let mut controller = Half::start(CONTROLLER, &job)?;
        let rides = |report| matches!(report, Report::Tick(tick) if tick > 0).then_some(());
        if plant.told(HANGS, rides).is_none() {
            self.found.deadlocks += 1;
            self.fail("it never began");
            let _ = plant.child.kill();
            let _ = controller.child.kill();
        } else {
            let session = self.session();
            self.strike(&mut plant, &mut controller);
            self.look(session.as_deref());
        }
        plant.end();
        controller.end();
        let _ = std::fs::remove_file(&self.log);
        Ok(self.found)
    }

    /// The session number that is part of the names of all the ride's shared memory.
    fn session(&self) -> Option<String> {
        let dir = self.place.run_dir().path().join(&self.link);
        std::fs::read_dir(dir)
            .ok()?
            .flatten()
            .find(|entry| entry.path().is_dir())
            .and_then(|entry| entry.file_name().into_string().ok())
    }

    fn pause(&mut self, least_ms: u64, most_ms: u64) -> u64 {
        let ms = self.draw.within(least_ms, most_ms);
        std::thread::sleep(Duration::from_millis(ms));
        ms
    }

    fn side(&mut self) -> Side {
        if self.draw.one_in_100(50) {
            Side::Plant
        } else {
            Side::Controller
        }
    }

    fn strike(&mut self, plant: &mut Half, controller: &mut Half) {
        // The controller asks for torque once its sensors were fresh for a second. A lockstep ride
        // comes there, and fills its log, 100 times sooner.
        match (self.real_time, self.draw.one_in_100(50)) {
            (true, true) => self.pause(1_200, 1_600),
            (true, false) => self.pause(20, 300),
            (false, _) => self.pause(1, 80),
        };
        for _ in 0..self.draw.within(0, 2) {
            let side = self.side();
            let (hit, other) = match side {
                Side::Plant => (&*plant, &*controller),
                Side::Controller => (&*controller, &*plant),
            };
            let at_ns = send(&hit.child, libc::SIGSTOP);
            let ms = self.pause(1, 80);
            send(&hit.child, libc::SIGCONT);
            self.found.stops += 1;
            self.found.continues += 1;
            if self.real_time && ms >= NOTICEABLE_MS {
                match other.told(HANGS, |report| lost_after(report, at_ns)) {
                    Some(noticed_ns) => self.found.noticed_ns.push(noticed_ns - at_ns),
                    None => self.fail(format!("a stop of {ms} ms of the {side:?} went unnoticed")),
                }
            }
            if self.real_time {
                self.pause(1, 60);
            }
        }
        let both = self.draw.one_in_100(8);
        let side = self.side();
        self.found.kills += 1 + u64::from(both);
        match (both, side) {
            (true, _) => self.found.both += 1,
            (false, Side::Plant) => self.found.plants += 1,
            (false, Side::Controller) => self.found.controllers += 1,
        }
        let (hit, other) = match side {
            Side::Plant => (plant, controller),
            Side::Controller => (controller, plant),
        };
        // Now and then the survivor sleeps while the other dies.
        let asleep = !both && self.draw.one_in_100(15);
        if asleep {
            send(&other.child, libc::SIGSTOP);
            self.found.stops += 1;
        }
        let killed_ns = send(&hit.child, libc::SIGKILL);
        let mut at_ns = killed_ns;
        if both {
            send(&other.child, libc::SIGKILL);
        }
        if hit.end().is_none() {
            self.found.deadlocks += 1;
            self.fail("a killed process did not end");
        }
        if asleep {
            self.pause(1, 50);
            at_ns = send(&other.child, libc::SIGCONT);
            self.found.continues += 1;
        }
        if both {
            other.end();
            return;
        }
        self.survivor(side, other, killed_ns, at_ns);
    }

    /// The other side after the death of `dead` at `killed_ns`; it could notice from `awake_ns` on,
    /// or just before it fell asleep.
    fn survivor(&mut self, dead: Side, other: &mut Half, killed_ns: u64, awake_ns: u64) {
        match other.told(HANGS, |report| lost_after(report, killed_ns)) {
            Some(noticed_ns) => {
                let after_ns = noticed_ns.saturating_sub(awake_ns);
                if self.real_time {
                    self.found.noticed_ns.push(after_ns);
                } else {
                    self.found.lockstep_ns.push(after_ns);
                }
            }
            None => self.fail(format!("the death of the {dead:?} went unnoticed")),
        }
        if dead == Side::Plant {
            let quiet = other.told(HANGS, |report| match report {
                Report::Quiet { ticks, .. } => Some(ticks),
                _ => None,
            });
            match quiet {
                Some(ticks) if ticks <= QUIET_TICKS_MAX => {
                    self.found.with_torque += u64::from(ticks > 0);
                    self.found.controller_quiet_ticks =
                        self.found.controller_quiet_ticks.max(ticks);
                }
                other => self.fail(format!(
                    "the controller's torque ended after {other:?} ticks"
                )),
            }
        }
        match other.end() {
            Some(status) if status.code() == Some(3) => {}
            Some(status) => self.fail(format!("the survivor ended with {status}, not with 3")),
            None => {
                self.found.deadlocks += 1;
                self.fail("the survivor hangs");
            }
        }
        if dead == Side::Controller
            && let Err(error) = self.drives()
        {
            self.fail(format!("the log of the surviving plant: {error:#}"));
        }
    }

    /// Looks in the log of a surviving plant for the end of the drives' torque.
    fn drives(&mut self) -> anyhow::Result<()> {
        let log = twinhub_log::read(&self.log)?;
        let torque = log.column(PLANT_TRUTH, "front_brake_nm")?;
        let answers = log.column(CONTROL_OUTPUT, "command.front_brake_nm")?.len();
        let ticks = torque.len();
        anyhow::ensure!(ticks > 0, "it is empty");
        anyhow::ensure!(torque[ticks - 1] == 0.0, "torque in the last tick");
        if let Some(last) = torque.iter().rposition(|nm| *nm != 0.0) {
            // In lockstep every tick until the loss has an answer; in real time some may have
            // none, and the last answered tick is counted from the end of the answers' stamps.
            let silent = if self.real_time {
                let times_s = log.table(CONTROL_OUTPUT)?.times_s();
                let last_s = times_s.last().copied().context("no answer")?;
                (last as f64 - last_s * 1e3).round() as i64
            } else {
                last as i64 - (answers as i64 - 1)
            };
            let quiet = silent.max(0) as u64 + 1;
            self.found.with_torque += 1;
            self.found.drives_quiet_ticks = self.found.drives_quiet_ticks.max(quiet);
            anyhow::ensure!(
                quiet <= QUIET_TICKS_MAX,
                "torque for {quiet} ticks after the last command"
            );
        }
        Ok(())
    }

    /// What is left of the ride.
    fn look(&mut self, session: Option<&str>) {
        if length(&self.log) > 0 {
            match twinhub_log::read(&self.log) {
                Ok(_) => self.found.logs += 1,
                Err(error) => self.fail(format!("the log does not open: {error}")),
            }
        } else {
            self.fail("there is no log");
        }
        // If both died, the next ride clears up; elsewhere the survivor has done so.
        let nobody_left = self.found.both > 0;
        if nobody_left {
            twinhub_link::ride::sweep(&self.place.run_dir());
        }
        // Another ride that starts at the same time may be clearing up right now.
        let dir = self.place.run_dir().path().join(&self.link);
        let end = Instant::now() + Duration::from_secs(5);
        let mut shared = shared_memory(session);
        while (!shared.is_empty() || dir.exists()) && Instant::now() < end {
            std::thread::sleep(Duration::from_millis(10));
            shared = shared_memory(session);
        }
        if !shared.is_empty() || dir.exists() {
            self.found.leaks += 1;
            self.fail(format!("left behind: {shared:?} {}", dir.display()));
        }
    }
}

/// Rides `ride` without touching it; gives its digest.
///
/// # Errors
/// If the processes cannot be started.
pub fn undisturbed(ride: &Ride, place: &Place) -> anyhow::Result<Option<String>> {
    let link = format!("clean-{:?}", std::thread::current().id());
    let link: String = link
        .chars()
        .filter(|c| c.is_ascii_alphanumeric() || *c == '-')
        .collect();
    let log = place.log(&link);
    let job = serde_json::to_string(&Job {
        link,
        pacing: "lockstep".into(),
        waiting: "spin".into(),
        ride_toml: ride.to_toml(),
        log: Some(log.clone()),
        report_every: 1000,
        run_dir: Some(place.run_dir().path().to_owned()),
    })?;
    let mut plant = Half::start(PLANT, &job)?;
    let mut controller = Half::start(CONTROLLER, &job)?;
    let digest = plant.told(HANGS, |report| match report {
        Report::Done { digest, .. } => Some(digest),
        _ => None,
    });
    plant.end();
    controller.end();
    let _ = std::fs::remove_file(log);
    Ok(digest)
}
