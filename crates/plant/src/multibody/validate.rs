//! Range checks on the parameters of the multibody model.

use super::error::MultibodyError;
use super::parameters::{Body, Parameters};
use crate::tyre::TyreModel;

fn check(path: &str, found: f64, ok: bool, accepted: &'static str) -> Result<(), MultibodyError> {
    if ok {
        Ok(())
    } else {
        Err(MultibodyError::OutOfRange {
            path: path.to_owned(),
            found,
            accepted,
        })
    }
}

fn within(
    path: &str,
    v: f64,
    low: f64,
    high: f64,
    accepted: &'static str,
) -> Result<(), MultibodyError> {
    check(path, v, v >= low && v <= high, accepted)
}

fn tensor(path: &str, mass: f64, j: [f64; 6]) -> Result<(), MultibodyError> {
    within(&format!("{path}.mass_kg"), mass, 0.0, 1.0e4, "0 to 10,000")?;
    for (k, v) in j.iter().enumerate() {
        let name = ["xx", "yy", "zz", "xy", "xz", "yz"][k];
        check(
            &format!("{path}.inertia_{name}_kg_m2"),
            *v,
            v.is_finite() && (k > 2 || *v >= 0.0),
            "finite; diagonal not negative",
        )?;
    }
    // A tensor of inertia is positive semidefinite. The triangle inequality is left to remarks:
    // published tensors break it.
    let [xx, yy, zz, xy, xz, yz] = j;
    let minor = xx * zz - xz * xz;
    let slack = 1.0e-12 * (1.0 + xx * zz);
    check(
        &format!("{path}.inertia_xz_kg_m2"),
        xz,
        minor >= -slack,
        "|xz| at most sqrt(xx zz)",
    )?;
    let full = xx * (yy * zz - yz * yz) - xy * (xy * zz - yz * xz) + xz * (xy * yz - yy * xz);
    check(
        &format!("{path}.inertia_xy_kg_m2"),
        xy,
        full >= -1.0e-12 * (1.0 + xx * yy * zz),
        "a positive tensor",
    )
}

fn body(path: &str, b: &Body) -> Result<(), MultibodyError> {
    tensor(path, b.mass_kg, b.tensor())?;
    within(&format!("{path}.x_m"), b.x_m, -10.0, 10.0, "-10 to 10")?;
    within(&format!("{path}.z_m"), b.z_m, -10.0, 10.0, "-10 to 10")
}

/// All checks.
pub(super) fn validate(p: &Parameters) -> Result<(), MultibodyError> {
    within("gravity_m_s2", p.gravity_m_s2, 0.0, 100.0, "0 to 100")?;
    within(
        "geometry.wheelbase_m",
        p.geometry.wheelbase_m,
        0.1,
        10.0,
        "0.1 to 10",
    )?;
    within("geometry.trail_m", p.geometry.trail_m, -2.0, 2.0, "-2 to 2")?;
    within(
        "geometry.steer_tilt_rad",
        p.geometry.steer_tilt_rad,
        -1.5,
        1.5,
        "-1.5 to 1.5",
    )?;
    within(
        "geometry.steer_stop_rad",
        p.geometry.steer_stop_rad,
        0.1,
        10.0,
        "0.1 to 10",
    )?;
    for (name, wheel) in [
        ("rear_wheel", &p.rear_wheel),
        ("front_wheel", &p.front_wheel),
    ] {
        within(
            &format!("{name}.radius_m"),
            wheel.radius_m,
            0.01,
            5.0,
            "0.01 to 5",
        )?;
        within(
            &format!("{name}.mass_kg"),
            wheel.mass_kg,
            0.0,
            1.0e3,
            "0 to 1000",
        )?;
        let (spin, diameter) = (wheel.spin_inertia_kg_m2, wheel.diameter_inertia_kg_m2);
        within(
            &format!("{name}.spin_inertia_kg_m2"),
            spin,
            1.0e-6,
            1.0e3,
            "1e-6 to 1000",
        )?;
        within(
            &format!("{name}.diameter_inertia_kg_m2"),
            diameter,
            0.0,
            1.0e3,
            "0 to 1000",
        )?;
    }
    body("frame", &p.frame)?;
    body("fork", &p.fork)?;
    body("rider.pelvis", &p.rider.pelvis)?;
    body("rider.trunk", &p.rider.trunk)?;
    body("rider.forearms", &p.rider.forearms)?;
    let leg = &p.rider.leg;
    tensor("rider.leg", leg.mass_kg, super::tree::leg_tensor(leg))?;
    let joints = &p.joints;
    for (name, joint) in [
        ("steer", &joints.steer),
        ("trunk_lean", &joints.trunk_lean),
        ("trunk_pitch", &joints.trunk_pitch),
        ("trunk_twist", &joints.trunk_twist),
        ("legs", &joints.legs),
        ("rear_wheel", &joints.rear_wheel),
        ("front_wheel", &joints.front_wheel),
    ] {
        let path = |field: &str| format!("joints.{name}.{field}");
        within(
            &path("stiffness_nm_rad"),
            joint.stiffness_nm_rad,
            -1.0e6,
            1.0e6,
            "-1e6 to 1e6",
        )?;
        within(
            &path("damping_nm_s_rad"),
            joint.damping_nm_s_rad,
            -1.0e4,
            1.0e4,
            "-1e4 to 1e4",
        )?;
        within(
            &path("preload_nm"),
            joint.preload_nm,
            -1.0e4,
            1.0e4,
            "-1e4 to 1e4",
        )?;
    }
    let moving_trunk = joints.trunk_lean.free || joints.trunk_pitch.free || joints.trunk_twist.free;
    check(
        "rider.trunk.mass_kg",
        p.rider.trunk.mass_kg,
        !moving_trunk || p.rider.trunk.mass_kg > 0.0,
        "above zero, if the trunk may move",
    )?;
    check(
        "rider.leg.mass_kg",
        leg.mass_kg,
        !joints.legs.free || leg.mass_kg > 0.0,
        "above zero, if legs may move",
    )?;
    if let Some(pedalling) = &p.pedalling {
        pedalling.validate()?;
    }
    let floor = p.tyre.slip_speed_floor_m_s;
    within(
        "tyre.slip_speed_floor_m_s",
        floor,
        1.0e-6,
        10.0,
        "1e-6 to 10",
    )?;
    for (wheel, tyre) in [("rear", &p.tyre.rear), ("front", &p.tyre.front)] {
        tyre.validate()
            .map_err(|source| MultibodyError::Tyre { wheel, source })?;
    }
    if p.tyre.rear.is_constraint() != p.tyre.front.is_constraint() {
        return Err(MultibodyError::MixedConstraint {
            rear: p.tyre.rear.name(),
            front: p.tyre.front.name(),
        });
    }
    Ok(())
}
