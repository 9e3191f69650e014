//! What: steady states: straight or in a turn, at constant speed or under unbalanced motor
//! torques.
//!
//! Equation: reduced derivative = a · w, where w is the direction in which the state goes when
//! speed changes at unit rate with slips and curvature kept (all velocities in proportion). Either
//! the torques are given and the acceleration a is unknown, or a = 0 and the rear torque is
//! unknown. With the roll angle given, the steer torque is unknown too. Newton's method with the
//! exact Jacobian from dual numbers.
//!
//! Source: Bulsink (2017), chapter 7 (torques at constant speed); own formulation.
//!
//! Assumes and ignores: with a ≠ 0 the state is steady only for as long as speed hardly changes.
//!
//! Valid for: tyres below their limit of friction.
//!
//! Checked by: residual below 1e-9 in every solution; `tests` in `linearise`.

use super::error::MultibodyError;
use super::linearise::{Directional, columns};
use super::model::{Input, Multibody};
use super::reduced::{REDUCED, Reduced, place};
use super::state::State;
use crate::tyre::TyreModel;
use nalgebra::{DMatrix, DVector};

/// What is asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Course {
    /// Forward speed, m/s: of the base on tyres, of the rear wheel's rim without slip.
    pub speed_m_s: f64,
    /// Roll angle, rad: zero is straight ahead.
    pub roll_rad: f64,
    /// Front brake torque, Nm.
    pub front_brake_nm: f64,
    /// Rear torque.
    pub rear: Rear,
}

/// Rear torque of a steady state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Rear {
    /// Given, Nm: the bicycle may accelerate.
    Torque(f64),
    /// Whatever keeps the speed.
    HoldSpeed,
}

impl Course {
    /// Straight ahead, motors off, coasting.
    pub fn straight(speed_m_s: f64) -> Self {
        Self {
            speed_m_s,
            roll_rad: 0.0,
            front_brake_nm: 0.0,
            rear: Rear::HoldSpeed,
        }
    }

    /// Straight ahead with a pair of motor torques at steady speed.
    pub fn pair(speed_m_s: f64, torque_nm: f64) -> Self {
        Self {
            front_brake_nm: torque_nm,
            ..Self::straight(speed_m_s)
        }
    }
}

/// A steady state.
#[derive(Clone, Debug)]
pub struct Steady {
    /// What was asked for.
    pub course: Course,
    /// Full state, at the origin, heading along x.
    pub state: State,
    /// Torques that keep it there.
    pub input: Input,
    /// Forward acceleration, m/s².
    pub acceleration_m_s2: f64,
    pub(super) reduced: Reduced<f64>,
}

impl Steady {
    /// Steer angle, rad.
    pub fn steer_rad(&self) -> f64 {
        self.state[super::state::STEER]
    }
}

/// Newton steps at most.
const STEPS: usize = 40;
/// Largest residual of a solution (SI units of the state's derivative).
const ACCEPTED: f64 = 1.0e-9;
/// Places that a mirror leaves as they are (of the legs, both).
fn longitudinal(k: usize) -> bool {
    matches!(k, 3 | 5..=8 | 11 | 13 | 14 | 16 | 18 | 20..=22 | 25 | 26)
}

impl Multibody {
    /// A steady state, from a guess nearby if there is one.
    pub fn steady(
        &self,
        course: &Course,
        guess: Option<&Steady>,
    ) -> Result<Steady, MultibodyError> {
        if !(course.speed_m_s.is_finite() && course.speed_m_s >= 0.05 && course.speed_m_s <= 60.0) {
            return Err(MultibodyError::Speed {
                found: course.speed_m_s,
                accepted: "0.05 to 60",
            });
        }
        // Rates of joints are zero and need no equation; straight ahead nothing lateral does.
        let straight = course.roll_rad == 0.0;
        let counts = |k: &usize| !straight || longitudinal(*k);
        let rest = |k: usize| {
            (place::STEER_RATE..place::ANGULAR).contains(&k)
                || (self.no_slip && k == place::ANGULAR)
        };
        let at_rest = |k: usize| {
            (place::STEER..place::HEIGHT).contains(&k) || (self.no_slip && k == place::ROLL)
        };
        let active: Vec<usize> = self.active().into_iter().filter(counts).collect();
        let free: Vec<usize> = active
            .iter()
            .copied()
            .filter(|&k| k != place::ROLL && k != place::VELOCITY && !rest(k))
            .collect();
        let active: Vec<usize> = active.into_iter().filter(|&k| !at_rest(k)).collect();
        let mut r = self.guess(course, guess);
        let steer_free = self.parameters.joints.steer.free && !straight;
        let mut torque = guess.map_or(0.0, |g| g.input.steer_torque_nm);
        // The last unknown: acceleration, or rear torque.
        let mut last = match course.rear {
            Rear::Torque(_) => guess.map_or(0.0, |g| g.acceleration_m_s2),
            Rear::HoldSpeed => guess.map_or_else(
                || self.balanced_rear_nm(course.front_brake_nm),
                |g| g.input.rear_traction_nm,
            ),
        };
        let mut residual = f64::INFINITY;
        let mut previous = f64::INFINITY;
        for iteration in 0..STEPS {
            let n = active.len();
            let (values, jacobian) =
                self.residual(course, &active, &free, &r, torque, last, steer_free);
            residual = values.amax();
            // Converged, or as near as rounding lets it.
            if residual < ACCEPTED && (residual >= 0.5 * previous || residual < 1.0e-13) {
                return Ok(self.finished(course, r, torque, last));
            }
            previous = residual;
            let Some(step) = jacobian.lu().solve(&values) else {
                break;
            };
            if !step.iter().all(|v| v.is_finite()) {
                break;
            }
            // Far from the solution a full step can throw a wheel off the ground.
            let damping = if iteration < 3 {
                (1.0 / step.amax().max(1.0e-9)).min(1.0)
            } else {
                1.0
            };
            let damping = if self.no_slip || guess.is_some() {
                1.0
            } else {
                damping.max(0.05)
            };
            for (i, &k) in free.iter().enumerate() {
                r[k] -= damping * step[i];
            }
            let mut at = free.len();
            if steer_free {
                torque -= damping * step[at];
                at += 1;
            }
            last -= damping * step[at];
            debug_assert_eq!(at + 1, n);
        }
        Err(MultibodyError::NoSteadyState {
            speed_m_s: course.speed_m_s,
            iterations: STEPS,
            residual,
        })
    }

    /// Rear torque whose force at the road equals the front brake's.
    fn balanced_rear_nm(&self, front_brake_nm: f64) -> f64 {
        front_brake_nm * self.tree.wheels[0].radius / self.tree.wheels[1].radius
    }

    fn finished(&self, course: &Course, r: Reduced<f64>, torque: f64, last: f64) -> Steady {
        let (rear, acceleration) = match course.rear {
            Rear::Torque(rear) => (rear, last),
            Rear::HoldSpeed => (last, 0.0),
        };
        Steady {
            course: *course,
            state: self.expanded(&r),
            input: Input {
                front_brake_nm: course.front_brake_nm,
                rear_traction_nm: rear,
                steer_torque_nm: torque,
                ..Input::default()
            },
            acceleration_m_s2: acceleration,
            reduced: r,
        }
    }

    /// Where to start: the solution nearby, or the bicycle standing on its tyres.
    fn guess(&self, course: &Course, guess: Option<&Steady>) -> Reduced<f64> {
        let mut r = guess.map_or([0.0; REDUCED], |g| {
            let mut r = g.reduced;
            let ratio = course.speed_m_s / g.course.speed_m_s;
            for k in [
                place::SPIN,
                place::SPIN + 1,
                place::VELOCITY + 1,
                place::VELOCITY + 2,
            ] {
                r[k] *= ratio;
            }
            for k in 0..3 {
                r[place::ANGULAR + k] *= ratio;
            }
            r
        });
        r[place::ROLL] = course.roll_rad;
        r[place::VELOCITY] = course.speed_m_s;
        if guess.is_none() {
            if course.roll_rad != 0.0 {
                // Whipple's steady turn, roughly: tan(roll) = v² delta / (g w).
                let g = self.parameters.gravity_m_s2.max(1.0);
                let tilt = libm::cos(self.parameters.geometry.steer_tilt_rad);
                let wheelbase = self.parameters.geometry.wheelbase_m;
                let curvature =
                    g * libm::tan(course.roll_rad) / (course.speed_m_s * course.speed_m_s);
                r[place::STEER] = (curvature * wheelbase / tilt).clamp(-0.5, 0.5);
                let yaw = course.speed_m_s * curvature;
                r[place::ANGULAR + 1] = yaw * libm::sin(course.roll_rad);
                r[place::ANGULAR + 2] = yaw * libm::cos(course.roll_rad);
            }
            let (front, rear) = self.static_loads_n();
            let sink = |load: f64, k: usize| load / self.tyres[k].vertical().stiffness_n_m;
            let (rear, front) = (sink(rear, 0), sink(front, 1));
            let radius = self.tree.wheels[0].radius;
            r[place::HEIGHT] = -libm::cos(course.roll_rad) * (radius - rear);
            r[place::PITCH] = (rear - front) / self.parameters.geometry.wheelbase_m;
            for k in 0..2 {
                r[place::SPIN + k] = course.speed_m_s
                    / (self.tree.wheels[k].radius - if k == 0 { rear } else { front });
            }
        }
        r
    }

    /// Loads of front and rear wheel at rest, N.
    pub fn static_loads_n(&self) -> (f64, f64) {
        let h = &self.tree.base;
        // First moments of fork and legs beyond their constant part at zero angle.
        let hinges = [&self.tree.steer, &self.tree.legs[0], &self.tree.legs[1]];
        let moment = h[6]
            + hinges
                .iter()
                .map(|p| p.harmonics[0][6] + p.harmonics[2][6])
                .sum::<f64>()
            + self.tree.trunk.first[0]
            + self.tree.trunk.mass * self.tree.trunk.joint[0];
        let g = self.parameters.gravity_m_s2;
        let front = g * moment / self.parameters.geometry.wheelbase_m;
        (front, g * (h[9] + self.tree.trunk.mass) - front)
    }

    /// Residual and Jacobian of the steady equations.
    #[allow(clippy::too_many_arguments)]
    fn residual(
        &self,
        course: &Course,
        active: &[usize],
        free: &[usize],
        r: &Reduced<f64>,
        torque: f64,
        last: f64,
        steer_free: bool,
    ) -> (DVector<f64>, DMatrix<f64>) {
        let constant = Directional::constant;
        let n = active.len();
        let mut values = DVector::zeros(n);
        let jacobian = columns(n, n, |pass| {
            // 1 in the direction of an unknown, if this pass has it.
            let seed = |value: f64, at: usize| {
                let mut number = constant(value);
                if pass.contains(&at) {
                    number.eps[at - pass.start] = 1.0;
                }
                number
            };
            let mut dual: Reduced<Directional> = r.map(constant);
            for (i, &k) in free.iter().enumerate() {
                dual[k] = seed(r[k], i);
            }
            let mut at = free.len();
            let mut steer_torque = constant(torque);
            if steer_free {
                steer_torque = seed(torque, at);
                at += 1;
            }
            let unknown = seed(last, at);
            let (rear, acceleration) = match course.rear {
                Rear::Torque(rear) => (constant(rear), unknown),
                Rear::HoldSpeed => (unknown, constant(0.0)),
            };
            let input = Input {
                front_brake_nm: constant(course.front_brake_nm),
                rear_traction_nm: rear,
                steer_torque_nm: steer_torque,
                ..Input::default()
            };
            let d = self.reduced_rhs(&dual, &input);
            let per_speed = constant(1.0) / dual[place::VELOCITY];
            let residual = active.iter().map(|&k| {
                // What grows in proportion to speed.
                let velocity = (place::ANGULAR..place::SLIP).contains(&k);
                if velocity {
                    d[k] - acceleration * dual[k] * per_speed
                } else {
                    d[k]
                }
            });
            let residual: Vec<Directional> = residual.collect();
            values = DVector::from_fn(n, |i, _| residual[i].re);
            residual
        });
        (values, jacobian)
    }
}
