//! What: kinetic and potential energy of the multibody model.
//!
//! Equation: kinetic energy body by body; potential energy of gravity, springs, arms and tyre
//! deflection (½ K ρ²).
//!
//! Source: follows from the model's own definition; independent of the forward dynamics, so that
//! it can check them.
//!
//! Assumes and ignores: the energy of relaxed slip is not counted.
//!
//! Valid for: any state.
//!
//! Checked by: the tests of this file.

use super::contact::contact_points;
use super::inertia::{Inertia, Spatial, momentum, power};
use super::model::Multibody;
use super::state::{LEG_RATE, LEGS, SPIN, STEER, STEER_RATE, State, StateAccess, TRUNK};
use super::tree::Hinge;
use super::vector::{Vec3, add, cross, dot, lift};
use crate::Scalar;
use crate::road::Road;
use crate::tyre::TyreModel;

/// Energy of the model, J.
#[derive(Clone, Copy, Debug)]
pub struct Energy<T = f64> {
    /// Of motion.
    pub kinetic_j: T,
    /// Of gravity, zero at the height of the road.
    pub gravity_j: T,
    /// Of joint springs, arms and tyre deflection.
    pub springs_j: T,
}

impl<T: Scalar> Energy<T> {
    /// All of it.
    pub fn total_j(&self) -> T {
        self.kinetic_j + self.gravity_j + self.springs_j
    }
}

impl Multibody {
    /// Energy in state `x` on a level road.
    pub fn energy<T: Scalar>(&self, x: &State<T>) -> Energy<T> {
        self.energy_on(x, None)
    }

    /// Energy in state `x` on a road.
    pub fn energy_on<T: Scalar>(&self, x: &State<T>, road: Option<&Road>) -> Energy<T> {
        let pose = self.tree.pose(x);
        let v = x.base_motion();
        let w = [v[0], v[1], v[2]];
        let mut inertia: Inertia<T> = lift(&self.tree.base);
        let mut kinetic = T::zero();
        for (part, q, rate) in [
            (&self.tree.steer, x[STEER], x[STEER_RATE]),
            (&self.tree.legs[0], x[LEGS], x[LEG_RATE]),
            (&self.tree.legs[1], x[LEGS + 1], x[LEG_RATE + 1]),
        ] {
            let coupling = turned(part, q, &mut inertia);
            kinetic += rate * power(&v, &coupling) + (rate * rate).scale(0.5 * part.inertia);
        }
        kinetic += power(&v, &momentum(&inertia, &v)).scale(0.5);
        // Wheels: what spins.
        let spin = [w[1] - x[SPIN], dot(w, pose.front_axle) - x[SPIN + 1]];
        for k in 0..2 {
            kinetic += spin[k]
                .squared()
                .scale(0.5 * self.tree.wheels[k].spin_inertia);
        }
        // Trunk.
        let part = &self.tree.trunk;
        let total = super::joints::trunk_rate(x, &pose);
        let local = [
            dot(pose.trunk_x, total),
            dot(pose.trunk_y, total),
            dot(pose.twist_axis, total),
        ];
        let [jx, jy, jz, jxz] = part.tensor;
        let rotational = local[0].squared().scale(jx)
            + local[1].squared().scale(jy)
            + local[2].squared().scale(jz)
            + (local[0] * local[2]).scale(2.0 * jxz);
        let joint: Vec3<T> = lift(&part.joint);
        let at_joint = add([v[3], v[4], v[5]], cross(w, joint));
        let first: Vec3<T> = core::array::from_fn(|k| {
            pose.trunk_x[k].scale(part.first[0]) + pose.twist_axis[k].scale(part.first[1])
        });
        kinetic += rotational.scale(0.5)
            + dot(at_joint, cross(total, first))
            + dot(at_joint, at_joint).scale(0.5 * part.mass);

        let moment: Vec3<T> =
            core::array::from_fn(|k| inertia[6 + k] + first[k] + joint[k].scale(part.mass));
        let mass = inertia[9] + T::from_f64(part.mass);
        let height = dot(pose.rotation[2], moment) + mass * x[2];
        let mut springs = T::zero();
        for (k, q) in [STEER, TRUNK, TRUNK + 1, TRUNK + 2, LEGS, LEGS + 1]
            .into_iter()
            .enumerate()
        {
            let [stiffness, _, preload] = self.springs.joints[k];
            springs += x[q].squared().scale(0.5 * stiffness) - x[q].scale(preload);
        }
        if let Some(arms) = &self.springs.arms {
            for k in 0..2 {
                let line = arms.line(k, &self.tree, x, &pose);
                springs += line.stretch.squared().scale(0.5 * arms.stiffness);
            }
        }
        if !self.no_slip {
            let points = contact_points(&self.tree, x, &pose, &self.grounds(x, &pose, road), false);
            for k in 0..2 {
                let deflection = T::from_f64(self.tree.wheels[k].radius) - points[k].loaded_radius;
                let stiffness = self.tyres[k].vertical().stiffness_n_m;
                springs += deflection.max(T::zero()).squared().scale(0.5 * stiffness);
            }
        }
        Energy {
            kinetic_j: kinetic,
            gravity_j: height.scale(-self.parameters.gravity_m_s2),
            springs_j: springs,
        }
    }
}

/// Adds the turned body to `inertia`; gives its momentum per unit rate.
pub(super) fn turned<T: Scalar>(part: &Hinge, q: T, inertia: &mut Inertia<T>) -> Spatial<T> {
    let (s, c) = q.sin_cos();
    let (s2, c2) = q.scale(2.0).sin_cos();
    let h = &part.harmonics;
    for k in 0..9 {
        inertia[k] += c.scale(h[0][k]) + s.scale(h[1][k]) + c2.scale(h[2][k]) + s2.scale(h[3][k]);
    }
    let f = &part.coupling;
    core::array::from_fn(|k| T::from_f64(f[0][k]) + c.scale(f[1][k]) + s.scale(f[2][k]))
}

#[cfg(test)]
mod tests {
    use super::super::sets::frictionless_full;
    use super::*;
    use crate::integrate::rk4;
    use crate::multibody::Input;

    /// A state with every joint displaced and moving.
    pub(super) fn tumbling(model: &Multibody) -> State {
        let mut x: State = model.upright(2.0);
        x.set_attitude_rad(0.3, 0.4, -0.2);
        x[2] = -30.0;
        for (k, v) in [0.2, 0.15, -0.1, 0.25, 0.1, -0.2].into_iter().enumerate() {
            x[STEER + k] = v;
        }
        for (k, v) in [0.5, -0.7, 0.4, 1.1, 0.6, -0.9, 0.8, 1.2, -1.0]
            .into_iter()
            .enumerate()
        {
            x[16 + k] = v;
        }
        x
    }

    #[test]
    fn accelerations_balance_energy() {
        let model = Multibody::new(&frictionless_full()).unwrap();
        let mut x = tumbling(&model);
        let start = model.energy(&x).total_j();
        let kinetic = model.energy(&x).kinetic_j;
        for _ in 0..20_000 {
            rk4(&mut x, 1.0e-4, |x, dx| {
                model.rhs(x, &Input::default(), None, dx)
            });
        }
        let drift = (model.energy(&x).total_j() - start).abs() / kinetic;
        assert!(x[2] > -15.0, "it falls freely");
        assert!(drift < 1.0e-9, "drift {drift:e}");
    }

    #[test]
    fn bouncing_on_frictionless_tyres_keeps_energy() {
        let model = Multibody::new(&frictionless_full()).unwrap();
        let mut x: State = model.upright(3.0);
        x.set_attitude_rad(0.0, 0.1, 0.02);
        x[2] -= 0.01;
        x[STEER] = 0.1;
        let start = model.energy(&x).total_j();
        let mut loaded = false;
        for _ in 0..8_000 {
            rk4(&mut x, 5.0e-5, |x, dx| {
                model.rhs(x, &Input::default(), None, dx)
            });
            loaded |= model.energy(&x).springs_j > 1.0;
        }
        assert!(loaded, "the tyres carried load");
        let drift = (model.energy(&x).total_j() - start).abs() / start.abs();
        assert!(drift < 1.0e-6, "drift {drift:e}");
    }
}
