//! What: the constant part of the multibody tree, worked out once from the parameters.
//!
//! Equation: a body that turns by q about an axis fixed in the base has an inertia about the base
//! origin that is exactly I(q) = C0 + C1 cos q + C2 sin q + C3 cos 2q + C4 sin 2q. Wheels are
//! axisymmetric: all but their spin inertia is part of frame and fork.
//!
//! Source: Featherstone (2008), Rigid Body Dynamics Algorithms, chapter 2; the harmonics follow
//! from writing out R(q) J R(q)ᵀ.
//!
//! Assumes and ignores: rigid bodies; frame, fork, trunk, pelvis symmetric about the frame plane;
//! legs mirror each other.
//!
//! Valid for: any angle.
//!
//! Checked by: `harmonics_are_the_rotated_inertia` (1e-13) here, and the energy balance in
//! `dynamics`.

use super::inertia::{Inertia, Spatial, about_point, momentum, power, rotated, sum};
use super::parameters::{Body, Joint, Leg, Parameters, Wheel};
use super::vector::cross_const;

/// A body on a hinge whose axis is fixed in the base.
#[derive(Clone, Debug)]
pub(super) struct Hinge {
    /// Motion of the hinge: axis, velocity at the base origin.
    pub motion: Spatial<f64>,
    /// A point on the axis, from the base origin.
    pub point: [f64; 3],
    /// Harmonics cos q, sin q, cos 2q, sin 2q of the inertia (without mass, which is constant).
    pub harmonics: [[f64; 9]; 4],
    /// Momentum per unit rate: constant, cos q, sin q.
    pub coupling: [Spatial<f64>; 3],
    /// One over the inertia about the axis; zero if locked.
    pub inverse_inertia: f64,
    /// Inertia about the axis, kg m².
    pub inertia: f64,
}

/// The trunk on its spherical joint.
#[derive(Clone, Debug)]
pub(super) struct Trunk {
    /// The joint, from the base origin.
    pub joint: [f64; 3],
    /// Mass, kg.
    pub mass: f64,
    /// First moment about the joint, trunk axes (x, z), kg m.
    pub first: [f64; 2],
    /// Tensor about the joint, trunk axes: xx, yy, zz, xz.
    pub tensor: [f64; 4],
    /// 1 where lean, pitch, twist may move, else 0.
    pub free: [f64; 3],
}

/// A wheel.
#[derive(Clone, Debug)]
pub(super) struct WheelPart {
    /// Radius, m.
    pub radius: f64,
    /// Spin inertia, kg m²; zero if the wheel is locked to its parent.
    pub spin_inertia: f64,
    /// One over it; zero if locked.
    pub inverse_inertia: f64,
}

/// The tree.
#[derive(Clone, Debug)]
pub(super) struct Tree {
    /// Constant part of the inertia of all but the trunk, about the base origin.
    pub base: Inertia<f64>,
    /// Front assembly.
    pub steer: Hinge,
    /// Left and right leg.
    pub legs: [Hinge; 2],
    /// Trunk.
    pub trunk: Trunk,
    /// Rear and front wheel.
    pub wheels: [WheelPart; 2],
    /// Front hub from the base origin: constant, cos δ, sin δ.
    pub front_hub: [[f64; 3]; 3],
    /// Front axle direction: cos δ, sin δ.
    pub front_axle: [[f64; 3]; 2],
    /// Where the bicycle lies on its side, forward of the origin, m.
    pub lying_x: f64,
    /// From the rear contact point at rest to the base origin, m.
    pub origin: [f64; 3],
}

/// Tensor of a leg (xx, yy, zz, xy, xz, yz).
pub(super) fn leg_tensor(leg: &Leg) -> [f64; 6] {
    [
        leg.inertia_xx_kg_m2,
        leg.inertia_yy_kg_m2,
        leg.inertia_zz_kg_m2,
        leg.inertia_xy_kg_m2,
        leg.inertia_xz_kg_m2,
        leg.inertia_yz_kg_m2,
    ]
}

/// Rotation by the angle with this cosine and sine about unit axis `s`, rows (Rodrigues).
pub(super) fn about_axis(s: [f64; 3], cos: f64, sin: f64) -> [[f64; 3]; 3] {
    let k = [[0.0, -s[2], s[1]], [s[2], 0.0, -s[0]], [-s[1], s[0], 0.0]];
    core::array::from_fn(|a| {
        core::array::from_fn(|b| {
            let unit = if a == b { cos } else { 0.0 };
            unit + sin * k[a][b] + (1.0 - cos) * s[a] * s[b]
        })
    })
}

impl Hinge {
    /// A hinge along `axis` through `point` that carries `body` (about the base origin, at q = 0).
    /// Also gives the constant part of the inertia.
    fn new(
        axis: [f64; 3],
        point: [f64; 3],
        body: &Inertia<f64>,
        joint: &Joint,
    ) -> (Self, Inertia<f64>) {
        let at = |cos: f64, sin: f64| rotated(body, &about_axis(axis, cos, sin), point);
        let h = core::f64::consts::FRAC_1_SQRT_2;
        let (i0, i90, i180, i270, i45) = (
            at(1.0, 0.0),
            at(0.0, 1.0),
            at(-1.0, 0.0),
            at(0.0, -1.0),
            at(h, h),
        );
        let mut harmonics = [[0.0; 9]; 4];
        let mut constant: Inertia<f64> = [0.0; 10];
        constant[9] = body[9];
        for k in 0..9 {
            constant[k] = 0.25 * (i0[k] + i90[k] + i180[k] + i270[k]);
            harmonics[0][k] = 0.5 * (i0[k] - i180[k]);
            harmonics[1][k] = 0.5 * (i90[k] - i270[k]);
            harmonics[2][k] = 0.25 * (i0[k] - i90[k] + i180[k] - i270[k]);
            harmonics[3][k] = i45[k] - constant[k] - h * (harmonics[0][k] + harmonics[1][k]);
        }
        let v = cross_const(&point, &axis);
        let motion = [axis[0], axis[1], axis[2], v[0], v[1], v[2]];
        let full = |h: &[f64; 9]| -> Inertia<f64> {
            core::array::from_fn(|k| if k < 9 { h[k] } else { 0.0 })
        };
        let coupling = [
            momentum(&constant, &motion),
            momentum(&full(&harmonics[0]), &motion),
            momentum(&full(&harmonics[1]), &motion),
        ];
        let inertia = power(&motion, &momentum(body, &motion));
        let inverse_inertia = if joint.free && inertia > 0.0 {
            1.0 / inertia
        } else {
            0.0
        };
        (
            Self {
                motion,
                point,
                harmonics,
                coupling,
                inverse_inertia,
                inertia,
            },
            constant,
        )
    }
}

impl WheelPart {
    fn new(wheel: &Wheel, joint: &Joint) -> Self {
        let spin_inertia = if joint.free {
            wheel.spin_inertia_kg_m2
        } else {
            0.0
        };
        let inverse_inertia = if joint.free {
            1.0 / wheel.spin_inertia_kg_m2
        } else {
            0.0
        };
        Self {
            radius: wheel.radius_m,
            spin_inertia,
            inverse_inertia,
        }
    }
}

/// A wheel without what spins, about the base origin.
fn wheel_body(wheel: &Wheel, joint: &Joint, at: [f64; 3]) -> Inertia<f64> {
    let d = wheel.diameter_inertia_kg_m2;
    let spin = if joint.free {
        0.0
    } else {
        wheel.spin_inertia_kg_m2
    };
    about_point(wheel.mass_kg, at, [d, spin, d, 0.0, 0.0, 0.0])
}

impl Tree {
    pub(super) fn new(p: &Parameters) -> Self {
        let radius = p.rear_wheel.radius_m;
        let origin = [0.0, 0.0, -radius];
        let from_origin = |x: f64, y: f64, z: f64| [x, y, z + radius];
        let body = |b: &Body| about_point(b.mass_kg, from_origin(b.x_m, 0.0, b.z_m), b.tensor());

        let tilt = p.geometry.steer_tilt_rad;
        let axis = [libm::sin(tilt), 0.0, libm::cos(tilt)];
        let ground = from_origin(p.geometry.wheelbase_m + p.geometry.trail_m, 0.0, 0.0);
        let along = ground[0] * axis[0] + ground[2] * axis[2];
        let point = [
            ground[0] - along * axis[0],
            0.0,
            ground[2] - along * axis[2],
        ];
        let hub = from_origin(p.geometry.wheelbase_m, 0.0, -p.front_wheel.radius_m);
        let mut front = vec![
            body(&p.fork),
            wheel_body(&p.front_wheel, &p.joints.front_wheel, hub),
        ];
        let mut trunk_body = p.rider.trunk;
        if p.rider.forearms_on_front {
            front.push(body(&p.rider.forearms));
        } else {
            trunk_body = trunk_body.joined(&p.rider.forearms);
        }
        let (steer, steer_constant) = Hinge::new(axis, point, &sum(&front), &p.joints.steer);

        let leg = &p.rider.leg;
        let leg_hinge = |side: f64| {
            let hip = from_origin(leg.hip_x_m, side * leg.hip_y_m, leg.hip_z_m);
            let ankle = from_origin(leg.ankle_x_m, side * leg.ankle_y_m, leg.ankle_z_m);
            let centre = from_origin(leg.x_m, side * leg.y_m, leg.z_m);
            let mut tensor = leg_tensor(leg);
            tensor[3] *= side;
            tensor[5] *= side;
            let d = [ankle[0] - hip[0], ankle[1] - hip[1], ankle[2] - hip[2]];
            let length = libm::sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
            // Down the right leg, up the left one: mirrored axes, so that both knees move outward
            // for a positive angle (the knee lies in front of the line).
            let axis = if length > 0.0 {
                [
                    side * d[0] / length,
                    side * d[1] / length,
                    side * d[2] / length,
                ]
            } else {
                [0.0, 0.0, side]
            };
            Hinge::new(
                axis,
                hip,
                &about_point(leg.mass_kg, centre, tensor),
                &p.joints.legs,
            )
        };
        let (left, left_constant) = leg_hinge(-1.0);
        let (right, right_constant) = leg_hinge(1.0);

        let rear_wheel = wheel_body(&p.rear_wheel, &p.joints.rear_wheel, [0.0; 3]);
        let base = sum(&[
            body(&p.frame),
            body(&p.rider.pelvis),
            rear_wheel,
            steer_constant,
            left_constant,
            right_constant,
        ]);

        let joint = from_origin(p.rider.waist_x_m, 0.0, p.rider.waist_z_m);
        let b = &trunk_body;
        let arm = [b.x_m - p.rider.waist_x_m, 0.0, b.z_m - p.rider.waist_z_m];
        let about_joint = about_point(b.mass_kg, arm, b.tensor());
        let joints = &p.joints;
        let flag = |joint: &Joint| if joint.free { 1.0 } else { 0.0 };
        let trunk = Trunk {
            joint,
            mass: b.mass_kg,
            first: [about_joint[6], about_joint[8]],
            tensor: [
                about_joint[0],
                about_joint[1],
                about_joint[2],
                about_joint[4],
            ],
            free: [
                flag(&joints.trunk_lean),
                flag(&joints.trunk_pitch),
                flag(&joints.trunk_twist),
            ],
        };

        // Rotation about the axis: r = p + s (s·d) + (d - s (s·d)) cos + (s × d) sin.
        let d = [hub[0] - point[0], 0.0, hub[2] - point[2]];
        let along = d[0] * axis[0] + d[2] * axis[2];
        let parallel = [along * axis[0], 0.0, along * axis[2]];
        let front_hub = [
            [point[0] + parallel[0], 0.0, point[2] + parallel[2]],
            [d[0] - parallel[0], 0.0, d[2] - parallel[2]],
            cross_const(&axis, &d),
        ];
        let lateral = [0.0, 1.0, 0.0];
        Self {
            base,
            steer,
            legs: [left, right],
            trunk,
            wheels: [
                WheelPart::new(&p.rear_wheel, &p.joints.rear_wheel),
                WheelPart::new(&p.front_wheel, &p.joints.front_wheel),
            ],
            front_hub,
            front_axle: [lateral, cross_const(&axis, &lateral)],
            lying_x: 0.4 * p.geometry.wheelbase_m,
            origin,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn harmonics_are_the_rotated_inertia() {
        let body = about_point(3.0, [0.4, 0.2, -0.7], [0.3, 0.4, 0.2, 0.01, -0.05, 0.02]);
        let norm = libm::sqrt(0.09 + 0.01 + 0.9);
        let axis = [0.3 / norm, 0.1 / norm, libm::sqrt(0.9) / norm];
        let point = [0.5, 0.1, -0.2];
        let joint = Joint {
            free: true,
            ..Joint::default()
        };
        let (hinge, constant) = Hinge::new(axis, point, &body, &joint);
        for k in 0..24 {
            let q = f64::from(k) * 0.26;
            let (sin, cos) = libm::sincos(q);
            let (sin2, cos2) = libm::sincos(2.0 * q);
            let exact = rotated(&body, &about_axis(axis, cos, sin), point);
            let h = &hinge.harmonics;
            for i in 0..9 {
                let ours =
                    constant[i] + h[0][i] * cos + h[1][i] * sin + h[2][i] * cos2 + h[3][i] * sin2;
                assert!(
                    (ours - exact[i]).abs() < 1.0e-13,
                    "entry {i} at {q}: {ours} {}",
                    exact[i]
                );
            }
            let coupling = momentum(&exact, &hinge.motion);
            for i in 0..6 {
                let c = &hinge.coupling;
                let ours = c[0][i] + c[1][i] * cos + c[2][i] * sin;
                assert!((ours - coupling[i]).abs() < 1.0e-13, "coupling {i} at {q}");
            }
            assert!((power(&hinge.motion, &coupling) - hinge.inertia).abs() < 1.0e-13);
        }
    }
}
