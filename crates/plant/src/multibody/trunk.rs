//! What: the trunk on its spherical joint, by Newton-Euler about the joint.
//!
//! Equation: with h the first moment and J the tensor about the joint, α the angular acceleration
//! and a that of the joint, force = m a + α × h + ω × (ω × h), moment = J α + ω × J ω + h × a. The
//! three joint angles (lean about x, then pitch, then twist) have a 3 × 3 block of inertia, factored
//! as L D Lᵀ; a locked angle has a unit pivot and no coupling.
//!
//! Source: Featherstone (2008), Rigid Body Dynamics Algorithms, chapter 2.
//!
//! Assumes and ignores: a rigid trunk.
//!
//! Valid for: trunk pitch below 90°.
//!
//! Checked by: the energy balance in `energy`.

use super::dynamics::{Forces, Pose};
use super::inertia::{Inertia, Spatial, tensor_times};
use super::state::{State, TRUNK_RATE};
use super::tree::Tree;
use super::vector::{Vec3, add, axpy, build, cross, dot, lift, scale};
use crate::Scalar;

/// Decoupled columns of the trunk, inverse pivots, and entries 10, 20, 21 of the unit lower factor.
pub(super) type TrunkBlock<T> = ([Spatial<T>; 3], [T; 3], [T; 3]);

impl Tree {
    /// Adds the trunk to inertia and bias; gives decoupled columns, inverse pivots and factor.
    #[inline(always)]
    pub(super) fn trunk_part<T: Scalar>(
        &self,
        x: &State<T>,
        pose: &Pose<T>,
        v: &Spatial<T>,
        inertia: &mut Inertia<T>,
        bias: &mut Forces<T>,
    ) -> TrunkBlock<T> {
        let part = &self.trunk;
        let (tx, ty, tz) = (pose.trunk_x, pose.trunk_y, pose.twist_axis);
        let [jx, jy, jz, jxz] = part.tensor;
        let first: Vec3<T> = build(|k| tx[k].scale(part.first[0]) + tz[k].scale(part.first[1]));
        let gx: Vec3<T> = build(|k| tx[k].scale(jx) + tz[k].scale(jxz));
        let gy: Vec3<T> = build(|k| ty[k].scale(jy));
        let gz: Vec3<T> = build(|k| tx[k].scale(jxz) + tz[k].scale(jz));
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
        let e1 = [T::one(), zero, zero];
        let j1 = [tensor[0], tensor[3], tensor[4]];
        let (j2, j3) = (tensor_times(&tensor, a2), tensor_times(&tensor, a3));
        let f1 = column(e1, j1, first, joint, free[0]);
        let f2 = column(a2, j2, first, joint, free[1]);
        let f3 = column(a3, j3, first, joint, free[2]);
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

/// Momentum about the base origin per unit rate about `axis`; `j` is tensor times axis.
#[inline(always)]
fn column<T: Scalar>(
    axis: Vec3<T>,
    j: Vec3<T>,
    first: Vec3<T>,
    joint: Vec3<T>,
    free: f64,
) -> Spatial<T> {
    let p = cross(axis, first);
    let l = add(j, cross(joint, p));
    [
        l[0].scale(free),
        l[1].scale(free),
        l[2].scale(free),
        p[0].scale(free),
        p[1].scale(free),
        p[2].scale(free),
    ]
}
