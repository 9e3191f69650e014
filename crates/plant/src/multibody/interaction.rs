//! What: the forces between rider and bicycle.
//!
//! Equation: what the road does not do to the rider, the bicycle does: force on the rider =
//! dp/dt - m g, moment on the rider = dL/dt - moment of m g, both about the saddle; on the bicycle
//! with the opposite sign. p and L are the momenta of the rider's bodies (pelvis, trunk, forearms,
//! legs); their rates come from the model's accelerations by dual numbers, exactly.
//!
//! Source: Bulsink (2017), chapter 5 (forces between rider and bicycle at saddle, handlebar and
//! pedals; the sum is what section 5.2.3 balances against weight and motion); own formulation.
//!
//! Assumes and ignores: the sum alone follows from the motion; how saddle, bar and pedals share it
//! is known only as far as the model has springs (arms) or a pedal stroke (`pedalling`). Wind acts
//! on the frame. After a fall the ground's force on rider and frame is counted as the rider's.
//!
//! Valid for: any state.
//!
//! Checked by: the tests of this file: weight at rest, momentum of the whole model against gravity
//! and the contact forces (1e-9), two-sidedness of the arms.

use super::energy::turned;
use super::inertia::{Inertia, Spatial, momentum, power};
use super::joints::trunk_rate;
use super::model::{Input, Multibody};
use super::parameters::{Body, Parameters, Wheel};
use super::ride::Ride;
use super::state::{LEG_RATE, LEGS, STATES, STEER, STEER_RATE, State, StateAccess};
use super::tree::Tree;
use super::vector::{Vec3, add, columns_times, cross, dot, lift, rows_times, scale, sub};
use crate::Scalar;
use crate::dual::Dual;
use crate::road::Road;

/// What the rider does to the bicycle, axes of the frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RiderForces {
    /// Sum of the forces at saddle, bar and pedals, N.
    pub force_n: [f64; 3],
    /// Their moment about the saddle, Nm.
    pub moment_nm: [f64; 3],
    /// Pull along the left and right arm (linear arms), N.
    pub arms_n: [f64; 2],
    /// Torque of arms and hands on the front assembly about the steer axis, Nm.
    pub arms_steer_torque_nm: f64,
}

/// The rider's bodies by themselves.
#[derive(Clone, Debug)]
pub struct Interaction {
    tree: Tree,
    /// From the base origin, m.
    saddle: [f64; 3],
}

/// Linear and angular momentum about the origin of the world, world axes, and mass times place.
struct Momentum<T> {
    linear: Vec3<T>,
    angular: Vec3<T>,
    moment: Vec3<T>,
    mass: T,
}

impl Interaction {
    /// For a bicycle with rider.
    pub fn new(parameters: &Parameters) -> Self {
        let nothing = Body::default();
        let mut rider = parameters.clone();
        (rider.frame, rider.fork) = (nothing, nothing);
        for (wheel, joint) in [
            (&mut rider.rear_wheel, &mut rider.joints.rear_wheel),
            (&mut rider.front_wheel, &mut rider.joints.front_wheel),
        ] {
            *wheel = Wheel {
                radius_m: wheel.radius_m,
                mass_kg: 0.0,
                spin_inertia_kg_m2: 0.0,
                diameter_inertia_kg_m2: 0.0,
            };
            joint.free = false;
        }
        let leg = &parameters.rider.leg;
        let saddle = [
            leg.hip_x_m,
            0.0,
            leg.hip_z_m + parameters.rear_wheel.radius_m,
        ];
        Self {
            tree: Tree::new(&rider),
            saddle,
        }
    }

    /// The forces in the state of a ride where `input` acts.
    pub fn forces(&self, ride: &Ride, input: &Input) -> RiderForces {
        self.forces_of(ride.model(), ride.state(), input, ride.road())
    }

    fn forces_of(
        &self,
        model: &Multibody,
        x: &State,
        input: &Input,
        road: Option<&Road>,
    ) -> RiderForces {
        let mut dx = [0.0; STATES];
        model.observed(x, input, road, &mut dx);
        let moving: State<Dual<1>> = core::array::from_fn(|k| Dual {
            re: x[k],
            eps: [dx[k]],
        });
        let m = momentum_of(&self.tree, &moving);
        let g = model.parameters.gravity_m_s2;
        let pose = model.tree.pose(x);
        // On the rider, world axes, about the world's origin.
        let force = [
            m.linear[0].eps[0],
            m.linear[1].eps[0],
            m.linear[2].eps[0] - m.mass.re * g,
        ];
        // Moment of the weight: r × (0, 0, m g).
        let weight = [m.moment[1].re * g, -m.moment[0].re * g, 0.0];
        let about_origin: Vec3<f64> = core::array::from_fn(|k| m.angular[k].eps[0] - weight[k]);
        let saddle = add([x[0], x[1], x[2]], rows_times(&pose.rotation, self.saddle));
        let about_saddle = sub(about_origin, cross(saddle, force));
        let on_bicycle = |v: Vec3<f64>| columns_times(&pose.rotation, scale(v, -1.0));
        let springs = &model.springs;
        let [stiffness, damping, preload] = springs.joints[0];
        let joint = &model.parameters.joints.steer;
        let mut arms_steer = input.steer_torque_nm
            - (stiffness - joint.stiffness_nm_rad) * x[STEER]
            - (damping - joint.damping_nm_s_rad) * x[STEER_RATE]
            + (preload - joint.preload_nm);
        let mut arms_n = [0.0; 2];
        if let Some(arms) = &springs.arms {
            for (k, pull) in arms_n.iter_mut().enumerate() {
                let line = arms.line(k, &model.tree, x, &pose);
                *pull = line.stretch * arms.stiffness + line.rate * arms.damping;
                arms_steer += line.steer_torque(&model.tree, *pull);
            }
        }
        RiderForces {
            force_n: on_bicycle(force),
            moment_nm: on_bicycle(about_saddle),
            arms_n,
            arms_steer_torque_nm: arms_steer,
        }
    }
}

/// Momentum of all bodies of a tree.
fn momentum_of<T: Scalar>(tree: &Tree, x: &State<T>) -> Momentum<T> {
    let pose = tree.pose(x);
    let v = x.base_motion();
    let mut inertia: Inertia<T> = lift(&tree.base);
    let mut h: Spatial<T> = [T::zero(); 6];
    for (part, q, rate) in [
        (&tree.steer, x[STEER], x[STEER_RATE]),
        (&tree.legs[0], x[LEGS], x[LEG_RATE]),
        (&tree.legs[1], x[LEGS + 1], x[LEG_RATE + 1]),
    ] {
        let coupling = turned(part, q, &mut inertia);
        for k in 0..6 {
            h[k] += coupling[k] * rate;
        }
    }
    let base = momentum(&inertia, &v);
    let spin = [
        v[1] - x[super::state::SPIN],
        dot([v[0], v[1], v[2]], pose.front_axle) - x[super::state::SPIN + 1],
    ];
    // Wheels: what spins, about axles that turn with frame and fork.
    let mut angular: Vec3<T> = core::array::from_fn(|k| h[k] + base[k]);
    angular[1] += spin[0].scale(tree.wheels[0].spin_inertia);
    for k in 0..3 {
        angular[k] += (spin[1] * pose.front_axle[k]).scale(tree.wheels[1].spin_inertia);
    }
    // Trunk.
    let part = &tree.trunk;
    let total = trunk_rate(x, &pose);
    let local = [
        dot(pose.trunk_x, total),
        dot(pose.trunk_y, total),
        dot(pose.twist_axis, total),
    ];
    let [jx, jy, jz, jxz] = part.tensor;
    let turn = [
        local[0].scale(jx) + local[2].scale(jxz),
        local[1].scale(jy),
        local[2].scale(jz) + local[0].scale(jxz),
    ];
    let joint: Vec3<T> = lift(&part.joint);
    let at_joint = add([v[3], v[4], v[5]], cross([v[0], v[1], v[2]], joint));
    let first: Vec3<T> = core::array::from_fn(|k| {
        pose.trunk_x[k].scale(part.first[0]) + pose.twist_axis[k].scale(part.first[1])
    });
    let trunk_linear = add(scale(at_joint, T::from_f64(part.mass)), cross(total, first));
    let about_joint: Vec3<T> = core::array::from_fn(|k| {
        pose.trunk_x[k] * turn[0] + pose.trunk_y[k] * turn[1] + pose.twist_axis[k] * turn[2]
    });
    let trunk_angular = add(
        add(about_joint, cross(first, at_joint)),
        cross(joint, trunk_linear),
    );
    let linear: Vec3<T> = core::array::from_fn(|k| h[3 + k] + base[3 + k] + trunk_linear[k]);
    let angular = add(angular, trunk_angular);
    // To the world: about its origin, with the place of the base.
    let place = [x[0], x[1], x[2]];
    let mass = inertia[9] + T::from_f64(part.mass);
    let own: Vec3<T> =
        core::array::from_fn(|k| inertia[6 + k] + first[k] + joint[k].scale(part.mass));
    let linear = rows_times(&pose.rotation, linear);
    Momentum {
        linear,
        angular: add(rows_times(&pose.rotation, angular), cross(place, linear)),
        moment: add(rows_times(&pose.rotation, own), scale(place, mass)),
        mass,
    }
}

impl super::joints::ArmLine<f64> {
    /// Torque on the front assembly about the steer axis of a pull along the arm, Nm.
    fn steer_torque(&self, tree: &Tree, pull_n: f64) -> f64 {
        let m = &tree.steer.motion;
        let turn = cross(
            sub(self.grip, tree.steer.point),
            scale(self.direction, -pull_n),
        );
        power(
            &[m[0], m[1], m[2], 0.0, 0.0, 0.0],
            &[turn[0], turn[1], turn[2], 0.0, 0.0, 0.0],
        )
    }
}

#[cfg(test)]
mod tests {
    use super::super::{BulsinkBicycle, Case, Disturbed, Reading};
    use super::*;

    fn full(linear_arms: bool) -> Parameters {
        let reading = Reading {
            linear_arms,
            ..Reading::default()
        };
        Parameters::bulsink2017(BulsinkBicycle::One, Case::Full, &reading)
    }

    fn tumbling(p: &Parameters) -> Ride {
        let mut ride = Ride::new(p, None, 6.0).unwrap();
        ride.disturb(&Disturbed {
            roll_rad: 0.1,
            roll_rate_rad_s: 0.3,
            steer_rad: 0.05,
            steer_rate_rad_s: -0.4,
            trunk_rad: [0.05, -0.02, 0.1],
            legs_rad: [0.03, -0.06],
        });
        for _ in 0..50 {
            ride.advance(&Input::default(), 1e-3);
        }
        ride
    }

    #[test]
    fn at_rest_the_rider_weighs_on_the_bicycle() {
        let p = full(false);
        let ride = Ride::new(&p, None, 5.0).unwrap();
        let f = Interaction::new(&p).forces(&ride, ride.input());
        let (_, roll, pitch) = ride.state().yaw_roll_pitch_rad();
        assert_eq!(roll, 0.0);
        let weight = 80.0 * 9.81;
        assert!(
            (f.force_n[2] - weight * libm::cos(pitch)).abs() < 1e-5,
            "{f:?}"
        );
        assert!(
            f.force_n[1].abs() < 1e-9 && f.moment_nm[0].abs() < 1e-9,
            "{f:?}"
        );
        // The rider's centre lies before the saddle: he pitches the bicycle forward.
        let lever = -f.moment_nm[1] / weight;
        assert!((0.1..0.25).contains(&lever), "{lever}");
    }

    #[test]
    fn the_whole_model_obeys_gravity_and_the_road() {
        let p = full(true);
        let ride = tumbling(&p);
        let (model, x) = (ride.model(), ride.state());
        let mut dx = [0.0; STATES];
        let input = Input::default();
        model.observed(x, &input, None, &mut dx);
        let moving: State<Dual<1>> = core::array::from_fn(|k| Dual {
            re: x[k],
            eps: [dx[k]],
        });
        let m = momentum_of(&model.tree, &moving);
        let contacts = ride.contacts_under(&input);
        let load: f64 = contacts.iter().map(|c| c.load_n).sum();
        let expected = m.mass.re * 9.81 - load;
        let found = m.linear[2].eps[0];
        assert!((found - expected).abs() < 1e-9 * 1e3, "{found} {expected}");
        // Level road: horizontal forces are those of the tyres, whatever their directions.
        let across = libm::hypot(m.linear[0].eps[0], m.linear[1].eps[0]);
        let tyres: f64 = contacts
            .iter()
            .map(|c| libm::hypot(c.tyre.longitudinal_n, c.tyre.lateral_n))
            .sum();
        assert!(across > 1.0 && across <= tyres + 1e-6, "{across} {tyres}");
    }

    #[test]
    fn rider_and_bicycle_add_up() {
        // The bicycle's own momentum balance, from the tyres and the rider's force.
        let p = full(false);
        let ride = tumbling(&p);
        let (model, x, input) = (ride.model(), ride.state(), Input::default());
        let mut dx = [0.0; STATES];
        model.observed(x, &input, None, &mut dx);
        let moving: State<Dual<1>> = core::array::from_fn(|k| Dual {
            re: x[k],
            eps: [dx[k]],
        });
        let interaction = Interaction::new(&p);
        let whole = momentum_of(&model.tree, &moving);
        let rider = momentum_of(&interaction.tree, &moving);
        let own = whole.linear[2].eps[0] - rider.linear[2].eps[0];
        let load: f64 = ride.contacts_under(&input).iter().map(|c| c.load_n).sum();
        let pose = model.tree.pose(x);
        let force = interaction.forces(&ride, &input).force_n;
        let down = rows_times(&pose.rotation, force)[2];
        let mass = whole.mass.re - rider.mass.re;
        assert!((rider.mass.re - 80.0).abs() < 1e-9);
        assert!(
            (own - (mass * 9.81 + down - load)).abs() < 1e-6,
            "{own} {down} {load}"
        );
    }

    #[test]
    fn arms_act_on_the_bar_from_both_sides() {
        for linear in [true, false] {
            let p = full(linear);
            let mut ride = Ride::new(&p, None, 5.0).unwrap();
            ride.disturb(&Disturbed {
                steer_rad: 0.1,
                ..Disturbed::default()
            });
            let f = Interaction::new(&p).forces(&ride, &Input::default());
            if linear {
                // Steered to the right, the right grip comes nearer, the left one goes away.
                assert!(f.arms_n[0] > f.arms_n[1] + 1.0, "{f:?}");
            } else {
                assert!((f.arms_steer_torque_nm + 0.5).abs() < 1e-12, "{f:?}");
            }
        }
    }
}
