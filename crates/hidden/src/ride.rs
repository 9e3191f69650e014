//! A ride: the bicycle, its rider and the course, in time.

use crate::course::{Course, Motors, Multisine, Pulls, Switching};
use crate::motion::Motion;
use crate::random::{Coloured, Stream};
use crate::rider::{PERIOD_S, Rider};
use crate::state::{self, Drive, STATES, State};
use crate::truth::Truth;

/// The bicycle fell, or went out of what the equations hold for.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error(
    "{course} of set {seed}: after {t_s:.2} s roll {roll_rad:.2} rad, steer {steer_rad:.2} rad, {speed_m_s:.2} m/s; accepted: below 0.6 and 0.9 rad, above 1 m/s: hide less"
)]
pub struct Fell {
    pub course: String,
    pub seed: u64,
    pub t_s: f64,
    pub roll_rad: f64,
    pub steer_rad: f64,
    pub speed_m_s: f64,
}

/// Everything that could be measured at one moment, without any sensor.
#[derive(Clone, Copy, Debug, Default)]
pub struct Moment {
    pub roll_rad: f64,
    /// Of the bar, where the sensor sits.
    pub steer_rad: f64,
    pub roll_rate_rad_s: f64,
    pub steer_rate_rad_s: f64,
    pub yaw_rad: f64,
    pub yaw_rate_rad_s: f64,
    pub speed_m_s: f64,
    pub accel_m_s2: f64,
    /// Just before the motors' torques step at this moment.
    pub accel_before_m_s2: f64,
    /// As applied, in units of the torque sensor.
    pub steer_torque_nm: f64,
    pub pull_n: f64,
    pub front_brake_nm: f64,
    pub rear_traction_nm: f64,
    pub crank_rad: f64,
    pub cadence_rad_s: f64,
    pub front_wheel_rad_s: f64,
    pub rear_wheel_rad_s: f64,
    /// Roll and steer torque of what no library names.
    pub outside_nm: [f64; 2],
}

/// The ride on an even grid.
#[derive(Clone, Debug)]
pub struct Track {
    pub step_s: f64,
    pub moments: Vec<Moment>,
}

/// Samples of the recorder, and what the motors are told, come this often.
pub const SAMPLE_S: f64 = 0.01;
/// Where the rope pulls: (x, z).
pub const PULL_AT_M: [f64; 2] = [0.3, -0.95];
/// Road roughness: torque noise of this spectral density up to about 30 Hz, Nm sqrt(s).
const ROAD_ROLL_NM_SQRT_S: f64 = 0.25;
const ROAD_STEER_NM_SQRT_S: f64 = 0.012;

/// Rides `course` with what `truth` hides. Everything random comes from streams of (seed, course).
pub fn ride(truth: &Truth, course: &Course, seed: u64, delay: usize) -> Result<Track, Fell> {
    let motion = Motion::new(truth);
    let stream = |source: &str| Stream::new(seed, &format!("{} {source}", course.name));
    let fastest = course.speed_m_s + course.swing_m_s + 1.0;
    let parts = libm::ceil(SAMPLE_S / motion.longest_step_s(fastest)).max(4.0) as usize;
    let step_s = SAMPLE_S / parts as f64;
    let samples = libm::round(course.duration_s / SAMPLE_S) as usize;
    let mut source = Sources::new(course, &stream, step_s);
    let mut rider = Rider::new(delay);
    let decide_every = libm::round(PERIOD_S / SAMPLE_S) as usize;
    let mut x: State = [0.0; STATES];
    x[state::SPEED] = course.speed_m_s;
    x[state::CRANK] = stream("crank").between(0.0, 2.0 * core::f64::consts::PI);
    x[state::FRONT_ANGLE] = stream("wheel").between(0.0, 2.0 * core::f64::consts::PI);
    let mut drive = Drive {
        direction: course.direction,
        development_m: course.development_m,
        hands_on: course.hands_on,
        pull_at_m: PULL_AT_M,
        ..Drive::default()
    };
    let mut moments = Vec::with_capacity(samples * parts);
    for sample in 0..samples {
        let t = sample as f64 * SAMPLE_S;
        if sample % decide_every == 0 {
            drive.asked_nm = rider.decide(&x, 0.0) + source.wish_nm(t);
        }
        let before = motion.change(&x, &drive).accel_m_s2;
        source.longitudinal(&mut drive, &motion, t, x[state::SPEED]);
        for part in 0..parts {
            source.lateral(&mut drive, truth, t + part as f64 * step_s);
            let mut moment = moment(&motion, &x, &drive);
            if part == 0 {
                moment.accel_before_m_s2 = before;
            }
            moments.push(moment);
            // What is held over the step is the pull in its middle: that at its start would come half a
            // step late.
            drive.pull_n = source.pulls.at(t + (part as f64 + 0.5) * step_s);
            x = motion.step(&x, &drive, step_s);
        }
        let (roll, steer, v) = (x[state::ROLL], x[state::STEER], x[state::SPEED]);
        if !(roll.abs() < 0.6 && steer.abs() < 0.9 && v > 1.0) {
            return Err(Fell {
                course: course.name.clone(),
                seed,
                t_s: t,
                roll_rad: roll,
                steer_rad: steer,
                speed_m_s: v,
            });
        }
    }
    Ok(Track { step_s, moments })
}

/// What drives the bicycle and its rider besides feedback.
struct Sources {
    course: Course,
    wish: Multisine,
    remnant: Coloured,
    pulls: Pulls,
    front: Switching,
    rear: Switching,
    held_nm: f64,
    road_roll: Coloured,
    road_steer: Coloured,
    gust: Coloured,
}

impl Sources {
    fn new(course: &Course, stream: &impl Fn(&str) -> Stream, step_s: f64) -> Self {
        let t = course.duration_s;
        // First-order noise of density S and correlation time c: sd = S / sqrt(2 c).
        let road = |density: f64, name: &str| {
            let time_s = 0.005;
            Coloured::new(
                density / libm::sqrt(2.0 * time_s),
                time_s,
                step_s,
                stream(name),
            )
        };
        let wish_nm = 1.3 * course.amplitude;
        let remnant_nm = 0.35 * course.amplitude;
        Self {
            course: course.clone(),
            wish: Multisine::new(0.25, 4.0, 14, wish_nm, &mut stream("wish")),
            remnant: Coloured::new(remnant_nm, 0.12, PERIOD_S, stream("remnant")),
            pulls: Pulls::new(t, course.amplitude, &mut stream("pulls")),
            front: Switching::new(t, 0.0, 12.0, &mut stream("front motor")),
            rear: Switching::new(t, -8.0, 8.0, &mut stream("rear motor")),
            held_nm: 0.0,
            road_roll: road(ROAD_ROLL_NM_SQRT_S, "road roll"),
            road_steer: road(ROAD_STEER_NM_SQRT_S, "road steer"),
            gust: Coloured::new(1.0, 0.6, step_s, stream("gust")),
        }
    }

    /// Torque that the rider wants besides balance; asked once a period.
    fn wish_nm(&mut self, t_s: f64) -> f64 {
        self.wish.at(t_s) + self.remnant.step()
    }

    /// Motors or push, once a sample.
    fn longitudinal(&mut self, drive: &mut Drive, motion: &Motion, t_s: f64, speed_m_s: f64) {
        let c = &self.course;
        let omega = 2.0 * core::f64::consts::PI / 19.0;
        let wanted = c.speed_m_s + c.swing_m_s * libm::sin(omega * t_s);
        let accel = c.swing_m_s * omega * libm::cos(omega * t_s);
        let s = &motion.sums;
        let force = s.rolling_mass_kg() * (accel + 0.5 * (wanted - speed_m_s));
        if c.motors == Motors::Prescribed {
            drive.push_n = force;
            return;
        }
        // A slow hand on the speed, so that the profiles stay the profiles.
        self.held_nm += SAMPLE_S / 0.5 * (force * s.r_R - self.held_nm);
        let off = c.motors == Motors::CoastDown && t_s > 0.5 * c.duration_s;
        let (front, rear) = (self.front.at(t_s), self.rear.at(t_s));
        (drive.front_brake_nm, drive.rear_traction_nm) = match c.motors {
            _ if off => (0.0, 0.0),
            Motors::Common => (front, front * s.r_R / s.r_F + self.held_nm),
            _ => (front, rear + 6.0 * s.r_R / s.r_F + self.held_nm),
        };
        // Steps on the grid of the command's resolution.
        drive.front_brake_nm = libm::round(drive.front_brake_nm * 50.0) / 50.0;
        drive.rear_traction_nm = libm::round(drive.rear_traction_nm * 50.0) / 50.0;
    }

    /// Pulls, road and wind, at every step.
    fn lateral(&mut self, drive: &mut Drive, truth: &Truth, t_s: f64) {
        drive.pull_n = self.pulls.at(t_s);
        drive.road_roll_nm = self.road_roll.step();
        drive.road_steer_nm = self.road_steer.step();
        drive.gust_n = truth.gust_n * self.gust.step();
    }
}

fn moment(motion: &Motion, x: &State, drive: &Drive) -> Moment {
    let change = motion.change(x, drive);
    let v = x[state::SPEED];
    let (steer, steer_rate) = match motion.has_bar() {
        true => (x[state::BAR], x[state::BAR_RATE]),
        false => (x[state::STEER], x[state::STEER_RATE]),
    };
    Moment {
        roll_rad: x[state::ROLL],
        steer_rad: steer,
        roll_rate_rad_s: x[state::ROLL_RATE],
        steer_rate_rad_s: steer_rate,
        yaw_rad: x[state::YAW],
        yaw_rate_rad_s: change.yaw_rate_rad_s,
        speed_m_s: v,
        accel_m_s2: change.accel_m_s2,
        accel_before_m_s2: change.accel_m_s2,
        steer_torque_nm: x[state::TORQUE],
        pull_n: drive.pull_n,
        front_brake_nm: drive.front_brake_nm,
        rear_traction_nm: drive.rear_traction_nm,
        crank_rad: x[state::CRANK],
        cadence_rad_s: change.rate[state::CRANK],
        front_wheel_rad_s: v / motion.sums.r_F,
        rear_wheel_rad_s: v / motion.sums.r_R,
        outside_nm: change.outside_nm,
    }
}
