//! What: the tree in one state, factored: accelerations under any forces.
//!
//! Equation: joints are eliminated into the 6 × 6 base block, A = I - Σ F Fᵀ / D, factored as
//! L D Lᵀ; then back substitution.
//!
//! Source: Featherstone (2008), Rigid Body Dynamics Algorithms, section 8.4 (L D Lᵀ and branches).
//!
//! Assumes and ignores: no pivoting: the block is positive definite as long as masses are.
//!
//! Valid for: any attitude.
//!
//! Checked by: the energy balance in `energy`, equality with the benchmark.

use super::dynamics::{Accelerations, Forces};
use super::inertia::{Spatial, power};
use super::tree::Tree;
use super::vector::{Vec3, build};
use crate::Scalar;

/// The tree in one state, factored: solves for accelerations under any forces.
#[derive(Clone, Debug)]
pub(super) struct Factored<T> {
    pub(super) couplings: [Spatial<T>; 3],
    pub(super) inverses: [f64; 3],
    /// Columns of the trunk, decoupled from each other.
    pub(super) trunk: [Spatial<T>; 3],
    pub(super) trunk_inverse: [T; 3],
    /// Entries 10, 20, 21 of the unit lower factor of the trunk's block.
    pub(super) trunk_lower: [T; 3],
    pub(super) lower: [[T; 6]; 6],
    pub(super) inverse: [T; 6],
    pub(super) bias: Forces<T>,
    /// Gravity in base axes.
    pub(super) gravity: Vec3<T>,
    pub(super) front_axle: Vec3<T>,
    /// ω · d(axle)/dt of the front wheel.
    pub(super) axle_rate: T,
}

/// Subtracts f gᵀ from the lower triangle.
#[inline(always)]
pub(super) fn eliminate<T: Scalar>(a: &mut [[T; 6]; 6], f: &Spatial<T>, g: &Spatial<T>) {
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
            let known = b[c];
            b[r] -= lower[r][c] * known;
        }
    }
    for r in 0..N {
        b[r] = b[r] * inverse[r];
    }
    for r in (0..N).rev() {
        for c in r + 1..N {
            let known = b[c];
            b[r] -= lower[c][r] * known;
        }
    }
}

impl<T: Scalar> Factored<T> {
    /// Accelerations under `forces`, gravity and velocity products.
    #[inline(always)]
    pub(super) fn accelerations(&self, tree: &Tree, forces: &Forces<T>) -> Accelerations<T> {
        let bias = &self.bias;
        let net = Forces {
            wrench: build(|k| forces.wrench[k] - bias.wrench[k]),
            steer: forces.steer - bias.steer,
            trunk: build(|k| forces.trunk[k] - bias.trunk[k]),
            legs: build(|k| forces.legs[k] - bias.legs[k]),
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
        let hinge_rate: [T; 3] =
            build(|j| (hinge_torque[j] - power(&self.couplings[j], &base)).scale(self.inverses[j]));
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
            steer: hinge_rate[0],
            trunk: [t0, t1, t2],
            legs: [hinge_rate[1], hinge_rate[2]],
            spin: [
                (net.spin[0].scale(tree.wheels[0].inverse_inertia)) + base[1].scale(free[0]),
                (net.spin[1].scale(tree.wheels[1].inverse_inertia)) + about_axle.scale(free[1]),
            ],
        }
    }
}
