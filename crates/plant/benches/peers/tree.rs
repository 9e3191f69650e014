//! The bodies and joints of our bicycle and cyclist, worked out from the parameters alone, for
//! peers to build their models from: as JSON (Pinocchio) and as MJCF (MuJoCo).
//!
//! Axes are those of the bicycle at rest (x forward, y right, z down), places from the centre of
//! the rear wheel. Nothing of the model under test is used, so that agreement means something.

use serde_json::{Value, json};
use std::fmt::Write;
use twinhub_plant::multibody::{Body, Joint, Parameters, Wheel};

/// How a body moves in its parent.
#[derive(Clone, Copy)]
pub enum Motion {
    /// Six degrees of freedom.
    Free,
    /// About an axis.
    Hinge([f64; 3]),
    /// About a point; lean, pitch, twist.
    Ball,
}

/// A body of the tree.
pub struct TreeBody {
    pub name: &'static str,
    pub parent: Option<usize>,
    pub motion: Motion,
    pub joint_at_m: [f64; 3],
    pub mass_kg: f64,
    pub centre_m: [f64; 3],
    /// About the centre: xx, yy, zz, xy, xz, yz.
    pub tensor_kg_m2: [f64; 6],
}

/// From the rear contact point at rest to the centre of the rear wheel.
fn from_hub(p: &Parameters, [x, y, z]: [f64; 3]) -> [f64; 3] {
    [x, y, z + p.rear_wheel.radius_m]
}

fn tensor(b: &Body) -> [f64; 6] {
    let [xx, yy, zz, xz] = [
        b.inertia_xx_kg_m2,
        b.inertia_yy_kg_m2,
        b.inertia_zz_kg_m2,
        b.inertia_xz_kg_m2,
    ];
    [xx, yy, zz, 0.0, xz, 0.0]
}

/// The bodies, parents first, children next to their parents.
pub fn bodies(p: &Parameters) -> Vec<TreeBody> {
    let part = |name, parent, motion, joint_at_m, b: &Body| TreeBody {
        name,
        parent: Some(parent),
        motion,
        joint_at_m,
        mass_kg: b.mass_kg,
        centre_m: from_hub(p, [b.x_m, 0.0, b.z_m]),
        tensor_kg_m2: tensor(b),
    };
    // Rolling forward is a turn to the left about the lateral axis.
    let rolling = Motion::Hinge([0.0, -1.0, 0.0]);
    let wheel = |name, parent, w: &Wheel, at: [f64; 3]| TreeBody {
        name,
        parent: Some(parent),
        motion: rolling,
        joint_at_m: at,
        mass_kg: w.mass_kg,
        centre_m: at,
        tensor_kg_m2: [
            w.diameter_inertia_kg_m2,
            w.spin_inertia_kg_m2,
            w.diameter_inertia_kg_m2,
            0.0,
            0.0,
            0.0,
        ],
    };
    let g = &p.geometry;
    let (sin, cos) = g.steer_tilt_rad.sin_cos();
    let steer_at = from_hub(p, [g.wheelbase_m + g.trail_m, 0.0, 0.0]);
    let front_hub = from_hub(p, [g.wheelbase_m, 0.0, -p.front_wheel.radius_m]);
    let r = &p.rider;
    let (front, trunk) = if r.forearms_on_front {
        (p.fork.joined(&r.forearms), r.trunk)
    } else {
        (p.fork, r.trunk.joined(&r.forearms))
    };
    let mut frame = part(
        "frame",
        0,
        Motion::Free,
        [0.0; 3],
        &p.frame.joined(&r.pelvis),
    );
    frame.parent = None;
    let leg = |name, side: f64| {
        let l = &r.leg;
        let hip = from_hub(p, [l.hip_x_m, side * l.hip_y_m, l.hip_z_m]);
        let ankle = from_hub(p, [l.ankle_x_m, side * l.ankle_y_m, l.ankle_z_m]);
        let line: [f64; 3] = core::array::from_fn(|k| side * (ankle[k] - hip[k]));
        let length = line.iter().map(|v| v * v).sum::<f64>().sqrt();
        TreeBody {
            name,
            parent: Some(0),
            motion: Motion::Hinge(line.map(|v| v / length)),
            joint_at_m: hip,
            mass_kg: l.mass_kg,
            centre_m: from_hub(p, [l.x_m, side * l.y_m, l.z_m]),
            tensor_kg_m2: [
                l.inertia_xx_kg_m2,
                l.inertia_yy_kg_m2,
                l.inertia_zz_kg_m2,
                side * l.inertia_xy_kg_m2,
                l.inertia_xz_kg_m2,
                side * l.inertia_yz_kg_m2,
            ],
        }
    };
    vec![
        frame,
        wheel("rear_wheel", 0, &p.rear_wheel, [0.0; 3]),
        part("front", 0, Motion::Hinge([sin, 0.0, cos]), steer_at, &front),
        wheel("front_wheel", 2, &p.front_wheel, front_hub),
        part(
            "trunk",
            0,
            Motion::Ball,
            from_hub(p, [r.waist_x_m, 0.0, r.waist_z_m]),
            &trunk,
        ),
        leg("left_leg", -1.0),
        leg("right_leg", 1.0),
    ]
}

/// The tree as JSON.
pub fn json(p: &Parameters) -> Value {
    let bodies: Vec<Value> = bodies(p)
        .iter()
        .map(|b| {
            let (joint, axis) = match b.motion {
                Motion::Free => ("free", [0.0; 3]),
                Motion::Hinge(axis) => ("hinge", axis),
                Motion::Ball => ("ball", [0.0; 3]),
            };
            json!({
                "name": b.name,
                "parent": b.parent.map_or(-1, |k| k as i64),
                "joint": joint,
                "axis": axis,
                "joint_at_m": b.joint_at_m,
                "mass_kg": b.mass_kg,
                "centre_m": b.centre_m,
                "tensor_kg_m2": b.tensor_kg_m2,
            })
        })
        .collect();
    json!({ "schema_version": 1, "name": p.name, "gravity_m_s2": p.gravity_m_s2, "bodies": bodies })
}

fn text(v: &[f64]) -> String {
    v.iter().map(f64::to_string).collect::<Vec<_>>().join(" ")
}

/// The same tree with its springs and dampers as MJCF: passive joints and, for the arms, spatial
/// tendons, both computed by MuJoCo itself; no contact, no constraint.
pub fn mjcf(p: &Parameters, step_s: f64) -> String {
    let bodies = bodies(p);
    let mut xml = format!(
        "<mujoco><compiler angle=\"radian\"/>\
         <option timestep=\"{step_s}\" integrator=\"RK4\" gravity=\"0 0 {}\">\
         <flag contact=\"disable\" constraint=\"disable\"/></option><worldbody>",
        p.gravity_m_s2
    );
    element(p, &bodies, 0, &mut xml);
    xml.push_str("</worldbody>");
    let a = &p.arms;
    if a.stiffness_n_m != 0.0 || a.damping_n_s_m != 0.0 {
        let gap = [
            a.grip_x_m - a.shoulder_x_m,
            a.grip_y_m - a.shoulder_y_m,
            a.grip_z_m - a.shoulder_z_m,
        ];
        let length = gap.iter().map(|v| v * v).sum::<f64>().sqrt();
        xml.push_str("<tendon>");
        for side in ["left", "right"] {
            let _ = write!(
                xml,
                "<spatial stiffness=\"{}\" damping=\"{}\" springlength=\"{length}\">\
                 <site site=\"{side}_shoulder\"/><site site=\"{side}_grip\"/></spatial>",
                a.stiffness_n_m, a.damping_n_s_m
            );
        }
        xml.push_str("</tendon>");
    }
    xml.push_str("</mujoco>");
    xml
}

/// One body with everything it carries.
fn element(p: &Parameters, bodies: &[TreeBody], at: usize, xml: &mut String) {
    let b = &bodies[at];
    let origin = b.parent.map_or([0.0; 3], |k| bodies[k].joint_at_m);
    let place: [f64; 3] = core::array::from_fn(|k| b.joint_at_m[k] - origin[k]);
    let centre: [f64; 3] = core::array::from_fn(|k| b.centre_m[k] - b.joint_at_m[k]);
    let _ = write!(
        xml,
        "<body name=\"{}\" pos=\"{}\"><inertial pos=\"{}\" mass=\"{}\" fullinertia=\"{}\"/>",
        b.name,
        text(&place),
        text(&centre),
        b.mass_kg,
        text(&b.tensor_kg_m2)
    );
    let hinge = |name: &str, axis: &[f64], joint: &Joint, more: [f64; 2]| {
        format!(
            "<joint name=\"{name}\" type=\"hinge\" axis=\"{}\" stiffness=\"{}\" damping=\"{}\"/>",
            text(axis),
            joint.stiffness_nm_rad + more[0],
            joint.damping_nm_s_rad + more[1]
        )
    };
    let j = &p.joints;
    let arms = [
        p.arms.torsional_stiffness_nm_rad,
        p.arms.torsional_damping_nm_s_rad,
    ];
    match b.motion {
        Motion::Free => xml.push_str("<freejoint/>"),
        Motion::Hinge(axis) => {
            let (joint, more) = match b.name {
                "front" => (&j.steer, arms),
                "rear_wheel" => (&j.rear_wheel, [0.0; 2]),
                "front_wheel" => (&j.front_wheel, [0.0; 2]),
                _ => (&j.legs, [0.0; 2]),
            };
            xml.push_str(&hinge(b.name, &axis, joint, more));
        }
        Motion::Ball => {
            xml.push_str(&hinge("lean", &[1.0, 0.0, 0.0], &j.trunk_lean, [0.0; 2]));
            xml.push_str(&hinge("pitch", &[0.0, 1.0, 0.0], &j.trunk_pitch, [0.0; 2]));
            xml.push_str(&hinge("twist", &[0.0, 0.0, 1.0], &j.trunk_twist, [0.0; 2]));
        }
    }
    let a = &p.arms;
    let end = match b.name {
        "front" => Some(("grip", [a.grip_x_m, a.grip_y_m, a.grip_z_m])),
        "trunk" => Some(("shoulder", [a.shoulder_x_m, a.shoulder_y_m, a.shoulder_z_m])),
        _ => None,
    };
    if let Some((name, at)) = end {
        for (side, sign) in [("left", -1.0), ("right", 1.0)] {
            let from = from_hub(p, [at[0], sign * at[1], at[2]]);
            let place: [f64; 3] = core::array::from_fn(|k| from[k] - b.joint_at_m[k]);
            let _ = write!(
                xml,
                "<site name=\"{side}_{name}\" pos=\"{}\"/>",
                text(&place)
            );
        }
    }
    for (k, child) in bodies.iter().enumerate() {
        if child.parent == Some(at) {
            element(p, bodies, k, xml);
        }
    }
    xml.push_str("</body>");
}
