//! What the controller believes, each quantity with its uncertainty and its age.
//!
//! # What
//! Beside the state that the law rests on ([`Estimate`]): the loads of both wheels, their longitudinal slip,
//! the friction of the road where a wheel has just told it, and the lean of the road.
//!
//! # Equation
//! Longitudinal specific force `f` (accelerometer through a low pass, else motor torques) moves
//! `m f h / w` from the front wheel to the rear. Slip is `(omega r - v) / v`. A wheel that slips under its
//! motor says that friction is less than what was asked of it, `T / (r N)` beside the side force of the
//! turn: anywhere between nothing and that. Nothing else tells it: without a slip, friction is unknown.
//!
//! # Source
//! Rigid-body statics. The slope of force over slip, by which cars estimate friction (Gustafsson 1997,
//! Automatica 33), does not show in wheel rates as bought, and a slip that the guard ends after some 20 ms
//! is over before five of their samples.
//!
//! # Assumes and ignores
//! Loads: bounce, and what a slope moves while no accelerometer tells it. Friction: one number for both
//! wheels, worth [`FRICTION_MEMORY_S`]. Lean of the road: no sensor here feels it, so that it stays what
//! roads are built with.
//!
//! # Valid for
//! Slip above 0.5 m/s.
//!
//! # Checked by
//! `tests/stabilizer/belief.rs`: loads, slip and friction against the plant's, with sensors as bought.

use twinhub_types::{
    Estimate, Instant, Measurement, MotorSample, NEVER_NS, RiderIntent, WheelSample,
};

use crate::bounded::Bounded as _;
use crate::clock::{Clock, Tick};
use crate::config::Bicycle;
use crate::doubt::low_pass;
use crate::estimator::GRAVITY_M_S2;
use crate::guard::tolerated_slip_m_s;
use crate::senses::{Seen, Senses, within};

/// How long the friction of a slip is believed, s.
pub const FRICTION_MEMORY_S: f32 = 10.0;
/// Age of what was never measured, s.
pub const NEVER_S: f32 = 1e9;
/// Slowest speed at which slip is a ratio of it, m/s.
const SLIP_SPEED_M_S: f32 = 0.5;
/// Largest torque of a motor that is believed, Nm.
const TORQUE_MAX_NM: f32 = 300.0;
/// Oldest motor sample that is believed, s.
const MOTORS_AGE_S: f32 = 0.1;
/// Memory of the longitudinal specific force, s.
const ACCEL_TAU_S: f32 = 0.1;
/// Torque of a motor that leaves its wheel to the road, Nm.
const FREE_NM: f32 = 1.0;
/// Least load that friction is a ratio of, N, and the largest friction of roads.
const LOAD_MIN_N: f32 = 30.0;
const FRICTION_MAX: f32 = 1.2;
const SQRT_12: f32 = 3.464_101_6;
/// Share by which declared loads at rest may be wrong (guess).
const LOAD_SD_RATIO: f32 = 0.03;
/// Offset of the accelerometer's forward axis with its mounting, m/s².
const ACCEL_SD_M_S2: f32 = 0.25;
/// Share by which the radius of a wheel may be wrong.
const RADIUS_SD_RATIO: f32 = 0.01;
/// Lean of roads, one standard deviation: 2 degrees of cross slope.
const ROAD_LEAN_SD_RAD: f32 = 0.035;
/// Standard deviations of gyros and the steer encoder as bought.
const RATE_SD_RAD_S: f32 = 0.01;
const STEER_SD_RAD: f32 = 0.01;
const STEER_RATE_SD_RAD_S: f32 = 0.1;

/// A quantity, one standard deviation of it, and the age of the reading that it rests on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Known {
    /// The value.
    pub value: f32,
    /// One standard deviation.
    pub sd: f32,
    /// Age, s; [`NEVER_S`] if it was never measured.
    pub age_s: f32,
}

/// Everything that is believed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Belief {
    /// Roll, rad.
    pub roll_rad: Known,
    /// Roll rate, rad/s.
    pub roll_rate_rad_s: Known,
    /// Steer, rad.
    pub steer_rad: Known,
    /// Steer rate, rad/s.
    pub steer_rate_rad_s: Known,
    /// Yaw rate, rad/s.
    pub yaw_rate_rad_s: Known,
    /// Speed, m/s.
    pub speed_m_s: Known,
    /// Lean of the road, rad.
    pub road_lean_rad: Known,
    /// Load of the front wheel, N.
    pub front_load_n: Known,
    /// Load of the rear wheel, N.
    pub rear_load_n: Known,
    /// Longitudinal slip of the front wheel, negative while it brakes.
    pub front_slip_ratio: Known,
    /// Longitudinal slip of the rear wheel, positive while it drives.
    pub rear_slip_ratio: Known,
    /// Friction of the road; none while it is unknown.
    pub friction_ratio: Option<Known>,
}

/// Memory behind the belief: runs beside a controller, tick by tick, and reads the sensors itself, so that
/// a board which does not ask pays nothing.
#[derive(Clone, Copy, Debug)]
pub struct Believer {
    clock: Clock,
    senses: Senses,
    mass_kg: f32,
    static_n: [f32; 2],
    transfer_ratio: f32,
    radii_m: [f32; 2],
    accel_m_s2: f32,
    /// What friction is less than.
    friction_below: f32,
    friction_age_s: f32,
    belief: Belief,
}

impl Believer {
    /// Nothing seen yet.
    pub fn new(bicycle: &Bicycle) -> Self {
        let static_n = [bicycle.front_load_n, bicycle.rear_load_n];
        let unknown = |value: f32, sd: f32| Known {
            value,
            sd,
            age_s: NEVER_S,
        };
        let nothing = unknown(0.0, 1.0);
        Self {
            clock: Clock::default(),
            senses: Senses::default(),
            mass_kg: (static_n[0] + static_n[1]) / GRAVITY_M_S2,
            static_n,
            transfer_ratio: bicycle.com_height_m / bicycle.wheelbase_m,
            radii_m: [bicycle.front_wheel_radius_m, bicycle.rear_wheel_radius_m],
            accel_m_s2: 0.0,
            friction_below: f32::INFINITY,
            friction_age_s: NEVER_S,
            belief: Belief {
                roll_rad: nothing,
                roll_rate_rad_s: nothing,
                steer_rad: nothing,
                steer_rate_rad_s: nothing,
                yaw_rate_rad_s: nothing,
                speed_m_s: unknown(0.0, 30.0),
                road_lean_rad: unknown(0.0, ROAD_LEAN_SD_RAD),
                front_load_n: unknown(static_n[0], LOAD_SD_RATIO * static_n[0]),
                rear_load_n: unknown(static_n[1], LOAD_SD_RATIO * static_n[1]),
                front_slip_ratio: nothing,
                rear_slip_ratio: nothing,
                friction_ratio: None,
            },
        }
    }

    /// What is believed now.
    pub fn belief(&self) -> &Belief {
        &self.belief
    }

    /// Moves on by a tick, in which a controller estimated `x` from the same readings.
    pub fn update(
        &mut self,
        now: Instant,
        meas: &Measurement,
        rider: &RiderIntent,
        x: &Estimate,
    ) -> &Belief {
        let tick = &self.clock.tick(now);
        let seen = &self.senses.read(now, meas, rider);
        let motors = believed(tick.now, &meas.motors);
        self.load(tick, seen, motors);
        self.state(tick, seen, x);
        self.slip(tick, seen, x);
        self.friction(tick, seen, motors, x);
        &self.belief
    }

    fn load(&mut self, tick: &Tick, seen: &Seen, motors: Option<&MotorSample>) {
        let (felt, age_s) = match (&seen.imu, motors) {
            (Some(imu), _) => (imu.accel_m_s2[0], age_s(tick.now, imu.stamp_ns)),
            (None, Some(m)) => {
                let [front, rear] = [-m.front_brake_nm, m.rear_traction_nm];
                let force_n = front / self.radii_m[0] + rear / self.radii_m[1];
                (force_n / self.mass_kg, age_s(tick.now, m.stamp_ns))
            }
            (None, None) => (0.0, NEVER_S),
        };
        self.accel_m_s2 = low_pass(self.accel_m_s2, felt, tick.credit_s, ACCEL_TAU_S);
        let moved_n = self.mass_kg * self.transfer_ratio * self.accel_m_s2;
        let accel_sd = if seen.imu.is_some() {
            ACCEL_SD_M_S2
        } else {
            1.0
        };
        let moved_sd_n = self.mass_kg * self.transfer_ratio * accel_sd;
        let known = |rest_n: f32, value: f32| Known {
            value: value.at_least(0.0),
            sd: libm::hypotf(LOAD_SD_RATIO * rest_n, moved_sd_n),
            age_s,
        };
        let [front_n, rear_n] = self.static_n;
        self.belief.front_load_n = known(front_n, front_n - moved_n);
        self.belief.rear_load_n = known(rear_n, rear_n + moved_n);
    }

    fn state(&mut self, tick: &Tick, seen: &Seen, x: &Estimate) {
        let age = |stamp_ns: Option<u64>| stamp_ns.map_or(NEVER_S, |s| age_s(tick.now, s));
        let imu_s = age(seen.imu.as_ref().map(|s| s.stamp_ns));
        let roll_s = imu_s.at_most(age(seen.roll.as_ref().map(|s| s.stamp_ns)));
        let steer_s = age(seen.steer.as_ref().map(|s| s.stamp_ns));
        let wheels_s = age(seen.wheels.as_ref().map(|s| s.stamp_ns));
        let known = |value: f32, sd: f32, age_s: f32, last: &Known| Known {
            value,
            sd,
            // What is held grows old.
            age_s: if age_s < NEVER_S {
                age_s
            } else {
                (last.age_s + tick.debit_s).at_most(NEVER_S)
            },
        };
        let b = &mut self.belief;
        b.roll_rad = known(x.roll_rad, x.roll_sd_rad, roll_s, &b.roll_rad);
        b.roll_rate_rad_s = known(x.roll_rate_rad_s, RATE_SD_RAD_S, roll_s, &b.roll_rate_rad_s);
        b.steer_rad = known(x.steer_rad, STEER_SD_RAD, steer_s, &b.steer_rad);
        let steer_rate = &b.steer_rate_rad_s;
        b.steer_rate_rad_s = known(x.steer_rate_rad_s, STEER_RATE_SD_RAD_S, steer_s, steer_rate);
        let yaw_s = if seen.imu.is_some() {
            imu_s
        } else {
            steer_s.at_least(wheels_s)
        };
        b.yaw_rate_rad_s = known(x.yaw_rate_rad_s, RATE_SD_RAD_S, yaw_s, &b.yaw_rate_rad_s);
        b.speed_m_s = known(x.speed_m_s, x.speed_sd_m_s, wheels_s, &b.speed_m_s);
    }

    fn slip(&mut self, tick: &Tick, seen: &Seen, x: &Estimate) {
        let Some(wheels) = &seen.wheels else {
            return;
        };
        let v = x.speed_m_s.abs().at_least(SLIP_SPEED_M_S);
        let age_s = age_s(tick.now, wheels.stamp_ns);
        let known = |tread_m_s: f32| Known {
            value: (tread_m_s - x.speed_m_s) / v,
            sd: libm::hypotf(x.speed_sd_m_s / v, RADIUS_SD_RATIO),
            age_s,
        };
        let [front_m_s, rear_m_s] = self.treads_m_s(wheels);
        self.belief.front_slip_ratio = known(front_m_s);
        self.belief.rear_slip_ratio = known(rear_m_s);
    }

    fn treads_m_s(&self, wheels: &WheelSample) -> [f32; 2] {
        [
            wheels.front_rad_s * self.radii_m[0],
            wheels.rear_rad_s * self.radii_m[1],
        ]
    }

    /// A wheel that slips says that friction is less than what is asked of it.
    fn friction(&mut self, tick: &Tick, seen: &Seen, motors: Option<&MotorSample>, x: &Estimate) {
        self.friction_age_s = (self.friction_age_s + tick.debit_s).at_most(NEVER_S);
        if self.friction_age_s > FRICTION_MEMORY_S {
            self.friction_below = f32::INFINITY;
        }
        if let (Some(wheels), Some(m)) = (&seen.wheels, motors) {
            let [front_m_s, rear_m_s] = self.treads_m_s(wheels);
            let tolerated = tolerated_slip_m_s(wheels.speed_m_s);
            let front = wheels.speed_m_s - front_m_s > tolerated;
            let rear = rear_m_s - wheels.speed_m_s > tolerated;
            let asked = |slips: bool, torque_nm: f32, radius_m: f32, load: &Known| {
                // A wheel that its motor has left comes back by itself, and says nothing.
                let acts = slips && torque_nm > FREE_NM;
                acts.then(|| torque_nm / radius_m / load.value.at_least(LOAD_MIN_N))
            };
            let b = &self.belief;
            let told = asked(front, m.front_brake_nm, self.radii_m[0], &b.front_load_n).or(asked(
                rear,
                m.rear_traction_nm,
                self.radii_m[1],
                &b.rear_load_n,
            ));
            if let Some(ratio) = told {
                let side = libm::tanf(x.roll_rad.at_least(-1.0).at_most(1.0));
                self.friction_below = self.friction_below.at_most(libm::hypotf(ratio, side));
                self.friction_age_s = 0.0;
            }
        }
        // Anywhere between nothing and that: mean and standard deviation.
        let below = self.friction_below.at_most(FRICTION_MAX);
        self.belief.friction_ratio = (self.friction_age_s <= FRICTION_MEMORY_S).then_some(Known {
            value: 0.5 * below,
            sd: below / SQRT_12,
            age_s: self.friction_age_s,
        });
    }
}

/// A motor sample that can be.
fn believed(now: Instant, sample: &MotorSample) -> Option<&MotorSample> {
    let fresh = age_s(now, sample.stamp_ns) < MOTORS_AGE_S;
    let plausible = within(sample.front_brake_nm, TORQUE_MAX_NM)
        && within(sample.rear_traction_nm, TORQUE_MAX_NM);
    (fresh && plausible).then_some(sample)
}

fn age_s(now: Instant, stamp_ns: u64) -> f32 {
    if stamp_ns == NEVER_NS {
        return NEVER_S;
    }
    now.since(Instant::from_nanos(stamp_ns)).as_secs_f32()
}
