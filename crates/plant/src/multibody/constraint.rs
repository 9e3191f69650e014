//! What: wheels that roll without slip, held by constraint forces.
//!
//! Equation: the velocity c = J u of the material point of each wheel at its contact vanishes
//! along, across and normal to the road. With M u' = f + Jᵀ λ and J u' + J' u = 0,
//! λ = -(J M⁻¹ Jᵀ)⁻¹ (J M⁻¹ f + J' u). J' u is the derivative of c along the motion, exact by dual
//! numbers. Drift is removed by projection: heights by Newton, velocities by
//! u - M⁻¹ Jᵀ (J M⁻¹ Jᵀ)⁻¹ c, the nearest in kinetic energy.
//!
//! Source: Meijaard et al. (2007), section 2 (the constraints); Featherstone (2008), section 3.2.
//!
//! Assumes and ignores: knife-edge rigid wheels on a plane road, unlimited friction, wheels that
//! never lift: the sign of the load is not checked here (`Truth` shows it).
//!
//! Valid for: roll below 75°.
//!
//! Checked by: `linearise` (the benchmark's state matrix to 1e-9), `energy` (1e-6 over 60 s).

use super::contact::{ContactPoint, Ground, contact_points};
use super::dynamics::{Accelerations, Forces, Pose, derivative};
use super::factored::{Factored, factor_symmetric, solve_symmetric};
use super::inertia::{Spatial, power};
use super::model::Multibody;
use super::state::{ANGULAR, ATTITUDE, SLIP, SPIN, STEER_RATE, State, StateAccess, VELOCITY};
use super::tree::Tree;
use super::vector::{cross, dot, lift};
use crate::Scalar;
use crate::dual::Dual;

/// Contact velocities: along, across, normal; rear, then front.
pub(super) fn contact_rates<T: Scalar>(
    tree: &Tree,
    x: &State<T>,
    points: &[ContactPoint<T>; 2],
) -> [T; 6] {
    core::array::from_fn(|k| {
        let (wheel, p) = (k / 3, &points[k / 3]);
        match k % 3 {
            0 => dot(p.velocity, p.forward) - x[SPIN + wheel].scale(tree.wheels[wheel].radius),
            1 => dot(p.velocity, p.right),
            _ => dot(p.velocity, p.down),
        }
    })
}

/// What unit contact forces do to the tree: the rows of J.
pub(super) fn unit_forces<T: Scalar>(tree: &Tree, points: &[ContactPoint<T>; 2]) -> [Forces<T>; 6] {
    core::array::from_fn(|k| {
        let (wheel, p) = (k / 3, &points[k / 3]);
        let e = [p.forward, p.right, p.down][k % 3];
        let turn = cross(p.arm, e);
        let mut f = Forces::zero();
        f.wrench = [turn[0], turn[1], turn[2], e[0], e[1], e[2]];
        if wheel == 1 {
            f.steer = power(&lift(&tree.steer.motion), &f.wrench);
        }
        if k % 3 == 0 {
            f.spin[wheel] = T::from_f64(-tree.wheels[wheel].radius);
        }
        f
    })
}

/// Row of J times accelerations (or velocities).
pub(super) fn along<T: Scalar>(row: &Forces<T>, base: &Spatial<T>, steer: T, spin: [T; 2]) -> T {
    power(&row.wrench, base) + row.steer * steer + row.spin[0] * spin[0] + row.spin[1] * spin[1]
}

/// The constraints in one state, factored.
pub(super) struct Constraint<T> {
    rows: [Forces<T>; 6],
    responses: [Accelerations<T>; 6],
    lower: [[T; 6]; 6],
    inverse: [T; 6],
}

impl<T: Scalar> Constraint<T> {
    pub(super) fn new(tree: &Tree, points: &[ContactPoint<T>; 2], factored: &Factored<T>) -> Self {
        let rows = unit_forces(tree, points);
        let responses = rows.each_ref().map(|row| factored.response(tree, row));
        let mut lower = [[T::zero(); 6]; 6];
        for (r, line) in lower.iter_mut().enumerate() {
            for (c, entry) in line.iter_mut().enumerate().take(r + 1) {
                let a = &responses[c];
                *entry = along(&rows[r], &a.base, a.steer, a.spin);
            }
        }
        let inverse = factor_symmetric(&mut lower);
        Self {
            rows,
            responses,
            lower,
            inverse,
        }
    }

    /// Multipliers that give the contact the rates `wanted`.
    fn multipliers(&self, mut wanted: [T; 6]) -> [T; 6] {
        solve_symmetric(&self.lower, &self.inverse, &mut wanted);
        wanted
    }

    /// Adds what contact forces `lambda` do.
    fn add(&self, a: &mut Accelerations<T>, lambda: &[T; 6]) {
        for (response, l) in self.responses.iter().zip(lambda) {
            for k in 0..6 {
                a.base[k] += response.base[k] * *l;
            }
            a.steer += response.steer * *l;
            for k in 0..3 {
                a.trunk[k] += response.trunk[k] * *l;
            }
            for k in 0..2 {
                a.legs[k] += response.legs[k] * *l;
                a.spin[k] += response.spin[k] * *l;
            }
        }
    }
}

impl Multibody {
    /// Derivative without slip; gives the contact forces (along, across, down; rear, front).
    pub(super) fn rhs_no_slip<T: Scalar>(
        &self,
        x: &State<T>,
        pose: &Pose<T>,
        forces: &Forces<T>,
        grounds: &[Ground<T>; 2],
        dx: &mut State<T>,
    ) -> [T; 6] {
        let factored = self.tree.factor(x, pose, self.parameters.gravity_m_s2);
        let mut a = factored.accelerations(&self.tree, forces);
        let points = contact_points(&self.tree, x, pose, grounds, true);
        let constraint = Constraint::new(&self.tree, &points, &factored);
        let bias = self.constraint_bias(x, pose, grounds);
        let wanted = core::array::from_fn(|k| {
            -(bias[k] + along(&constraint.rows[k], &a.base, a.steer, a.spin))
        });
        let lambda = constraint.multipliers(wanted);
        constraint.add(&mut a, &lambda);
        derivative(x, pose, &a, dx);
        // Nothing slips.
        dx[SLIP..SLIP + 4].fill(T::zero());
        lambda
    }

    /// J' u: the rate of the contact velocities at constant quasi-velocities.
    fn constraint_bias<T: Scalar>(
        &self,
        x: &State<T>,
        pose: &Pose<T>,
        grounds: &[Ground<T>; 2],
    ) -> [T; 6] {
        let z = T::zero();
        let still = Accelerations {
            base: [z; 6],
            steer: z,
            trunk: [z; 3],
            legs: [z; 2],
            spin: [z; 2],
        };
        let mut rate = [z; super::STATES];
        derivative(x, pose, &still, &mut rate);
        let moving: State<Dual<1, T>> = core::array::from_fn(|k| Dual {
            re: x[k],
            eps: [rate[k]],
        });
        let lifted = grounds.map(|g| Ground {
            point: g.point.map(Dual::constant),
            normal: g.normal.map(Dual::constant),
            friction: Dual::constant(g.friction),
            level: g.level,
        });
        let pose = self.tree.pose(&moving);
        let points = contact_points(&self.tree, &moving, &pose, &lifted, true);
        contact_rates(&self.tree, &moving, &points).map(|c| c.eps[0])
    }

    /// Moves height and pitch so that both rigid wheels touch the road. Newton's method, `steps`
    /// times; with dual numbers one step more than for values makes derivatives exact.
    pub(super) fn touch_down<T: Scalar>(&self, x: &mut State<T>, steps: usize) {
        for _ in 0..steps {
            let pose = self.tree.pose(x);
            let grounds = self.grounds(x, &pose, None);
            let points = contact_points(&self.tree, x, &pose, &grounds, true);
            // Depth of each contact below the road, and its change with height and pitch.
            let row = |k: usize| {
                let (p, g) = (&points[k], &grounds[k]);
                let at = super::vector::rows_times(&pose.rotation, p.arm);
                let from: [T; 3] = core::array::from_fn(|i| x[i] + at[i] - g.point[i]);
                let depth = dot(from, g.normal);
                let pitch = dot(cross([T::zero(), T::one(), T::zero()], p.arm), p.down);
                (depth, g.normal[2], pitch)
            };
            let ((d0, z0, p0), (d1, z1, p1)) = (row(0), row(1));
            let determinant = z0 * p1 - z1 * p0;
            let height = (p0 * d1 - p1 * d0) / determinant;
            let angle = (z1 * d0 - z0 * d1) / determinant;
            x[2] += height;
            // Turn about the base's lateral axis.
            let [w, qx, qy, qz] = x.attitude();
            let (s, c) = angle.scale(0.5).sin_cos();
            let turned = [
                w * c - qy * s,
                qx * c - qz * s,
                w * s + qy * c,
                qz * c + qx * s,
            ];
            x[ATTITUDE..ATTITUDE + 4].copy_from_slice(&turned);
        }
    }

    /// Moves a state onto the constraints: wheels on the road, contacts without slip. On tyres it
    /// only brings the quaternion back to unit length.
    #[inline(always)]
    pub fn project<T: Scalar>(&self, x: &mut State<T>) {
        let q = x.attitude();
        let n = T::one() / (q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]).sqrt();
        for k in 0..4 {
            x[ATTITUDE + k] = q[k] * n;
        }
        if self.no_slip {
            self.constrain(x);
        }
    }

    /// Onto the constraints of wheels without slip.
    #[inline(never)]
    fn constrain<T: Scalar>(&self, x: &mut State<T>) {
        self.touch_down(x, 2);
        let pose = self.tree.pose(x);
        let grounds = self.grounds(x, &pose, None);
        let factored = self.tree.factor(x, &pose, self.parameters.gravity_m_s2);
        let points = contact_points(&self.tree, x, &pose, &grounds, true);
        let constraint = Constraint::new(&self.tree, &points, &factored);
        let slip = contact_rates(&self.tree, x, &points);
        let lambda = constraint.multipliers(slip.map(|c| -c));
        let z = T::zero();
        let mut change = Accelerations {
            base: [z; 6],
            steer: z,
            trunk: [z; 3],
            legs: [z; 2],
            spin: [z; 2],
        };
        constraint.add(&mut change, &lambda);
        for k in 0..3 {
            x[ANGULAR + k] += change.base[k];
            x[VELOCITY + k] += change.base[3 + k];
            x[STEER_RATE + 1 + k] += change.trunk[k];
        }
        x[STEER_RATE] += change.steer;
        for k in 0..2 {
            x[STEER_RATE + 4 + k] += change.legs[k];
            x[SPIN + k] += change.spin[k];
        }
    }

    /// Contact velocities (along, across, normal; rear, front), m/s: zero without slip.
    pub fn contact_velocities_m_s<T: Scalar>(&self, x: &State<T>) -> [T; 6] {
        let pose = self.tree.pose(x);
        let points = contact_points(
            &self.tree,
            x,
            &pose,
            &self.grounds(x, &pose, None),
            self.no_slip,
        );
        contact_rates(&self.tree, x, &points)
    }
}
