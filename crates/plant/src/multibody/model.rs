//! What: the right-hand side of the multibody model.
//!
//! Equation: x' = f(x, u): kinematics, forces (tyres, springs, motors, rider, air), then the
//! forward dynamics of `dynamics`.
//!
//! Source: Bulsink (2017), chapter 3 and appendix A.
//!
//! Assumes and ignores: frame and fork do not flex; wind acts at one point.
//!
//! Valid for: 0.3 to 12 m/s, any attitude (a fall stays finite).
//!
//! Checked by: the tests of this module and its neighbours.

use super::contact::{
    Ground, WheelContact, contact_points, lying_wrench, tyre_contact, wheel_wrench,
};
use super::dynamics::{Accelerations, Forces, Pose, derivative};
use super::error::MultibodyError;
use super::factored::Factored;
use super::inertia::{Spatial, power};
use super::joints::{Springs, add_steer_torque};
use super::parameters::{Air, Parameters};
use super::state::{SLIP, State, StateAccess};
use super::step::Stiffness;
use super::tree::Tree;
use super::vector::{Vec3, add, axpy, build, columns_times, cross, lift, rows_times, scale, sub};
use crate::Scalar;
use crate::road::Road;
use crate::tyre::{Tyre, TyreModel};

/// What acts on the model: motors, rider, disturbances. Held constant over a step.
#[derive(Clone, Copy, Debug)]
pub struct Input<T = f64> {
    /// Front hub motor: brake torque, reacted by the fork, Nm.
    pub front_brake_nm: T,
    /// Rear hub motor and pedals: traction torque, reacted by the frame, Nm.
    pub rear_traction_nm: T,
    /// Rider's torque on the handlebar, to the right, Nm.
    pub steer_torque_nm: T,
    /// Torques of the rider's muscles on trunk lean, pitch and twist, Nm.
    pub trunk_torque_nm: [T; 3],
    /// Torques of the rider's muscles on left and right leg, outward, Nm.
    pub leg_torque_nm: [T; 2],
    /// Force on the rear frame, frame axes (forward, right, down), N.
    pub force_n: [T; 3],
    /// Where it acts, coordinates of the parameters (from the rear contact point at rest), m.
    pub force_at_m: [T; 3],
    /// Moment on the rear frame, frame axes, Nm.
    pub moment_nm: [T; 3],
    /// Velocity of the air over the ground, world axes, m/s.
    pub wind_m_s: [T; 3],
    /// Velocity of the road under the rear wheel along y of the world (a platform that moves
    /// sideways), m/s. Only on tyres; without slip it does nothing.
    pub rear_road_y_m_s: T,
}

impl<T: Scalar> Default for Input<T> {
    fn default() -> Self {
        let z = T::zero();
        Self {
            front_brake_nm: z,
            rear_traction_nm: z,
            steer_torque_nm: z,
            trunk_torque_nm: [z; 3],
            leg_torque_nm: [z; 2],
            force_n: [z; 3],
            force_at_m: [z; 3],
            moment_nm: [z; 3],
            wind_m_s: [z; 3],
            rear_road_y_m_s: z,
        }
    }
}

/// What the road does to a bicycle on tyres.
#[derive(Clone, Copy, Debug)]
pub(super) struct TyreForces<T> {
    wrench: Spatial<T>,
    steer: T,
    spin: [T; 2],
    /// Derivatives of the relaxed slips.
    slip_rates: [T; 4],
    pub(super) contacts: [WheelContact<T>; 2],
}

impl<T: Scalar> TyreForces<T> {
    #[inline(always)]
    fn add_to(&self, forces: &mut Forces<T>) {
        for k in 0..6 {
            forces.wrench[k] += self.wrench[k];
        }
        forces.steer += self.steer;
        forces.spin[0] += self.spin[0];
        forces.spin[1] += self.spin[1];
    }
}

/// What the right-hand side on tyres needs of a state, whatever acts.
#[derive(Clone, Debug)]
pub(super) struct Prepared<T> {
    pose: Pose<T>,
    pub(super) tyres: TyreForces<T>,
    factored: Factored<T>,
}

/// The model.
#[derive(Clone, Debug)]
pub struct Multibody {
    pub(super) parameters: Parameters,
    pub(super) tree: Tree,
    pub(super) springs: Springs,
    pub(super) tyres: [Tyre; 2],
    pub(super) air: Option<Air>,
    pub(super) no_slip: bool,
    /// How fast contact forces act back on the tyres' slip.
    pub(super) stiff: Stiffness,
}

impl Multibody {
    /// A model from checked parameters.
    pub fn new(parameters: &Parameters) -> Result<Self, MultibodyError> {
        parameters.validate()?;
        let tree = Tree::new(parameters);
        let air = parameters.air;
        let mut model = Self {
            springs: Springs::new(parameters, &tree),
            tree,
            tyres: [parameters.tyre.rear, parameters.tyre.front],
            air: (air.drag_area_m2 != 0.0 || air.side_area_m2 != 0.0).then_some(air),
            no_slip: parameters.tyre.rear.is_constraint(),
            parameters: parameters.clone(),
            stiff: Stiffness::default(),
        };
        model.stiff = Stiffness::of(&model);
        Ok(model)
    }

    /// The parameters it was made from.
    pub fn parameters(&self) -> &Parameters {
        &self.parameters
    }

    /// True if the wheels are held by constraints instead of tyre forces.
    pub fn is_no_slip(&self) -> bool {
        self.no_slip
    }

    /// Upright, straight, every joint at zero, wheels rolling at `speed_m_s`. On tyres the bicycle
    /// hangs at zero deflection: `steady` finds where it settles.
    pub fn upright<T: Scalar>(&self, speed_m_s: f64) -> State<T> {
        let mut x = [T::zero(); super::STATES];
        x[2] = T::from_f64(-self.tree.wheels[0].radius);
        x[super::state::ATTITUDE] = T::one();
        x[super::state::VELOCITY] = T::from_f64(speed_m_s);
        for k in 0..2 {
            x[super::state::SPIN + k] = T::from_f64(speed_m_s / self.tree.wheels[k].radius);
        }
        x
    }

    /// Derivative of the state. Without a road the ground is level with friction 1.
    pub fn rhs<T: Scalar>(
        &self,
        x: &State<T>,
        input: &Input<T>,
        road: Option<&Road>,
        dx: &mut State<T>,
    ) {
        super::batch::rhs(self, x, input, road, dx);
    }

    /// The same, to be compiled into its caller; gives the contacts of the tyres.
    #[inline(always)]
    pub(super) fn rhs_inlined<T: Scalar>(
        &self,
        x: &State<T>,
        input: &Input<T>,
        road: Option<&Road>,
        dx: &mut State<T>,
    ) -> Option<[WheelContact<T>; 2]> {
        if self.no_slip {
            let pose = self.tree.pose(x);
            let grounds = self.grounds(x, &pose, road);
            self.rhs_no_slip(x, &pose, &self.applied(x, input, &pose), &grounds, dx);
            return None;
        }
        let prepared = self.prepare_inlined(x, input.rear_road_y_m_s, road);
        self.finish_inlined(&prepared, x, input, dx);
        Some(prepared.tyres.contacts)
    }

    /// On tyres: all of the right-hand side that does not depend on what acts.
    #[inline(always)]
    pub(super) fn prepare_inlined<T: Scalar>(
        &self,
        x: &State<T>,
        rear_road_y_m_s: T,
        road: Option<&Road>,
    ) -> Prepared<T> {
        let pose = self.tree.pose(x);
        let grounds = self.grounds(x, &pose, road);
        Prepared {
            tyres: self.tyre_forces(x, rear_road_y_m_s, &pose, &grounds),
            factored: self.tree.factor(x, &pose, self.parameters.gravity_m_s2),
            pose,
        }
    }

    /// The rest of it.
    #[inline(always)]
    pub(super) fn finish_inlined<T: Scalar>(
        &self,
        prepared: &Prepared<T>,
        x: &State<T>,
        input: &Input<T>,
        dx: &mut State<T>,
    ) {
        let Prepared {
            pose,
            tyres,
            factored,
        } = prepared;
        let mut forces = self.applied(x, input, pose);
        tyres.add_to(&mut forces);
        let a: Accelerations<T> = factored.accelerations(&self.tree, &forces);
        derivative(x, pose, &a, dx);
        dx[SLIP..SLIP + 4].copy_from_slice(&tyres.slip_rates);
    }

    /// The road under each hub.
    #[inline(always)]
    pub(super) fn grounds<T: Scalar>(
        &self,
        x: &State<T>,
        pose: &Pose<T>,
        road: Option<&Road>,
    ) -> [Ground<T>; 2] {
        match road {
            None => [Ground::level(T::one()); 2],
            Some(road) => {
                let hub = rows_times(&pose.rotation, pose.front_hub);
                [
                    ground(road, x[0], x[1]),
                    ground(road, x[0] + hub[0], x[1] + hub[1]),
                ]
            }
        }
    }

    /// The road under the rear hub alone.
    pub(super) fn rear_ground(x: &State, road: Option<&Road>) -> Ground<f64> {
        road.map_or_else(|| Ground::level(1.0), |road| ground(road, x[0], x[1]))
    }

    /// What the road does to tyres, and to a bicycle on its side.
    #[inline(always)]
    fn tyre_forces<T: Scalar>(
        &self,
        x: &State<T>,
        rear_road_y_m_s: T,
        pose: &Pose<T>,
        grounds: &[Ground<T>; 2],
    ) -> TyreForces<T> {
        let mut points = contact_points(&self.tree, x, pose, grounds, false);
        // What slips is the tyre over the road, which may move.
        points[0].velocity = axpy(points[0].velocity, -rear_road_y_m_s, pose.rotation[1]);
        let floor = self.parameters.tyre.slip_speed_floor_m_s;
        let z = T::zero();
        let mut slip_rates = [z; 4];
        let mut contact = |k: usize| {
            let radius = self.tree.wheels[k].radius;
            tyre_contact(
                (k, radius),
                &self.tyres[k],
                floor,
                &points[k],
                x,
                grounds[k].friction,
                &mut slip_rates,
            )
        };
        let contacts = [contact(0), contact(1)];
        let (rear, rear_spin) = wheel_wrench(&points[0], [z, T::one(), z], &contacts[0]);
        let (front, front_spin) = wheel_wrench(&points[1], pose.front_axle, &contacts[1]);
        let lying = lying_wrench(&self.tree, x, pose, &grounds[0]);
        TyreForces {
            wrench: build(|k| rear[k] + front[k] + lying[k]),
            steer: power(&lift(&self.tree.steer.motion), &front),
            spin: [rear_spin, front_spin],
            slip_rates,
            contacts,
        }
    }

    /// Motors, rider, springs, air, disturbances.
    #[inline(always)]
    pub(super) fn applied<T: Scalar>(
        &self,
        x: &State<T>,
        input: &Input<T>,
        pose: &Pose<T>,
    ) -> Forces<T> {
        let mut f = Forces::zero();
        let at: Vec3<T> = sub(input.force_at_m, lift(&self.tree.origin));
        let turn = cross(at, input.force_n);
        for k in 0..3 {
            f.wrench[k] = turn[k] + input.moment_nm[k];
            f.wrench[3 + k] = input.force_n[k];
        }
        f.spin = [input.rear_traction_nm, -input.front_brake_nm];
        f.trunk = input.trunk_torque_nm;
        f.legs = input.leg_torque_nm;
        add_steer_torque(
            &self.springs,
            &self.tree,
            pose,
            input.steer_torque_nm,
            &mut f,
        );
        self.springs.add(&self.tree, x, pose, &mut f);
        if let Some(air) = &self.air {
            self.add_air(air, x, pose, input.wind_m_s, &mut f.wrench);
        }
        f
    }

    /// Air drag: ½ ρ A |u| u along each axis of the frame, u the wind felt at the centre of
    /// pressure.
    #[inline(always)]
    fn add_air<T: Scalar>(
        &self,
        air: &Air,
        x: &State<T>,
        pose: &Pose<T>,
        wind: Vec3<T>,
        wrench: &mut Spatial<T>,
    ) {
        let o = &self.tree.origin;
        let at: Vec3<T> = lift(&[air.x_m - o[0], 0.0, air.z_m - o[2]]);
        let v = x.base_motion();
        let speed = add([v[3], v[4], v[5]], cross([v[0], v[1], v[2]], at));
        let felt = sub(columns_times(&pose.rotation, wind), speed);
        let half = 0.5 * air.density_kg_m3;
        let size = (felt[0] * felt[0] + felt[1] * felt[1] + T::from_f64(1.0e-12)).sqrt();
        let pull = scale(
            [
                felt[0].scale(air.drag_area_m2),
                felt[1].scale(air.side_area_m2),
                T::zero(),
            ],
            size.scale(half),
        );
        let turn = cross(at, pull);
        for k in 0..3 {
            wrench[k] += turn[k];
            wrench[3 + k] += pull[k];
        }
    }
}

/// Tangent plane of the road at a spot.
#[inline]
fn ground<T: Scalar>(road: &Road, x: T, y: T) -> Ground<T> {
    let friction = road.friction_ratio(x, y);
    if road.is_level() {
        return Ground::level(friction);
    }
    let s = road.surface(x, y);
    let (a, b) = (s.along_ratio, s.across_ratio);
    let inverse = T::one() / (T::one() + a * a + b * b).sqrt();
    Ground {
        point: [x, y, -s.height_m],
        normal: [a * inverse, b * inverse, inverse],
        friction,
        level: false,
    }
}
