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

use super::inertia::{Inertia, Spatial, momentum, power, tensor_times, transported};
use super::state::{
    ANGULAR, LEG_RATE, LEGS, SPIN, STEER, STEER_RATE, State, StateAccess, TRUNK, TRUNK_RATE,
};
use super::tree::{Hinge, Tree};
use super::vector::{Vec3, add, axpy, cross, dot, lift, scale};
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

/// The tree in one state, factored: solves for accelerations under any forces.
#[derive(Clone, Debug)]
pub(super) struct Factored<T> {
    couplings: [Spatial<T>; 3],
    inverses: [f64; 3],
    /// Columns of the trunk, decoupled from each other.
    trunk: [Spatial<T>; 3],
    trunk_inverse: [T; 3],
    /// Entries 10, 20, 21 of the unit lower factor of the trunk's block.
    trunk_lower: [T; 3],
    lower: [[T; 6]; 6],
    inverse: [T; 6],
    bias: Forces<T>,
    /// Gravity in base axes.
    gravity: Vec3<T>,
    front_axle: Vec3<T>,
    /// ω · d(axle)/dt of the front wheel.
    axle_rate: T,
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
    for k in 0..9 {
        inertia[k] += c.scale(h[0][k]) + s.scale(h[1][k]) + (c2.scale(h[2][k]) + s2.scale(h[3][k]));
        derivative[k] =
            c.scale(h[1][k]) - s.scale(h[0][k]) + (c2x.scale(h[3][k]) - s2x.scale(h[2][k]));
    }
    let turning = momentum(&derivative, v);
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
            front_hub: core::array::from_fn(|k| {
                T::from_f64(hub[0][k]) + c.scale(hub[1][k]) + s.scale(hub[2][k])
            }),
            front_axle: core::array::from_fn(|k| c.scale(axle[0][k]) + s.scale(axle[1][k])),
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

    /// Adds the trunk to inertia and bias; gives decoupled columns, inverse pivots and factor.
    #[inline(always)]
    #[allow(clippy::type_complexity)]
    fn trunk_part<T: Scalar>(
        &self,
        x: &State<T>,
        pose: &Pose<T>,
        v: &Spatial<T>,
        inertia: &mut Inertia<T>,
        bias: &mut Forces<T>,
    ) -> ([Spatial<T>; 3], [T; 3], [T; 3]) {
        let part = &self.trunk;
        let (tx, ty, tz) = (pose.trunk_x, pose.trunk_y, pose.twist_axis);
        let [jx, jy, jz, jxz] = part.tensor;
        let first: Vec3<T> =
            core::array::from_fn(|k| tx[k].scale(part.first[0]) + tz[k].scale(part.first[1]));
        let gx: Vec3<T> = core::array::from_fn(|k| tx[k].scale(jx) + tz[k].scale(jxz));
        let gy: Vec3<T> = core::array::from_fn(|k| ty[k].scale(jy));
        let gz: Vec3<T> = core::array::from_fn(|k| tx[k].scale(jxz) + tz[k].scale(jz));
        let entry = |a: usize, b: usize| gx[a] * tx[b] + gy[a] * ty[b] + gz[a] * tz[b];
        let zero = T::zero();
        // Tensor about the joint, base axes.
        let tensor: Inertia<T> = [
            entry(0, 0),
            entry(1, 1),
            entry(2, 2),
            entry(0, 1),
            entry(0, 2),
            entry(1, 2),
            zero,
            zero,
            zero,
            zero,
        ];
        let joint: Vec3<T> = lift(&part.joint);
        let m = T::from_f64(part.mass);

        // Newton-Euler about the joint with all accelerations zero but the velocity products.
        let (w, u) = ([v[0], v[1], v[2]], [v[3], v[4], v[5]]);
        let rate = [x[TRUNK_RATE], x[TRUNK_RATE + 1], x[TRUNK_RATE + 2]];
        let (a2, a3) = (pose.pitch_axis, tz);
        // Relative angular velocity and its rate at constant joint rates: lean axis is x.
        let pitch = scale(a2, rate[1]);
        let lean_pitch = [rate[0], pitch[1], pitch[2]];
        let relative = axpy(lean_pitch, rate[2], a3);
        let mut turning = scale(cross(lean_pitch, a3), rate[2]);
        turning[1] -= rate[0] * pitch[2];
        turning[2] += rate[0] * pitch[1];
        let total = add(w, relative);
        let alpha = add(cross(w, relative), turning);
        let at_joint = add(u, cross(w, joint));
        let linear = cross(w, at_joint);
        let force = add(
            axpy(cross(total, cross(total, first)), m, linear),
            cross(alpha, first),
        );
        let moment = add(
            add(
                tensor_times(&tensor, alpha),
                cross(total, tensor_times(&tensor, total)),
            ),
            cross(first, linear),
        );
        let about_origin = add(moment, cross(joint, force));
        for k in 0..3 {
            bias.wrench[k] += about_origin[k];
            bias.wrench[3 + k] += force[k];
        }
        bias.trunk = [moment[0], dot(a2, moment), dot(a3, moment)];

        // Couplings: momentum per unit joint rate.
        let free = part.free;
        let column = |axis: Vec3<T>, j: Vec3<T>, free: f64| -> Spatial<T> {
            let p = cross(axis, first);
            let l = add(j, cross(joint, p));
            [l[0], l[1], l[2], p[0], p[1], p[2]].map(|c| c.scale(free))
        };
        let e1 = [T::one(), zero, zero];
        let j1 = [tensor[0], tensor[3], tensor[4]];
        let (j2, j3) = (tensor_times(&tensor, a2), tensor_times(&tensor, a3));
        let f1 = column(e1, j1, free[0]);
        let f2 = column(a2, j2, free[1]);
        let f3 = column(a3, j3, free[2]);
        let locked = |k: usize| T::from_f64(1.0 - free[k]);
        let d11 = tensor[0].scale(free[0]) + locked(0);
        let d21 = j2[0].scale(free[1] * free[0]);
        let d31 = j3[0].scale(free[2] * free[0]);
        let d22 = dot(a2, j2).scale(free[1]) + locked(1);
        let d32 = dot(a2, j3).scale(free[2] * free[1]);
        let d33 = dot(a3, j3).scale(free[2]) + locked(2);
        // A massless locked trunk leaves its pivots at one.
        let i1 = T::one() / d11;
        let l21 = d21 * i1;
        let l31 = d31 * i1;
        let i2 = T::one() / (d22 - l21 * d21);
        let l32 = (d32 - l31 * d21) * i2;
        let i3 = T::one() / (d33 - l31 * d31 - l32 * (d32 - l31 * d21));
        let g2 = axpy(f2, -l21, f1);
        let g3 = axpy(axpy(f3, -l31, f1), -l32, g2);

        // The trunk as part of everything.
        let hj = dot(joint, first);
        let mjj = dot(joint, joint) * m + hj.scale(2.0);
        // About the origin: J + (2 h·L + m L²) 1 - (h Lᵀ + L hᵀ + m L Lᵀ).
        let cross_term =
            |a: usize, b: usize| first[a] * joint[b] + joint[a] * (first[b] + m * joint[b]);
        inertia[0] += tensor[0] + mjj - cross_term(0, 0);
        inertia[1] += tensor[1] + mjj - cross_term(1, 1);
        inertia[2] += tensor[2] + mjj - cross_term(2, 2);
        inertia[3] += tensor[3] - cross_term(0, 1);
        inertia[4] += tensor[4] - cross_term(0, 2);
        inertia[5] += tensor[5] - cross_term(1, 2);
        for k in 0..3 {
            inertia[6 + k] += first[k] + m * joint[k];
        }
        inertia[9] += m;
        ([f1, g2, g3], [i1, i2, i3], [l21, l31, l32])
    }
}

/// Subtracts f gᵀ from the lower triangle.
#[inline(always)]
fn eliminate<T: Scalar>(a: &mut [[T; 6]; 6], f: &Spatial<T>, g: &Spatial<T>) {
    for r in 0..6 {
        for c in 0..=r {
            a[r][c] -= f[r] * g[c];
        }
    }
}

/// Overwrites the lower triangle of a symmetric positive matrix with the unit lower factor; gives
/// the inverse pivots.
#[inline(always)]
pub(super) fn factor_symmetric<T: Scalar, const N: usize>(a: &mut [[T; N]; N]) -> [T; N] {
    let mut inverse = [T::zero(); N];
    for j in 0..N {
        let mut row = [T::zero(); N];
        let mut pivot = a[j][j];
        for k in 0..j {
            row[k] = a[j][k];
            // Rows above hold L; this one still holds L D.
            let l = a[j][k] * inverse[k];
            pivot -= l * row[k];
            a[j][k] = l;
        }
        let inv = T::one() / pivot;
        inverse[j] = inv;
        for r in j + 1..N {
            let mut entry = a[r][j];
            for k in 0..j {
                entry -= a[r][k] * a[j][k];
            }
            a[r][j] = entry;
        }
    }
    inverse
}

/// Solves with the factor of `factor_symmetric`.
#[inline(always)]
pub(super) fn solve_symmetric<T: Scalar, const N: usize>(
    lower: &[[T; N]; N],
    inverse: &[T; N],
    b: &mut [T; N],
) {
    for r in 1..N {
        for c in 0..r {
            b[r] = b[r] - lower[r][c] * b[c];
        }
    }
    for r in 0..N {
        b[r] = b[r] * inverse[r];
    }
    for r in (0..N).rev() {
        for c in r + 1..N {
            b[r] = b[r] - lower[c][r] * b[c];
        }
    }
}

impl<T: Scalar> Factored<T> {
    /// Accelerations under `forces`, gravity and velocity products.
    #[inline(always)]
    pub(super) fn accelerations(&self, tree: &Tree, forces: &Forces<T>) -> Accelerations<T> {
        let bias = &self.bias;
        let net = Forces {
            wrench: core::array::from_fn(|k| forces.wrench[k] - bias.wrench[k]),
            steer: forces.steer - bias.steer,
            trunk: core::array::from_fn(|k| forces.trunk[k] - bias.trunk[k]),
            legs: core::array::from_fn(|k| forces.legs[k] - bias.legs[k]),
            spin: forces.spin,
        };
        let mut a = self.response(tree, &net);
        // Gravity is an acceleration of the base.
        for k in 0..3 {
            a.base[3 + k] += self.gravity[k];
        }
        a.spin[1] += self.axle_rate.scale(self.front_free(tree));
        a
    }

    #[inline(always)]
    fn front_free(&self, tree: &Tree) -> f64 {
        if tree.wheels[1].spin_inertia > 0.0 {
            1.0
        } else {
            0.0
        }
    }

    /// What forces alone do: M⁻¹ times the forces.
    #[inline(always)]
    pub(super) fn response(&self, tree: &Tree, net: &Forces<T>) -> Accelerations<T> {
        let mut base = net.wrench;
        // The wheel takes what spins it; the rest of the tree feels the reaction.
        let free = tree
            .wheels
            .each_ref()
            .map(|w| if w.spin_inertia > 0.0 { 1.0 } else { 0.0 });
        base[1] += net.spin[0].scale(free[0]);
        let front = net.spin[1].scale(free[1]);
        for k in 0..3 {
            base[k] += front * self.front_axle[k];
        }
        let hinge_torque = [net.steer, net.legs[0], net.legs[1]];
        for j in 0..3 {
            let scaled = hinge_torque[j].scale(self.inverses[j]);
            for k in 0..6 {
                base[k] -= self.couplings[j][k] * scaled;
            }
        }
        let free_trunk = tree.trunk.free;
        let y0 = net.trunk[0].scale(free_trunk[0]);
        let y1 = net.trunk[1].scale(free_trunk[1]) - self.trunk_lower[0] * y0;
        let y2 =
            net.trunk[2].scale(free_trunk[2]) - self.trunk_lower[1] * y0 - self.trunk_lower[2] * y1;
        let z = [
            y0 * self.trunk_inverse[0],
            y1 * self.trunk_inverse[1],
            y2 * self.trunk_inverse[2],
        ];
        for j in 0..3 {
            for k in 0..6 {
                base[k] -= self.trunk[j][k] * z[j];
            }
        }
        solve_symmetric(&self.lower, &self.inverse, &mut base);
        let hinge_rate =
            |j: usize| (hinge_torque[j] - power(&self.couplings[j], &base)).scale(self.inverses[j]);
        let t2 = z[2] - power(&self.trunk[2], &base) * self.trunk_inverse[2];
        let t1 =
            z[1] - power(&self.trunk[1], &base) * self.trunk_inverse[1] - self.trunk_lower[2] * t2;
        let t0 = z[0]
            - power(&self.trunk[0], &base) * self.trunk_inverse[0]
            - self.trunk_lower[0] * t1
            - self.trunk_lower[1] * t2;
        let about_axle = base[0] * self.front_axle[0]
            + base[1] * self.front_axle[1]
            + base[2] * self.front_axle[2];
        Accelerations {
            base,
            steer: hinge_rate(0),
            trunk: [t0, t1, t2],
            legs: [hinge_rate(1), hinge_rate(2)],
            spin: [
                (net.spin[0].scale(tree.wheels[0].inverse_inertia)) + base[1].scale(free[0]),
                (net.spin[1].scale(tree.wheels[1].inverse_inertia)) + about_axle.scale(free[1]),
            ],
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
