//! Roll, roll rate, steer, steer rate, speed and yaw rate, with uncertainty.
//!
//! # What
//! An extended Kalman filter of roll and gyro bias, driven by the roll gyro, corrected by measured
//! roll where that exists, by the balance of a bicycle that rides, and by the accelerometer of one that
//! hardly moves. Offset and tilt of an accelerometer as bought are 1.5 degrees of roll, and nothing tells
//! them from roll; balance does without it. Speed is the median of speedometer
//! and both wheels; steer comes from its encoder, differentiated if the encoder gives no rate.
//!
//! # Equation
//! In body axes (x forward, y right, z down), pitch and bounce left out:
//! `phi' = p - b`, `psi' = r cos(phi) + q sin(phi)`, at rest `a_y = v psi' cos(phi) - g sin(phi)`,
//! riding `h phi'' = g sin(phi) - v psi' cos(phi)`, both sides through a first-order low pass of
//! [`BALANCE_TAU_S`] (side forces are noise).
//! Without a gyro, `psi' = v tan(delta) cos(lambda) / w`.
//!
//! # Source
//! Rigid-body kinematics; the centripetal correction is that of Boniolo, Tanelli, Savaresi (2008),
//! "Roll angle estimation in two-wheeled vehicles", CCA. Noise densities are guesses, see below.
//!
//! # Assumes and ignores
//! Pitch, bounce, steady side wind and a load to one side (the bicycle then balances at another roll: 20 N
//! are a degree), and the lean of the road (roll is against gravity, and no sensor here feels the road).
//! Wheels roll without slip, except that the median bears one wheel that does not.
//!
//! # Valid for
//! Roll up to 1.2 rad. Beyond, the estimate stays finite and the supervisor calls it a fall.
//!
//! # Checked by
//! `a_coordinated_turn_*`, `a_gyro_bias_*` below: 0.01 rad with sensors that are right. With sensors as
//! bought, over slalom, hard turns, braking, a kerb and a bank of 5 degrees
//! (`tests/stabilizer/roll_estimate.rs`): 0.3 to 0.9 degrees rms, 3 at worst, and the claimed variance is
//! that of the errors over the list. Alone it is too large on straight roads (0.7 of it is there) and too
//! small on the bank (2.0): tyres under camber balance half a degree beside the vertical.

use twinhub_types::{Estimate, ImuSample, NEVER_NS, RollSample, SteerSample};

use crate::bounded::Bounded as _;
use crate::clock::Tick;
use crate::config::Bicycle;
use crate::doubt::low_pass;
use crate::senses::{RATE_MAX_RAD_S, Seen, span_s, within};

/// Gravity, m/s².
pub(crate) const GRAVITY_M_S2: f32 = 9.81;
/// Standard deviation of a roll sensor, rad (guess: 0.3 degrees).
const ROLL_SENSOR_SD_RAD: f32 = 0.005;
/// Random walk of roll under the gyro, rad²/s (guess: 0.07 degrees per root second).
const GYRO_DENSITY_RAD2_S: f32 = 1.5e-6;
/// Share of the other rates that the roll gyro sees, by its mounting: one degree.
const MISALIGNMENT_RAD: f32 = 0.0175;
/// How long a turn keeps its rates, s (guess).
const TURN_S: f32 = 1.0;
/// Slowest speed at which a bicycle is taken to balance, m/s.
const BALANCE_SPEED_M_S: f32 = 1.5;
/// Lateral specific force beyond which a bicycle does not balance but lies, m/s².
const LYING_M_S2: f32 = 4.0;
/// Memory of the balance, s: `phi''` comes from the rate before and behind it.
const BALANCE_TAU_S: f32 = 0.1;
/// Height at which a mass alone would roll like bicycle and rider, by that of their centre of mass: one
/// and their roll inertia by mass and height squared (guess).
const ROLL_HEIGHT_RATIO: f32 = 1.1;
/// What is left of balance besides roll, m²/s³ (side forces of 10 N on 105 kg, correlated
/// over 0.3 s).
const BALANCE_DENSITY_M2_S3: f32 = 0.005;
/// Offset of the yaw gyro, rad/s: half a degree per second, as bought.
const YAW_BIAS_SD_RAD_S: f32 = 0.0087;
/// Relative error of speed times yaw rate: tyre pressure, and the scale of the gyro.
const TURN_SD_RATIO: f32 = 0.015;
/// Offset and tilt of an accelerometer, as roll, rad: 20 mg and one degree.
const LEVEL_SD_RAD: f32 = 0.0266;
/// Random walk of the gyro's bias, rad²/s³ (guess).
const BIAS_DENSITY_RAD2_S3: f32 = 1e-8;
/// Random walk of roll while no gyro tells its rate, rad²/s (guess: 0.3 rad/s for a second).
const BLIND_DENSITY_RAD2_S: f32 = 0.1;
/// What lateral specific force carries besides roll, m²/s³ (guess: 0.5 m/s² correlated over 0.2 s).
const ACCEL_DENSITY_M2_S3: f32 = 0.1;
/// Standard deviation of speed while wheels and speedometer agree, m/s (guess).
const SPEED_SD_M_S: f32 = 0.05;
/// How fast a speed that is not measured becomes uncertain, m/s².
const SPEED_DRIFT_M_S2: f32 = 2.0;
/// Fastest change of the yaw rate, rad/s²: several times that of a sharp swerve.
const YAW_ACCEL_MAX_RAD_S2: f32 = 20.0;
/// Time constant of the differentiated steer angle and roll, s.
const DIFFERENCE_TAU_S: f32 = 0.01;

const ROLL_VARIANCE_MAX_RAD2: f32 = 1.0;
const BIAS_VARIANCE_MAX_RAD2_S2: f32 = 0.01;
const BIAS_MAX_RAD_S: f32 = 0.2;

/// The estimator's memory.
#[derive(Clone, Copy, Debug)]
pub struct Estimator {
    wheelbase_m: f32,
    steer_tilt_cos: f32,
    front_wheel_radius_m: f32,
    rear_wheel_radius_m: f32,
    roll_height_m: f32,
    /// Centripetal acceleration and roll rate through the low pass of the balance.
    centripetal_m_s2: f32,
    slow_rate_rad_s: f32,
    /// Lateral specific force through the same low pass.
    felt_m_s2: f32,
    x: Estimate,
    bias_rad_s: f32,
    // Covariance of roll and bias.
    p11: f32,
    p12: f32,
    p22: f32,
    imu_ns: u64,
    roll_ns: u64,
    roll: Difference,
    steer: Difference,
}

impl Estimator {
    /// An estimator that knows nothing yet.
    pub fn new(bicycle: &Bicycle) -> Self {
        Self {
            wheelbase_m: bicycle.wheelbase_m,
            steer_tilt_cos: libm::cosf(bicycle.steer_tilt_rad),
            front_wheel_radius_m: bicycle.front_wheel_radius_m,
            rear_wheel_radius_m: bicycle.rear_wheel_radius_m,
            roll_height_m: ROLL_HEIGHT_RATIO * bicycle.com_height_m,
            centripetal_m_s2: 0.0,
            slow_rate_rad_s: 0.0,
            felt_m_s2: 0.0,
            x: Estimate {
                roll_sd_rad: 1.0,
                speed_sd_m_s: 30.0,
                ..Estimate::default()
            },
            bias_rad_s: 0.0,
            p11: 0.1,
            p12: 0.0,
            p22: 1e-4,
            imu_ns: NEVER_NS,
            roll_ns: NEVER_NS,
            roll: Difference::default(),
            steer: Difference::default(),
        }
    }

    /// The estimate at this tick. Finite whatever comes in.
    pub fn update(&mut self, tick: &Tick, seen: &Seen) -> Estimate {
        self.speed(tick, seen);
        self.steer(seen);
        self.yaw(tick, seen);
        self.predict(tick, seen);
        if let Some(sample) = &seen.imu {
            self.correct_by_gravity(sample);
        }
        if let Some(sample) = &seen.roll {
            self.correct_by_roll(sample);
        }
        self.keep_sound();
        self.x.roll_sd_rad = libm::sqrtf(self.p11 + self.steady_variance_rad2(seen));
        self.x
    }

    /// Median of speedometer and wheels; held while there is none.
    fn speed(&mut self, tick: &Tick, seen: &Seen) {
        let Some(wheels) = &seen.wheels else {
            let grown_m_s = self.x.speed_sd_m_s + SPEED_DRIFT_M_S2 * tick.debit_s;
            self.x.speed_sd_m_s = grown_m_s.at_most(30.0);
            return;
        };
        let front_m_s = wheels.front_rad_s * self.front_wheel_radius_m;
        let rear_m_s = wheels.rear_rad_s * self.rear_wheel_radius_m;
        let (low, high) = (front_m_s.at_most(rear_m_s), front_m_s.at_least(rear_m_s));
        self.x.speed_m_s = wheels.speed_m_s.at_least(low).at_most(high);
        let spread_m_s = high.at_least(wheels.speed_m_s) - low.at_most(wheels.speed_m_s);
        self.x.speed_sd_m_s = SPEED_SD_M_S + 0.5 * spread_m_s;
    }

    fn steer(&mut self, seen: &Seen) {
        let Some(SteerSample {
            stamp_ns,
            steer_rad,
            steer_rate_rad_s,
        }) = seen.steer
        else {
            self.x.steer_rate_rad_s = 0.0;
            return;
        };
        self.x.steer_rad = steer_rad;
        let difference_rad_s = self.steer.rate(stamp_ns, steer_rad);
        self.x.steer_rate_rad_s = if within(steer_rate_rad_s, RATE_MAX_RAD_S) {
            steer_rate_rad_s
        } else {
            difference_rad_s
        };
    }

    /// Yaw rate from the gyro, else from steer and speed; no faster than a bicycle can change it, so
    /// that a single wrong sample does not take the pair away.
    fn yaw(&mut self, tick: &Tick, seen: &Seen) {
        let now_rad_s = match &seen.imu {
            Some(ImuSample {
                gyro_rad_s: [_, q, r],
                ..
            }) => r * libm::cosf(self.x.roll_rad) + q * libm::sinf(self.x.roll_rad),
            None => {
                let turn = libm::tanf(self.x.steer_rad * self.steer_tilt_cos);
                let rate_rad_s = self.x.speed_m_s * turn / self.wheelbase_m;
                rate_rad_s.at_least(-RATE_MAX_RAD_S).at_most(RATE_MAX_RAD_S)
            }
        };
        let most_rad_s = YAW_ACCEL_MAX_RAD_S2 * tick.credit_s;
        let last_rad_s = self.x.yaw_rate_rad_s;
        self.x.yaw_rate_rad_s = now_rad_s
            .at_least(last_rad_s - most_rad_s)
            .at_most(last_rad_s + most_rad_s);
    }

    /// Roll moves with the best rate there is.
    fn predict(&mut self, tick: &Tick, seen: &Seen) {
        let dt = tick.credit_s;
        if let Some(ImuSample {
            gyro_rad_s: [p, q, r],
            ..
        }) = &seen.imu
        {
            self.x.roll_rate_rad_s = p - self.bias_rad_s;
            self.x.roll_rad += self.x.roll_rate_rad_s * dt;
            let leak = MISALIGNMENT_RAD * MISALIGNMENT_RAD * (q * q + r * r);
            self.p11 +=
                dt * (GYRO_DENSITY_RAD2_S + 2.0 * TURN_S * leak - 2.0 * self.p12 + dt * self.p22);
            self.p12 -= dt * self.p22;
            self.p22 += dt * BIAS_DENSITY_RAD2_S3;
            return;
        }
        self.p11 += dt * BLIND_DENSITY_RAD2_S;
        let Some(RollSample {
            stamp_ns,
            roll_rad,
            roll_rate_rad_s,
        }) = seen.roll
        else {
            self.x.roll_rate_rad_s = 0.0;
            return;
        };
        let difference_rad_s = self.roll.rate(stamp_ns, roll_rad);
        self.x.roll_rate_rad_s = if within(roll_rate_rad_s, RATE_MAX_RAD_S) {
            roll_rate_rad_s
        } else {
            difference_rad_s
        };
        self.x.roll_rad += self.x.roll_rate_rad_s * dt;
    }

    /// What holds the bicycle up while it rides, and what the accelerometer feels of one that hardly
    /// moves; once per new sample.
    fn correct_by_gravity(&mut self, sample: &ImuSample) {
        let last_ns = core::mem::replace(&mut self.imu_ns, sample.stamp_ns);
        // Nothing for the first sample, and nothing for the last one again.
        let Some(dt) = span_s(last_ns, sample.stamp_ns) else {
            return;
        };
        let [_, q, r] = sample.gyro_rad_s;
        let [_, a_y, _] = sample.accel_m_s2;
        let v = self.x.speed_m_s;
        let (sin, cos) = (libm::sinf(self.x.roll_rad), libm::cosf(self.x.roll_rad));
        let yaw = r * cos + q * sin;
        let centripetal_m_s2 = v * yaw * cos;
        // d(centripetal - g sin(phi))/d(phi)
        let h = v * ((q * cos - r * sin) * cos - yaw * sin) - GRAVITY_M_S2 * cos;
        let rate_rad_s = self.x.roll_rate_rad_s;
        let slow = |last: f32, now: f32| low_pass(last, now, dt, BALANCE_TAU_S);
        self.centripetal_m_s2 = slow(self.centripetal_m_s2, centripetal_m_s2);
        self.slow_rate_rad_s = slow(self.slow_rate_rad_s, rate_rad_s);
        self.felt_m_s2 = slow(self.felt_m_s2, a_y);
        let (innovation, density) = if self.balances() {
            let accel_rad_s2 = (rate_rad_s - self.slow_rate_rad_s) / BALANCE_TAU_S;
            // Roll as it was in the middle of the memory.
            let weight = GRAVITY_M_S2 * libm::sinf(self.x.roll_rad - BALANCE_TAU_S * rate_rad_s);
            let left = weight - self.centripetal_m_s2 - self.roll_height_m * accel_rad_s2;
            (left, BALANCE_DENSITY_M2_S3)
        } else {
            let felt = centripetal_m_s2 - GRAVITY_M_S2 * sin;
            (a_y - felt, ACCEL_DENSITY_M2_S3)
        };
        let centripetal_sd = self.x.speed_sd_m_s * yaw;
        let density = density + 0.2 * centripetal_sd * centripetal_sd;
        self.correct(innovation, h, density / dt.at_least(1e-4).at_most(0.02));
    }

    /// True if nothing but balance can hold the bicycle up. Wheels may go on turning after a fall.
    fn balances(&self) -> bool {
        self.x.speed_m_s > BALANCE_SPEED_M_S && self.felt_m_s2.abs() < LYING_M_S2
    }

    /// Variance of roll that no averaging takes away, rad²: offsets and scales of the sensors.
    fn steady_variance_rad2(&self, seen: &Seen) -> f32 {
        if seen.roll.is_some() || seen.imu.is_none() {
            return 0.0;
        }
        if !self.balances() {
            return LEVEL_SD_RAD * LEVEL_SD_RAD;
        }
        let offset_rad = self.x.speed_m_s * YAW_BIAS_SD_RAD_S / GRAVITY_M_S2;
        let scale_rad = TURN_SD_RATIO * self.x.roll_rad;
        offset_rad * offset_rad + scale_rad * scale_rad
    }

    /// Once per new sample.
    fn correct_by_roll(&mut self, sample: &RollSample) {
        let last_ns = core::mem::replace(&mut self.roll_ns, sample.stamp_ns);
        if last_ns == sample.stamp_ns {
            return;
        }
        let innovation = sample.roll_rad - self.x.roll_rad;
        self.correct(innovation, 1.0, ROLL_SENSOR_SD_RAD * ROLL_SENSOR_SD_RAD);
    }

    /// Scalar Kalman update: `innovation = h (phi - phi_hat) + noise of variance r`.
    fn correct(&mut self, innovation: f32, h: f32, r: f32) {
        let s = h * h * self.p11 + r;
        let (k1, k2) = (h * self.p11 / s, h * self.p12 / s);
        self.x.roll_rad += k1 * innovation;
        self.bias_rad_s += k2 * innovation;
        self.p22 -= k2 * h * self.p12;
        self.p12 -= k1 * h * self.p12;
        self.p11 -= k1 * h * self.p11;
    }

    /// Bounds of what can be; a filter that left them starts again.
    fn keep_sound(&mut self) {
        let sum = self.x.roll_rad
            + self.bias_rad_s
            + self.p11
            + self.p12
            + self.p22
            + self.centripetal_m_s2
            + self.slow_rate_rad_s
            + self.felt_m_s2;
        if !sum.is_finite() {
            self.x.roll_rad = 0.0;
            self.bias_rad_s = 0.0;
            (self.centripetal_m_s2, self.slow_rate_rad_s, self.felt_m_s2) = (0.0, 0.0, 0.0);
            (self.p11, self.p12, self.p22) =
                (ROLL_VARIANCE_MAX_RAD2, 0.0, BIAS_VARIANCE_MAX_RAD2_S2);
        }
        self.x.roll_rad = self.x.roll_rad.at_least(-3.2).at_most(3.2);
        self.bias_rad_s = self
            .bias_rad_s
            .at_least(-BIAS_MAX_RAD_S)
            .at_most(BIAS_MAX_RAD_S);
        self.p11 = self.p11.at_least(1e-8).at_most(ROLL_VARIANCE_MAX_RAD2);
        self.p22 = self.p22.at_least(1e-10).at_most(BIAS_VARIANCE_MAX_RAD2_S2);
        let most = libm::sqrtf(self.p11 * self.p22);
        self.p12 = self.p12.at_least(-most).at_most(most);
    }
}

/// Rate of a sampled angle: difference quotient through a first-order low pass.
#[derive(Clone, Copy, Debug)]
struct Difference {
    stamp_ns: u64,
    angle_rad: f32,
    rate_rad_s: f32,
}

impl Default for Difference {
    fn default() -> Self {
        Self {
            stamp_ns: NEVER_NS,
            angle_rad: 0.0,
            rate_rad_s: 0.0,
        }
    }
}

impl Difference {
    /// The rate after this sample, rad/s; zero after the first and after a gap of 50 ms.
    fn rate(&mut self, stamp_ns: u64, angle_rad: f32) -> f32 {
        if stamp_ns == self.stamp_ns {
            return self.rate_rad_s;
        }
        self.rate_rad_s = match span_s(self.stamp_ns, stamp_ns) {
            Some(span_s) if span_s <= 0.05 => {
                let raw_rad_s = (angle_rad - self.angle_rad) / span_s.at_least(1e-4);
                let raw_rad_s = raw_rad_s.at_least(-RATE_MAX_RAD_S).at_most(RATE_MAX_RAD_S);
                let share = span_s / (span_s + DIFFERENCE_TAU_S);
                self.rate_rad_s + share * (raw_rad_s - self.rate_rad_s)
            }
            _ => 0.0,
        };
        self.stamp_ns = stamp_ns;
        self.angle_rad = angle_rad;
        self.rate_rad_s
    }
}

#[cfg(test)]
mod tests;
