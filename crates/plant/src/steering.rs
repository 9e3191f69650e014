//! What: a device between frame and handlebar that is no rider: a passive spring, or a motor that
//! steers into the fall.
//!
//! Equation: spring T = -k delta. Motor T = lag[k (v_0 - v) phi'] for v < v_0, limited; it draws
//! P = max(T delta' / eta, T delta' eta) + (T / K_m)².
//!
//! Source: motor law: balance assist of Delft (mechmotum/fall-probability-paper). Its lag (20 ms),
//! K_m (1 Nm/√W: a geared servo) and eta (0.85) are guesses.
//!
//! Assumes and ignores: no friction, no inertia, no play of the device.
//!
//! Valid for: any motion; the motor's torque is limited.
//!
//! Checked by: tests below (signs, limit, energy).

/// A device on the handlebar, as configured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SteeringParameters {
    /// A passive spring.
    Spring {
        /// Stiffness k, Nm/rad.
        stiffness_nm_rad: f64,
    },
    /// A motor that steers into the fall.
    Motor {
        /// k, Nm s/rad per m/s.
        gain_nms_rad_per_m_s: f64,
        /// v_0, m/s.
        speed_m_s: f64,
        /// Largest torque, Nm.
        torque_max_nm: f64,
    },
}

/// What its sensors say and how its shaft turns.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SteeringSenses {
    /// Roll rate as measured, rad/s.
    pub roll_rate_rad_s: f64,
    /// Speed as measured, m/s.
    pub speed_m_s: f64,
    /// Steer angle of the shaft, rad.
    pub steer_rad: f64,
    /// Steer rate of the shaft, rad/s.
    pub steer_rate_rad_s: f64,
}

/// What it did in a tick.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SteeringOutput {
    /// Torque on the handlebar, positive steers right, Nm.
    pub torque_nm: f64,
    /// Power out of the battery, W; negative gives back.
    pub battery_w: f64,
}

const LAG_S: f64 = 0.02;
const EFFICIENCY_RATIO: f64 = 0.85;
const MOTOR_CONSTANT_NM_SQRT_W: f64 = 1.0;

/// A device on the handlebar in motion.
#[derive(Clone, Copy, Debug)]
pub struct Steering {
    parameters: SteeringParameters,
    torque_nm: f64,
}

impl SteeringParameters {
    /// Its torque about zero at `speed_m_s`: -(stiffness) steer + (gain) roll rate, without the lag.
    pub fn linear(&self, speed_m_s: f64) -> (f64, f64) {
        match *self {
            Self::Spring { stiffness_nm_rad } => (stiffness_nm_rad, 0.0),
            Self::Motor {
                gain_nms_rad_per_m_s,
                speed_m_s: most_m_s,
                ..
            } => (0.0, gain_nms_rad_per_m_s * (most_m_s - speed_m_s).max(0.0)),
        }
    }
}

impl Steering {
    /// The device at rest.
    pub const fn new(parameters: SteeringParameters) -> Self {
        Self {
            parameters,
            torque_nm: 0.0,
        }
    }

    /// One tick of `step_s`; `on` is the rider's switch, which a spring does not have.
    pub fn step(&mut self, on: bool, now: &SteeringSenses, step_s: f64) -> SteeringOutput {
        let (stiffness, gain) = self.parameters.linear(now.speed_m_s);
        match self.parameters {
            SteeringParameters::Spring { .. } => SteeringOutput {
                torque_nm: -stiffness * now.steer_rad,
                battery_w: 0.0,
            },
            SteeringParameters::Motor { torque_max_nm, .. } => {
                let wanted_nm = if on { gain * now.roll_rate_rad_s } else { 0.0 };
                let wanted_nm = wanted_nm.clamp(-torque_max_nm, torque_max_nm);
                self.torque_nm += (wanted_nm - self.torque_nm) * (step_s / (LAG_S + step_s));
                let shaft_w = self.torque_nm * now.steer_rate_rad_s;
                let copper = self.torque_nm / MOTOR_CONSTANT_NM_SQRT_W;
                SteeringOutput {
                    torque_nm: self.torque_nm,
                    battery_w: (shaft_w / EFFICIENCY_RATIO).max(shaft_w * EFFICIENCY_RATIO)
                        + copper * copper,
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_spring_centres_and_costs_nothing() {
        let mut spring = Steering::new(SteeringParameters::Spring {
            stiffness_nm_rad: 10.0,
        });
        let turned = SteeringSenses {
            steer_rad: 0.1,
            steer_rate_rad_s: 1.0,
            ..SteeringSenses::default()
        };
        let out = spring.step(false, &turned, 1e-3);
        assert_eq!((out.torque_nm, out.battery_w), (-1.0, 0.0));
    }

    #[test]
    fn the_motor_steers_into_the_fall_below_its_speed_within_its_limit() {
        let mut motor = Steering::new(SteeringParameters::Motor {
            gain_nms_rad_per_m_s: 8.0,
            speed_m_s: 4.7,
            torque_max_nm: 7.0,
        });
        let mut settle = |on, speed_m_s, roll_rate_rad_s| {
            let senses = SteeringSenses {
                roll_rate_rad_s,
                speed_m_s,
                ..SteeringSenses::default()
            };
            (0..1000).fold(SteeringOutput::default(), |_, _| {
                motor.step(on, &senses, 1e-3)
            })
        };
        let out = settle(true, 3.7, 0.1);
        assert!(
            (out.torque_nm - 0.8).abs() < 1e-9,
            "falling right: steers right"
        );
        assert!((out.battery_w - 0.64).abs() < 1e-9, "the copper's heat");
        assert!((settle(true, 2.0, -3.0).torque_nm + 7.0).abs() < 1e-9);
        assert!(settle(true, 4.7, 1.0).torque_nm.abs() < 1e-9);
        assert!(settle(false, 3.0, 1.0).torque_nm.abs() < 1e-9);
    }
}
