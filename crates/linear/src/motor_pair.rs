//! What: the part of the two hub motors in the lateral equations, without slip.
//!
//! Equation: let f be the force with which the ground brakes the front wheel, a the forward
//! acceleration. Then, with the symbols of Meijaard et al. (2007),
//!
//! * K_steer,steer grows by f c (w + c)/w cos²(lam);
//! * K_roll,steer grows by a C1_roll,steer;
//! * K_steer,steer grows by a [C1_steer,steer - mu SA - (cos(lam) + mu) mA uA
//!   + mu sin(lam) (ST - SF - mT zT)];
//! * with m_eff = mT + IRyy/rR² + IFyy/rF²: a = (T_rear/rR - T_front/rF)/m_eff and
//!   f = (T_front + SF a)/rF.
//!
//! A balanced pair has a = 0, so that only the first term remains.
//!
//! Source: own derivation; the balanced term is known. Take axes that turn with the rear frame's
//! heading. Every mass element has the forward acceleration a, the yaw acceleration is
//! psi'' = (a steer + v steer' + c steer'') cos(lam)/w, and the wheels spin up with a/r. To first
//! order the balances of Meijaard et al. (4.1)-(4.3) gain:
//!
//! * Roll of all about the rear contact's x axis: spin-up of the front wheel, whose axle points
//!   backwards by steer cos(lam): + a SF cos(lam) steer. The front load changes to
//!   w N = mT xT g + (mT zT - ST) a (pitch balance) and stands c cos(lam) steer to the left:
//!   - c cos(lam) (N - N0) steer.
//! * Yaw of all: a times the lateral first moment, + a (mT zT roll - mA uA steer); spin-up of both
//!   wheels about their tilted axles, - a (ST roll + SF sin(lam) steer); and the front force -f
//!   along the steered heading, at the contact: + f (w + c) cos(lam) steer.
//! * Steer of the front assembly about its axis: the acceleration of its mass gives
//!   `- a mA uA cos(lam) steer`, the changed load `- c cos(lam) (N - N0) (roll + sin(lam) steer)`.
//!   The force f lies in the wheel plane, as the steer axis does: no moment.
//!
//! The side force at the front is eliminated by adding mu = c cos(lam)/w times the yaw equation to
//! the steer equation; what depends on roll cancels there.
//!
//! Assumes and ignores: no slip, knife-edge wheels, no limit of friction or load, no drag; torques
//! and speed change slowly against the lateral motion.
//!
//! Valid for: both wheels on the ground and gripping.
//!
//! Checked by: `tests/linear/no_slip.rs`, a nonlinear model built on velocities alone (Kane), differentiated
//! numerically, balanced and unbalanced (1e-6; reached 1e-9).

use crate::bicycle::Bicycle;
use crate::parameters::Parameters;
use nalgebra::Matrix2;

/// Torques of the two hub motors.
#[derive(Debug, Clone, Copy, PartialEq, Default, serde::Serialize, serde::Deserialize)]
pub struct MotorPair {
    /// Front motor, positive brakes.
    pub front_brake_nm: f64,
    /// Rear motor, positive drives.
    pub rear_traction_nm: f64,
}

impl MotorPair {
    /// Motors off.
    pub const OFF: Self = Self {
        front_brake_nm: 0.0,
        rear_traction_nm: 0.0,
    };

    /// Front brake `torque_nm` and as much rear traction as keeps the speed, whatever the radii.
    /// A skate cannot brake: with a front radius of zero there is no pair.
    pub fn balanced(torque_nm: f64, bicycle: &Bicycle) -> Self {
        let p = &bicycle.parameters;
        if p.rF > 0.0 && p.rR > 0.0 {
            Self {
                front_brake_nm: torque_nm,
                rear_traction_nm: torque_nm * p.rR / p.rF,
            }
        } else {
            Self::OFF
        }
    }
}

/// The pair's part of the stiffness, ready to be multiplied by torques.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct PairCoefficients {
    /// 1/rF and 1/rR, zero for a skate.
    inverse_radius: [f64; 2],
    /// mT with the wheels' spin.
    effective_mass: f64,
    /// SF/rF.
    front_spin: f64,
    /// c (w + c)/w cos²(lam).
    per_force: f64,
    /// Stiffness per acceleration, (roll, steer) and (steer, steer).
    per_acceleration: [f64; 2],
}

impl PairCoefficients {
    #[allow(non_snake_case, clippy::too_many_arguments)]
    pub(crate) fn new(
        p: &Parameters,
        mT: f64,
        mzT: f64,
        mA_uA: f64,
        SA: f64,
        SF: f64,
        ST: f64,
        mu: f64,
        c1: &Matrix2<f64>,
    ) -> Self {
        let (sin, cos) = libm::sincos(p.lam);
        let inverse = |r: f64| if r > 0.0 { 1.0 / r } else { 0.0 };
        let (front, rear) = (inverse(p.rF), inverse(p.rR));
        Self {
            inverse_radius: [front, rear],
            effective_mass: mT + p.IRyy * rear * rear + p.IFyy * front * front,
            front_spin: SF * front,
            per_force: mu * (p.w + p.c) * cos,
            per_acceleration: [
                c1[(0, 1)],
                c1[(1, 1)] - mu * SA - (cos + mu) * mA_uA + mu * sin * (ST - SF - mzT),
            ],
        }
    }

    pub(crate) fn per_force_m(&self) -> f64 {
        self.per_force
    }

    pub(crate) fn acceleration_m_s2(&self, pair: MotorPair) -> f64 {
        let [front, rear] = self.inverse_radius;
        let net = pair.rear_traction_nm * rear - pair.front_brake_nm * front;
        // A balanced pair is balanced to rounding only; that remainder is no acceleration.
        let noise = 4.0 * f64::EPSILON * (pair.front_brake_nm * front).abs();
        if net.abs() <= noise {
            0.0
        } else {
            net / self.effective_mass
        }
    }

    /// What the pair adds to K_roll,steer and K_steer,steer.
    pub(crate) fn stiffness(&self, pair: MotorPair) -> [f64; 2] {
        let a = self.acceleration_m_s2(pair);
        let force = pair.front_brake_nm * self.inverse_radius[0] + self.front_spin * a;
        [
            a * self.per_acceleration[0],
            force * self.per_force + a * self.per_acceleration[1],
        ]
    }
}
