//! Sensors that lie: values that are plausible by themselves and do not fit those of the others.
//!
//! # What
//! Two tests of what redundant sensors leave: steer against the yaw rate of the gyro, and the three
//! speeds (front wheel, rear wheel, speedometer) against their median.
//!
//! # Equation
//! `r = delta - atan(psi' w / v) / cos(lambda)` (steer that rolling without slip would need), through
//! a first-order low pass of 0.4 s; doubted beyond `0.05 rad + 0.1 rad/s w / v`. Speeds: the largest
//! distance from the median through 0.3 s; doubted beyond `0.25 m/s + 0.1 v`.
//!
//! # Source
//! Parity equations, as in Isermann (2006), "Fault-Diagnosis Systems", chapter 10; thresholds are
//! ours.
//!
//! # Assumes and ignores
//! Side slip of the tyres is small against the threshold. Which of the two sensors lies is not said:
//! steer is named, since the gyro is watched by the accelerometer in the estimator.
//!
//! # Valid for
//! Steer: above 2 m/s. Below, nothing is doubted.
//!
//! # Checked by
//! Tests below; ordinary rides that raise no flag, and the fault matrix (`twinhub faults`).

use twinhub_types::Estimate;

use crate::bounded::Bounded as _;
use crate::clock::Tick;
use crate::config::Bicycle;
use crate::senses::Seen;

/// Slowest speed at which steer is compared with the yaw rate, m/s.
const SLOWEST_M_S: f32 = 2.0;
/// Difference of steer that is never doubted, rad.
const STEER_RAD: f32 = 0.05;
/// Error of the yaw rate that is never doubted, rad/s.
const YAW_RATE_RAD_S: f32 = 0.1;
/// Memory of the steer test, s.
const STEER_TAU_S: f32 = 0.4;
/// Difference of speed that is never doubted, m/s, and as a share of the speed.
const SPEED_M_S: f32 = 0.25;
const SPEED_RATIO: f32 = 0.1;
/// Memory of the speed test, s.
const SPEED_TAU_S: f32 = 0.3;

/// What does not fit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Doubts {
    /// Steer and yaw rate contradict each other.
    pub steer: bool,
    /// The three speeds contradict each other.
    pub speed: bool,
}

/// Memory of the tests.
#[derive(Clone, Copy, Debug)]
pub struct Doubter {
    wheelbase_m: f32,
    steer_tilt_cos: f32,
    front_wheel_radius_m: f32,
    rear_wheel_radius_m: f32,
    steer_rad: f32,
    speed_m_s: f32,
}

impl Doubter {
    /// Tests that have seen nothing yet.
    pub fn new(bicycle: &Bicycle) -> Self {
        Self {
            wheelbase_m: bicycle.wheelbase_m,
            steer_tilt_cos: libm::cosf(bicycle.steer_tilt_rad),
            front_wheel_radius_m: bicycle.front_wheel_radius_m,
            rear_wheel_radius_m: bicycle.rear_wheel_radius_m,
            steer_rad: 0.0,
            speed_m_s: 0.0,
        }
    }

    /// What does not fit at this tick, under the estimate `x` of it.
    pub fn update(&mut self, tick: &Tick, seen: &Seen, x: &Estimate) -> Doubts {
        let dt = tick.credit_s;
        let v = x.speed_m_s;
        let mut doubts = Doubts::default();
        match (&seen.steer, &seen.imu) {
            (Some(steer), Some(_)) if v > SLOWEST_M_S => {
                let needed = libm::atanf(x.yaw_rate_rad_s * self.wheelbase_m / v);
                let rest_rad = steer.steer_rad - needed / self.steer_tilt_cos;
                self.steer_rad = low_pass(self.steer_rad, rest_rad, dt, STEER_TAU_S);
                let most_rad = STEER_RAD + YAW_RATE_RAD_S * self.wheelbase_m / v;
                doubts.steer = self.steer_rad.abs() > most_rad;
            }
            _ => self.steer_rad = 0.0,
        }
        match &seen.wheels {
            Some(wheels) => {
                let front_m_s = wheels.front_rad_s * self.front_wheel_radius_m;
                let rear_m_s = wheels.rear_rad_s * self.rear_wheel_radius_m;
                let off_m_s = (front_m_s - v)
                    .abs()
                    .at_least((rear_m_s - v).abs())
                    .at_least((wheels.speed_m_s - v).abs());
                self.speed_m_s = low_pass(self.speed_m_s, off_m_s, dt, SPEED_TAU_S);
                doubts.speed = self.speed_m_s > SPEED_M_S + SPEED_RATIO * v.abs();
            }
            None => self.speed_m_s = 0.0,
        }
        doubts
    }
}

/// First order; what is no number is left out.
pub(crate) fn low_pass(last: f32, now: f32, dt_s: f32, tau_s: f32) -> f32 {
    if now.is_finite() {
        last + (now - last) * (dt_s / (tau_s + dt_s))
    } else {
        last
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::Config;
    use twinhub_types::{ImuSample, Instant, SteerSample, WheelSample};

    const V: f32 = 5.0;

    fn turning(steer_rad: f32, steer_said_rad: f32, speedometer_m_s: f32) -> (Seen, Estimate) {
        let bicycle = Config::NO_TORQUE.bicycle;
        let yaw =
            libm::tanf(steer_rad * libm::cosf(bicycle.steer_tilt_rad)) * V / bicycle.wheelbase_m;
        let rate = V / bicycle.front_wheel_radius_m;
        let seen = Seen {
            imu: Some(ImuSample::default()),
            roll: None,
            steer: Some(SteerSample {
                steer_rad: steer_said_rad,
                ..SteerSample::default()
            }),
            wheels: Some(WheelSample {
                front_rad_s: rate,
                rear_rad_s: rate,
                speed_m_s: speedometer_m_s,
                ..WheelSample::default()
            }),
            intent: None,
            link: true,
        };
        let x = Estimate {
            speed_m_s: V,
            yaw_rate_rad_s: yaw,
            ..Estimate::default()
        };
        (seen, x)
    }

    /// Doubts after so many milliseconds of the same.
    fn after(ms: u32, (seen, x): (Seen, Estimate)) -> Doubts {
        let mut doubter = Doubter::new(&Config::NO_TORQUE.bicycle);
        let tick = Tick {
            now: Instant::START,
            credit_s: 1e-3,
            debit_s: 1e-3,
            regular: true,
        };
        (0..ms).fold(Doubts::default(), |_, _| doubter.update(&tick, &seen, &x))
    }

    #[test]
    fn what_fits_is_never_doubted() {
        for steer_rad in [-0.3, 0.0, 0.1, 0.3] {
            assert_eq!(
                after(3000, turning(steer_rad, steer_rad, V)),
                Doubts::default()
            );
        }
    }

    #[test]
    fn steer_that_does_not_fit_the_yaw_rate_is_doubted_soon_and_not_at_once() {
        for (is, said) in [(0.0, 0.12), (0.1, -0.1), (0.2, 0.0)] {
            let ride = turning(is, said, V);
            assert!(!after(20, ride).steer, "a moment is no proof");
            assert!(after(700, ride).steer, "{is} rad, said {said}");
            assert!(!after(700, ride).speed);
        }
        let (seen, mut x) = turning(0.0, 0.12, V);
        x.speed_m_s = 1.0;
        assert!(!after(3000, (seen, x)).steer, "too slow to tell");
    }

    #[test]
    fn a_speedometer_that_does_not_fit_the_wheels_is_doubted() {
        let ride = turning(0.0, 0.0, V + 1.5);
        assert!(!after(20, ride).speed && after(700, ride).speed && !after(700, ride).steer);
        assert!(!after(3000, turning(0.0, 0.0, V + 0.4)).speed);
        assert!(!after(3000, turning(f32::NAN, f32::NAN, f32::NAN)).steer);
    }
}
