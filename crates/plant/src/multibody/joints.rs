//! What: passive springs and dampers of the joints, and the arms.
//!
//! Equation: joint torque = preload - k q - c q'. An arm between shoulder and grip pulls with
//! k (l - l0) + c l' along its line; torsional arms give -k δ - c δ' about the steer axis.
//!
//! Source: Bulsink (2017), section 3.2.1 and table A.1; Cossalter, Doria and Lot (2006), Vehicle
//! System Dynamics 44 (arms as linear spring-dampers).
//!
//! Assumes and ignores: massless arms, free of force at rest, which can push as well as pull.
//!
//! Valid for: any angle.
//!
//! Checked by: the energy balance in `energy`; `a_stiff_pair_of_arms_is_a_torsion_spring` there.

use super::dynamics::{Forces, Pose};
use super::parameters::{Joint, Parameters};
use super::state::{
    LEG_RATE, LEGS, SPIN, STEER, STEER_RATE, State, StateAccess, TRUNK, TRUNK_RATE,
};
use super::tree::Tree;
use super::vector::{Vec3, add, axpy, build, cross, dot, lift, scale, sub};
use crate::Scalar;

/// The handlebar's stop: stiff enough to hold it, soft enough for a step of 1 ms.
const STOP_STIFFNESS_NM_RAD: f64 = 500.0;
const STOP_DAMPING_NM_S_RAD: f64 = 5.0;

/// Springs and dampers, worked out from the parameters.
#[derive(Clone, Debug)]
pub(super) struct Springs {
    /// Stiffness, damping, preload: steer, lean, pitch, twist, left and right leg.
    pub joints: [[f64; 3]; 6],
    /// Bearing drag of rear and front wheel, Nm s/rad.
    pub bearings: [f64; 2],
    /// Linear arms: stiffness, damping; `None` if both are zero.
    pub arms: Option<LinearArms>,
    /// Steer angle at which the handlebar stops, rad.
    pub steer_stop: f64,
    /// True: steer torque of the rider is reacted by the trunk.
    pub torque_on_trunk: bool,
}

/// Linear arms.
#[derive(Clone, Debug)]
pub(super) struct LinearArms {
    pub stiffness: f64,
    pub damping: f64,
    /// Left and right shoulder from the waist joint, trunk axes.
    pub shoulders: [[f64; 3]; 2],
    /// Left and right grip from the base origin: constant, cos δ, sin δ.
    pub grips: [[[f64; 3]; 3]; 2],
    /// Length at rest, m.
    pub length: f64,
}

impl Springs {
    pub(super) fn new(p: &Parameters, tree: &Tree) -> Self {
        let j = &p.joints;
        let entry = |joint: &Joint| {
            [
                joint.stiffness_nm_rad,
                joint.damping_nm_s_rad,
                joint.preload_nm,
            ]
        };
        let mut joints = [
            entry(&j.steer),
            entry(&j.trunk_lean),
            entry(&j.trunk_pitch),
            entry(&j.trunk_twist),
            entry(&j.legs),
            entry(&j.legs),
        ];
        let a = &p.arms;
        joints[0][0] += a.torsional_stiffness_nm_rad;
        joints[0][1] += a.torsional_damping_nm_s_rad;
        let present = a.stiffness_n_m != 0.0 || a.damping_n_s_m != 0.0;
        let arms = present.then(|| {
            let motion = &tree.steer.motion;
            let axis = [motion[0], motion[1], motion[2]];
            let point = tree.steer.point;
            let side = |sign: f64| {
                let radius = p.rear_wheel.radius_m;
                let grip = [a.grip_x_m, sign * a.grip_y_m, a.grip_z_m + radius];
                let d: [f64; 3] = core::array::from_fn(|k| grip[k] - point[k]);
                let along = d[0] * axis[0] + d[1] * axis[1] + d[2] * axis[2];
                let parallel: [f64; 3] = core::array::from_fn(|k| along * axis[k]);
                let harmonics = [
                    core::array::from_fn(|k| point[k] + parallel[k]),
                    core::array::from_fn(|k| d[k] - parallel[k]),
                    super::vector::cross_const(&axis, &d),
                ];
                let shoulder = [
                    a.shoulder_x_m - p.rider.waist_x_m,
                    sign * a.shoulder_y_m,
                    a.shoulder_z_m - p.rider.waist_z_m,
                ];
                (shoulder, harmonics)
            };
            let ((s0, g0), (s1, g1)) = (side(-1.0), side(1.0));
            let gap = [
                a.grip_x_m - a.shoulder_x_m,
                a.grip_y_m - a.shoulder_y_m,
                a.grip_z_m - a.shoulder_z_m,
            ];
            let length = libm::sqrt(gap[0] * gap[0] + gap[1] * gap[1] + gap[2] * gap[2]);
            LinearArms {
                stiffness: a.stiffness_n_m,
                damping: a.damping_n_s_m,
                shoulders: [s0, s1],
                grips: [g0, g1],
                length,
            }
        });
        Self {
            joints,
            bearings: [
                j.rear_wheel.damping_nm_s_rad,
                j.front_wheel.damping_nm_s_rad,
            ],
            arms,
            steer_stop: p.geometry.steer_stop_rad,
            torque_on_trunk: a.torque_on_trunk,
        }
    }

    /// Adds the torques of springs, dampers and arms.
    #[inline(always)]
    pub(super) fn add<T: Scalar>(
        &self,
        tree: &Tree,
        x: &State<T>,
        pose: &Pose<T>,
        forces: &mut Forces<T>,
    ) {
        let spring = |k: usize, q: usize, rate: usize| {
            let [stiffness, damping, preload] = self.joints[k];
            T::from_f64(preload) - x[q].scale(stiffness) - x[rate].scale(damping)
        };
        forces.steer += spring(0, STEER, STEER_RATE);
        // Beyond the stop: a stiff spring, damped.
        let stop = T::from_f64(self.steer_stop);
        let beyond = x[STEER] - x[STEER].clamp(-stop, stop);
        let pushed =
            beyond.scale(STOP_STIFFNESS_NM_RAD) + x[STEER_RATE].scale(STOP_DAMPING_NM_S_RAD);
        forces.steer -= (beyond * beyond).select(pushed, T::zero());
        for k in 0..3 {
            forces.trunk[k] += spring(1 + k, TRUNK + k, TRUNK_RATE + k);
        }
        for k in 0..2 {
            forces.legs[k] += spring(4 + k, LEGS + k, LEG_RATE + k);
            forces.spin[k] -= x[SPIN + k].scale(self.bearings[k]);
        }
        if let Some(arms) = &self.arms {
            arms.add(tree, x, pose, forces);
        }
    }
}

/// One arm in one state.
pub(super) struct ArmLine<T> {
    /// Stretch, m, and its rate, m/s.
    pub stretch: T,
    pub rate: T,
    /// From shoulder to grip, unit length.
    pub direction: Vec3<T>,
    /// Grip from the base origin; shoulder from the waist joint.
    pub grip: Vec3<T>,
    shoulder: Vec3<T>,
}

impl LinearArms {
    /// Geometry of arm `k` (0 left, 1 right).
    #[inline(always)]
    pub(super) fn line<T: Scalar>(
        &self,
        k: usize,
        tree: &Tree,
        x: &State<T>,
        pose: &Pose<T>,
    ) -> ArmLine<T> {
        let (s, c) = pose.steer;
        let g = &self.grips[k];
        let grip: Vec3<T> = build(|i| T::from_f64(g[0][i]) + c.scale(g[1][i]) + s.scale(g[2][i]));
        let [sx, sy, sz] = self.shoulders[k];
        let shoulder: Vec3<T> = build(|i| {
            pose.trunk_x[i].scale(sx) + pose.trunk_y[i].scale(sy) + pose.twist_axis[i].scale(sz)
        });
        let joint: Vec3<T> = lift(&tree.trunk.joint);
        let gap = sub(sub(grip, joint), shoulder);
        let length = dot(gap, gap).sqrt();
        let direction = scale(gap, T::one() / length);
        // Velocities relative to the base.
        let turn: Vec3<T> = build(|i| c.scale(g[2][i]) - s.scale(g[1][i]));
        let w = self.relative(x, pose);
        let speed = sub(scale(turn, x[STEER_RATE]), cross(w, shoulder));
        ArmLine {
            stretch: length - T::from_f64(self.length),
            rate: dot(direction, speed),
            direction,
            grip,
            shoulder,
        }
    }

    /// Angular velocity of the trunk relative to the base.
    #[inline(always)]
    fn relative<T: Scalar>(&self, x: &State<T>, pose: &Pose<T>) -> Vec3<T> {
        let lean = [x[TRUNK_RATE], T::zero(), T::zero()];
        axpy(
            axpy(lean, x[TRUNK_RATE + 1], pose.pitch_axis),
            x[TRUNK_RATE + 2],
            pose.twist_axis,
        )
    }

    #[inline(always)]
    fn add<T: Scalar>(&self, tree: &Tree, x: &State<T>, pose: &Pose<T>, forces: &mut Forces<T>) {
        let m = &tree.steer.motion;
        let axis: Vec3<T> = lift(&[m[0], m[1], m[2]]);
        let point: Vec3<T> = lift(&tree.steer.point);
        for k in 0..2 {
            let line = self.line(k, tree, x, pose);
            let pull = line.stretch.scale(self.stiffness) + line.rate.scale(self.damping);
            let force = scale(line.direction, pull);
            // On the grip: -force; on the shoulder: +force.
            forces.steer -= dot(axis, cross(sub(line.grip, point), force));
            let moment = cross(line.shoulder, force);
            add_trunk(pose, moment, forces);
        }
    }
}

/// A moment on the trunk (and its reaction on the base), as joint torques.
#[inline(always)]
pub(super) fn add_trunk<T: Scalar>(pose: &Pose<T>, moment: Vec3<T>, forces: &mut Forces<T>) {
    forces.trunk[0] += moment[0];
    forces.trunk[1] += dot(pose.pitch_axis, moment);
    forces.trunk[2] += dot(pose.twist_axis, moment);
}

/// A rider's steer torque: on the front assembly, reacted by trunk or frame.
#[inline(always)]
pub(super) fn add_steer_torque<T: Scalar>(
    springs: &Springs,
    tree: &Tree,
    pose: &Pose<T>,
    torque: T,
    forces: &mut Forces<T>,
) {
    forces.steer += torque;
    if springs.torque_on_trunk {
        let m = &tree.steer.motion;
        let axis: Vec3<T> = lift(&[m[0], m[1], m[2]]);
        add_trunk(pose, scale(axis, -torque), forces);
    }
}

/// Attitude helper for outputs that need the trunk's total motion.
#[inline]
pub(super) fn trunk_rate<T: Scalar>(x: &State<T>, pose: &Pose<T>) -> Vec3<T> {
    let v = x.base_motion();
    let lean = [x[TRUNK_RATE], T::zero(), T::zero()];
    let relative = axpy(
        axpy(lean, x[TRUNK_RATE + 1], pose.pitch_axis),
        x[TRUNK_RATE + 2],
        pose.twist_axis,
    );
    add([v[0], v[1], v[2]], relative)
}
