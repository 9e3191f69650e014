//! What: forward dynamics of the tree: accelerations from forces.
//!
//! Equation: with V the base motion (angular, linear) in base axes, I the inertia of everything
//! about the base origin, F_j the momentum per unit rate of joint j and H the total momentum,
//!
//! ```text
//! I V' + Σ F_j q''_j + V ×* H + Σ (I_j' V q'_j + F_j' q'_j²) = wrench
//! F_j · V' + D_j q''_j - ½ V · I_j' V                        = torque_j
//! ```
//!
//! (Boltzmann-Hamel form: primes on I_j and F_j are derivatives with respect to q_j.) The trunk
//! joint is treated by Newton-Euler about the joint. Joints are eliminated into the 6 × 6 base
//! block, which is factored as L D Lᵀ. Each wheel adds its spin momentum as a gyroscope.
//!
//! Source: Featherstone (2008), Rigid Body Dynamics Algorithms, sections 6.3 and 9.4;
//! Meirovitch (1970), Methods of Analytical Dynamics, section 4.11.
//!
//! Assumes and ignores: rigid bodies.
//!
//! Valid for: any attitude and rate; trunk pitch below 90° (beyond it the trunk angles are
//! singular).
//!
//! Checked by: `accelerations_balance_energy` in `energy` (1e-6 over 60 s), equality with the
//! linear benchmark in `linearise` (1e-9).

use super::factored::{Factored, eliminate, factor_symmetric};
use super::inertia::{Inertia, Spatial, momentum, momentum_without_mass, power, transported};
use super::state::{
    ANGULAR, LEG_RATE, LEGS, SPIN, STEER, STEER_RATE, State, StateAccess, TRUNK, TRUNK_RATE,
};
use super::tree::{Hinge, Tree};
use super::vector::{Vec3, add, axpy, build, cross, dot, lift, scale};
use crate::Scalar;

/// Generalized forces on the tree, gravity excluded.
#[derive(Clone, Copy, Debug)]
pub(super) struct Forces<T> {
    /// Moment about the base origin and force, base axes, of everything outside the tree.
    pub wrench: Spatial<T>,
    /// Torque on the steer joint.
    pub steer: T,
    /// Torques on trunk lean, pitch, twist.
    pub trunk: [T; 3],
    /// Torques on left and right leg.
    pub legs: [T; 2],
    /// Torques that speed up rear and front wheel.
    pub spin: [T; 2],
}

impl<T: Scalar> Forces<T> {
    #[inline(always)]
    pub(super) fn zero() -> Self {
        let z = T::zero();
        Self {
            wrench: [z; 6],
            steer: z,
            trunk: [z; 3],
            legs: [z; 2],
            spin: [z; 2],
        }
    }
}

/// Accelerations of the tree: derivatives of the quasi-velocities.
#[derive(Clone, Copy, Debug)]
pub(super) struct Accelerations<T> {
    pub base: Spatial<T>,
    pub steer: T,
    pub trunk: [T; 3],
    pub legs: [T; 2],
    pub spin: [T; 2],
}

/// Where things are: what both forces and dynamics need.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pose<T> {
    /// World axes in base components (rows).
    pub rotation: [Vec3<T>; 3],
    /// Sine and cosine of steer.
    pub steer: (T, T),
    /// Front hub and axle in base axes.
    pub front_hub: Vec3<T>,
    pub front_axle: Vec3<T>,
    /// Axes of lean, pitch and twist in base axes (the first is x).
    pub pitch_axis: Vec3<T>,
    pub twist_axis: Vec3<T>,
    /// Forward and lateral axis of the trunk in base axes; the third is `twist_axis`.
    pub trunk_x: Vec3<T>,
    pub trunk_y: Vec3<T>,
}

/// Adds a hinge's body to `inertia` and its bias to `bias`; gives coupling and joint bias.
#[inline(always)]
fn hinge<T: Scalar>(
    part: &Hinge,
    (s, c): (T, T),
    rate: T,
    v: &Spatial<T>,
    inertia: &mut Inertia<T>,
    bias: &mut Spatial<T>,
) -> (Spatial<T>, T) {
    let c2 = c * c - s * s;
    let s2 = (s * c).scale(2.0);
    let (c2x, s2x) = (c2.scale(2.0), s2.scale(2.0));
    let h = &part.harmonics;
    let mut derivative: Inertia<T> = [T::zero(); 10];
    for k in 0..6 {
        inertia[k] += c.scale(h[0][k]) + s.scale(h[1][k]) + (c2.scale(h[2][k]) + s2.scale(h[3][k]));
        derivative[k] =
            c.scale(h[1][k]) - s.scale(h[0][k]) + (c2x.scale(h[3][k]) - s2x.scale(h[2][k]));
    }
    // The first moment has no second harmonic.
    for k in 6..9 {
        inertia[k] += c.scale(h[0][k]) + s.scale(h[1][k]);
        derivative[k] = c.scale(h[1][k]) - s.scale(h[0][k]);
    }
    let turning = momentum_without_mass(&derivative, v);
    let f = &part.coupling;
    let rate2 = rate * rate;
    let mut coupling: Spatial<T> = [T::zero(); 6];
    for k in 0..6 {
        coupling[k] = T::from_f64(f[0][k]) + c.scale(f[1][k]) + s.scale(f[2][k]);
        let change = c.scale(f[2][k]) - s.scale(f[1][k]);
        bias[k] += turning[k] * rate + change * rate2;
    }
    (coupling, power(v, &turning).scale(-0.5))
}

impl Tree {
    /// Where things are.
    #[inline(always)]
    pub(super) fn pose<T: Scalar>(&self, x: &State<T>) -> Pose<T> {
        let rotation = super::vector::rotation(&x.attitude());
        let (s, c) = x[STEER].sin_cos();
        let (s1, c1) = x[TRUNK].sin_cos();
        let (s2, c2) = x[TRUNK + 1].sin_cos();
        let (s3, c3) = x[TRUNK + 2].sin_cos();
        let z = T::zero();
        let hub = &self.front_hub;
        let axle = &self.front_axle;
        let e1 = [c2, s1 * s2, -(c1 * s2)];
        let e2 = [z, c1, s1];
        Pose {
            rotation,
            steer: (s, c),
            front_hub: build(|k| T::from_f64(hub[0][k]) + c.scale(hub[1][k]) + s.scale(hub[2][k])),
            front_axle: build(|k| c.scale(axle[0][k]) + s.scale(axle[1][k])),
            pitch_axis: e2,
            twist_axis: [s2, -(s1 * c2), c1 * c2],
            trunk_x: axpy(scale(e1, c3), s3, e2),
            trunk_y: axpy(scale(e2, c3), -s3, e1),
        }
    }

    /// Factors the tree in state `x`.
    #[inline(always)]
    pub(super) fn factor<T: Scalar>(
        &self,
        x: &State<T>,
        pose: &Pose<T>,
        gravity_m_s2: f64,
    ) -> Factored<T> {
        let v = x.base_motion();
        let w = [v[0], v[1], v[2]];
        let mut inertia: Inertia<T> = lift(&self.base);
        let mut bias = Forces::zero();
        let b = &mut bias.wrench;
        let rates = [x[STEER_RATE], x[LEG_RATE], x[LEG_RATE + 1]];
        let (f0, t0) = hinge(&self.steer, pose.steer, rates[0], &v, &mut inertia, b);
        let (f1, t1) = hinge(
            &self.legs[0],
            x[LEGS].sin_cos(),
            rates[1],
            &v,
            &mut inertia,
            b,
        );
        let (f2, t2) = hinge(
            &self.legs[1],
            x[LEGS + 1].sin_cos(),
            rates[2],
            &v,
            &mut inertia,
            b,
        );
        let mut h = momentum(&inertia, &v);
        for k in 0..6 {
            h[k] += f0[k] * rates[0] + f1[k] * rates[1] + f2[k] * rates[2];
        }
        let carried = transported(&v, &h);
        for k in 0..6 {
            b[k] += carried[k];
        }
        bias.steer = t0;
        bias.legs = [t1, t2];

        // Spin momentum of the wheels: a gyroscope each.
        let rear = (w[1] - x[SPIN]).scale(self.wheels[0].spin_inertia);
        b[0] -= rear * w[2];
        b[2] += rear * w[0];
        let axle = pose.front_axle;
        let front = (dot(w, axle) - x[SPIN + 1]).scale(self.wheels[1].spin_inertia);
        let m = &self.steer.motion;
        let axis: Vec3<T> = lift(&[m[0], m[1], m[2]]);
        let axle_change = scale(cross(axis, axle), rates[0]);
        let gyro = scale(add(cross(w, axle), axle_change), front);
        for k in 0..3 {
            b[k] += gyro[k];
        }
        bias.steer += dot(axis, gyro);

        let trunk = self.trunk_part(x, pose, &v, &mut inertia, &mut bias);

        // The base block, joints eliminated. Order: angular, linear.
        let i = &inertia;
        let z = T::zero();
        let (hx, hy, hz, mass) = (i[6], i[7], i[8], i[9]);
        let mut a = [
            [i[0], z, z, z, z, z],
            [i[3], i[1], z, z, z, z],
            [i[4], i[5], i[2], z, z, z],
            [z, hz, -hy, mass, z, z],
            [-hz, z, hx, z, mass, z],
            [hy, -hx, z, z, z, mass],
        ];
        let couplings = [f0, f1, f2];
        let inverses = [
            self.steer.inverse_inertia,
            self.legs[0].inverse_inertia,
            self.legs[1].inverse_inertia,
        ];
        for (f, inverse) in couplings.iter().zip(inverses) {
            eliminate(&mut a, f, &scale(*f, T::from_f64(inverse)));
        }
        for (f, inverse) in trunk.0.iter().zip(trunk.1) {
            eliminate(&mut a, f, &scale(*f, inverse));
        }
        let inverse = factor_symmetric(&mut a);
        let g = T::from_f64(gravity_m_s2);
        Factored {
            couplings,
            inverses,
            trunk: trunk.0,
            trunk_inverse: trunk.1,
            trunk_lower: trunk.2,
            lower: a,
            inverse,
            bias,
            gravity: scale(pose.rotation[2], g),
            front_axle: axle,
            axle_rate: dot(w, axle_change),
        }
    }
}

/// Writes positions' rates and accelerations into the derivative of the state.
#[inline(always)]
pub(super) fn derivative<T: Scalar>(
    x: &State<T>,
    pose: &Pose<T>,
    a: &Accelerations<T>,
    dx: &mut State<T>,
) {
    let velocity = [x[15], x[16], x[17]];
    let position = super::vector::rows_times(&pose.rotation, velocity);
    dx[..3].copy_from_slice(&position);
    let [qw, qx, qy, qz] = x.attitude();
    let w = [
        x[ANGULAR].scale(0.5),
        x[ANGULAR + 1].scale(0.5),
        x[ANGULAR + 2].scale(0.5),
    ];
    dx[3] = -(qx * w[0] + qy * w[1] + qz * w[2]);
    dx[4] = qw * w[0] + qy * w[2] - qz * w[1];
    dx[5] = qw * w[1] + qz * w[0] - qx * w[2];
    dx[6] = qw * w[2] + qx * w[1] - qy * w[0];
    // Steer, trunk, legs, wheels.
    for k in 0..8 {
        dx[STEER + k] = x[STEER_RATE + k];
    }
    for k in 0..3 {
        dx[15 + k] = a.base[3 + k];
        dx[ANGULAR + k] = a.base[k];
        dx[TRUNK_RATE + k] = a.trunk[k];
    }
    dx[STEER_RATE] = a.steer;
    dx[LEG_RATE] = a.legs[0];
    dx[LEG_RATE + 1] = a.legs[1];
    dx[SPIN] = a.spin[0];
    dx[SPIN + 1] = a.spin[1];
}
