//! Parameters of the multibody model, as read from TOML.
//!
//! Positions are those of the bicycle at rest, upright, with every joint at zero: x forward, y
//! right, z down, origin in the rear contact point of undeflected wheels. Inertias are about the
//! centre of mass; products follow the tensor, `xz = -∫xz dm`.

use super::error::MultibodyError;
use super::pedalling::Pedalling;
use crate::tyre::Tyre;
use serde::{Deserialize, Serialize};

/// Everything the model needs to know.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Parameters {
    /// Name of the set.
    pub name: String,
    /// Where the numbers come from.
    pub source: String,
    /// Gravity, m/s².
    pub gravity_m_s2: f64,
    /// Geometry of the bicycle.
    pub geometry: Geometry,
    /// Rear wheel.
    pub rear_wheel: Wheel,
    /// Front wheel.
    pub front_wheel: Wheel,
    /// Rear frame.
    pub frame: Body,
    /// Front assembly without wheel: fork, stem, handlebar.
    pub fork: Body,
    /// Rider.
    pub rider: Rider,
    /// Joints: what may move, and passive springs.
    pub joints: Joints,
    /// Arms between shoulders and handlebar.
    pub arms: Arms,
    /// Tyres.
    pub tyre: Tyres,
    /// Air.
    pub air: Air,
    /// Legs that pedal; absent: the pedals' force acts evenly, and the legs rest.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pedalling: Option<Pedalling>,
}

/// Geometry of the bicycle.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Geometry {
    /// Wheelbase, m.
    pub wheelbase_m: f64,
    /// Trail, m.
    pub trail_m: f64,
    /// Steer axis tilt: 90 degrees less the head angle, rad.
    pub steer_tilt_rad: f64,
    /// Steer angle at which cables, frame or rider stop the handlebar, rad.
    pub steer_stop_rad: f64,
}

/// A wheel, axisymmetric.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Wheel {
    /// Radius, m.
    pub radius_m: f64,
    /// Mass, kg.
    pub mass_kg: f64,
    /// Moment of inertia about the axle, kg m².
    pub spin_inertia_kg_m2: f64,
    /// Moment of inertia about a diameter, kg m².
    pub diameter_inertia_kg_m2: f64,
}

/// A body that is symmetric about the plane of the frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Body {
    /// Mass, kg.
    pub mass_kg: f64,
    /// Centre of mass forward of the rear contact point, m.
    pub x_m: f64,
    /// Centre of mass below the road, m: negative.
    pub z_m: f64,
    /// Moment of inertia about x, kg m².
    pub inertia_xx_kg_m2: f64,
    /// Moment of inertia about y, kg m².
    pub inertia_yy_kg_m2: f64,
    /// Moment of inertia about z, kg m².
    pub inertia_zz_kg_m2: f64,
    /// Product of inertia -∫xz dm, kg m².
    pub inertia_xz_kg_m2: f64,
}

/// One leg, a single body that turns about the line from hip to ankle. Given for the right side;
/// the left one is its mirror image.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Leg {
    /// Mass of one leg, kg.
    pub mass_kg: f64,
    /// Centre of mass, forward, m.
    pub x_m: f64,
    /// Centre of mass, to the right, m.
    pub y_m: f64,
    /// Centre of mass, down, m.
    pub z_m: f64,
    /// Moment of inertia about x, kg m².
    pub inertia_xx_kg_m2: f64,
    /// Moment of inertia about y, kg m².
    pub inertia_yy_kg_m2: f64,
    /// Moment of inertia about z, kg m².
    pub inertia_zz_kg_m2: f64,
    /// Product of inertia -∫xy dm, kg m².
    pub inertia_xy_kg_m2: f64,
    /// Product of inertia -∫xz dm, kg m².
    pub inertia_xz_kg_m2: f64,
    /// Product of inertia -∫yz dm, kg m².
    pub inertia_yz_kg_m2: f64,
    /// Hip joint, forward, m.
    pub hip_x_m: f64,
    /// Hip joint, to the right, m.
    pub hip_y_m: f64,
    /// Hip joint, down, m.
    pub hip_z_m: f64,
    /// Ankle, forward, m.
    pub ankle_x_m: f64,
    /// Ankle, to the right, m.
    pub ankle_y_m: f64,
    /// Ankle, down, m.
    pub ankle_z_m: f64,
}

/// The rider's bodies.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Rider {
    /// Pelvis, fixed to the frame.
    pub pelvis: Body,
    /// Trunk with head and upper arms.
    pub trunk: Body,
    /// Both forearms and hands: part of the trunk, or of the front assembly.
    pub forearms: Body,
    /// True: forearms and hands belong to the front assembly.
    pub forearms_on_front: bool,
    /// Right leg; the left one mirrors it.
    pub leg: Leg,
    /// L4-L5 joint between pelvis and trunk, forward, m.
    pub waist_x_m: f64,
    /// L4-L5 joint, down, m.
    pub waist_z_m: f64,
}

/// A joint: may it move, and its spring and damper.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Joint {
    /// False: locked at zero.
    pub free: bool,
    /// Stiffness about zero, Nm/rad.
    pub stiffness_nm_rad: f64,
    /// Damping, Nm s/rad.
    pub damping_nm_s_rad: f64,
    /// Constant torque of the spring at zero angle, Nm: carries what rests on the joint.
    pub preload_nm: f64,
}

/// All joints.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Joints {
    /// Steer axis.
    pub steer: Joint,
    /// Trunk lean, about the forward axis.
    pub trunk_lean: Joint,
    /// Trunk pitch, about the lateral axis.
    pub trunk_pitch: Joint,
    /// Trunk twist, about the vertical axis.
    pub trunk_twist: Joint,
    /// Each leg about its hip-ankle line.
    pub legs: Joint,
    /// Rear wheel on its axle: bearing drag as damping; no spring.
    pub rear_wheel: Joint,
    /// Front wheel on its axle: bearing drag as damping; no spring.
    pub front_wheel: Joint,
}

/// Arms as spring-dampers. Linear ones run from shoulder (on the trunk) to grip (on the front
/// assembly) and are free of force at rest; torsional ones act about the steer axis between frame
/// and front assembly. Zero means absent.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Arms {
    /// Stiffness of each arm along its line, N/m.
    pub stiffness_n_m: f64,
    /// Damping of each arm along its line, N s/m.
    pub damping_n_s_m: f64,
    /// Torsional stiffness of both arms about the steer axis, Nm/rad.
    pub torsional_stiffness_nm_rad: f64,
    /// Torsional damping of both arms about the steer axis, Nm s/rad.
    pub torsional_damping_nm_s_rad: f64,
    /// Right shoulder, forward, m.
    pub shoulder_x_m: f64,
    /// Right shoulder, to the right, m.
    pub shoulder_y_m: f64,
    /// Right shoulder, down, m.
    pub shoulder_z_m: f64,
    /// Right grip, forward, m.
    pub grip_x_m: f64,
    /// Right grip, to the right, m.
    pub grip_y_m: f64,
    /// Right grip, down, m.
    pub grip_z_m: f64,
    /// True: the rider's steer torque is reacted by the trunk; false: by the frame.
    pub torque_on_trunk: bool,
}

/// Tyres.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Tyres {
    /// Rear tyre.
    pub rear: Tyre,
    /// Front tyre.
    pub front: Tyre,
    /// Speed below which slip is smoothed, m/s: slip quantities divide by
    /// sqrt(speed² + this²).
    pub slip_speed_floor_m_s: f64,
}

/// Air drag on the frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Air {
    /// Drag coefficient times frontal area, m².
    pub drag_area_m2: f64,
    /// Side force coefficient times lateral area, m².
    pub side_area_m2: f64,
    /// Density, kg/m³.
    pub density_kg_m3: f64,
    /// Centre of pressure, forward, m.
    pub x_m: f64,
    /// Centre of pressure, down, m.
    pub z_m: f64,
}

impl Body {
    /// Tensor (xx, yy, zz, xy, xz, yz).
    pub(super) fn tensor(&self) -> [f64; 6] {
        [
            self.inertia_xx_kg_m2,
            self.inertia_yy_kg_m2,
            self.inertia_zz_kg_m2,
            0.0,
            self.inertia_xz_kg_m2,
            0.0,
        ]
    }

    /// This body and another as one.
    pub fn joined(&self, other: &Body) -> Body {
        let mass = self.mass_kg + other.mass_kg;
        if mass == 0.0 {
            return *self;
        }
        let x = (self.mass_kg * self.x_m + other.mass_kg * other.x_m) / mass;
        let z = (self.mass_kg * self.z_m + other.mass_kg * other.z_m) / mass;
        let about = |b: &Body| {
            super::inertia::about_point(b.mass_kg, [b.x_m - x, 0.0, b.z_m - z], b.tensor())
        };
        let j = super::inertia::sum(&[about(self), about(other)]);
        Body {
            mass_kg: mass,
            x_m: x,
            z_m: z,
            inertia_xx_kg_m2: j[0],
            inertia_yy_kg_m2: j[1],
            inertia_zz_kg_m2: j[2],
            inertia_xz_kg_m2: j[4],
        }
    }
}

impl Body {
    /// What is left of this body without a part of it.
    pub fn without(&self, part: &Body) -> Body {
        let negative = Body {
            mass_kg: -part.mass_kg,
            inertia_xx_kg_m2: -part.inertia_xx_kg_m2,
            inertia_yy_kg_m2: -part.inertia_yy_kg_m2,
            inertia_zz_kg_m2: -part.inertia_zz_kg_m2,
            inertia_xz_kg_m2: -part.inertia_xz_kg_m2,
            ..*part
        };
        self.joined(&negative)
    }
}

impl Parameters {
    /// Reads a set from TOML; the file name is for messages.
    pub fn from_toml(text: &str) -> Result<Self, MultibodyError> {
        let parameters: Self = toml::from_str(text).map_err(|e| MultibodyError::Toml {
            message: e.to_string(),
        })?;
        parameters.validate()?;
        Ok(parameters)
    }

    /// The set as TOML, which `from_toml` reads back without loss.
    pub fn to_toml(&self) -> String {
        toml::to_string(self).expect("plain numbers, flags and names are representable")
    }

    /// Mass of bicycle and rider, kg, and their centre of mass at rest: forward of the rear contact
    /// and above the road, m.
    pub fn mass_and_centre(&self) -> (f64, [f64; 2]) {
        let (r, leg) = (&self.rider, &self.rider.leg);
        let parts = [&self.frame, &self.fork, &r.pelvis, &r.trunk, &r.forearms]
            .map(|b| (b.mass_kg, b.x_m, -b.z_m));
        let (rear, front) = (&self.rear_wheel, &self.front_wheel);
        let wheels = [
            (rear.mass_kg, 0.0, rear.radius_m),
            (front.mass_kg, self.geometry.wheelbase_m, front.radius_m),
            (2.0 * leg.mass_kg, leg.x_m, -leg.z_m),
        ];
        let all = parts.iter().chain(&wheels);
        let (mass, x, height) = all.fold((0.0, 0.0, 0.0), |(m, x, h), p| {
            (m + p.0, x + p.0 * p.1, h + p.0 * p.2)
        });
        (mass, [x / mass, height / mass])
    }

    /// Refuses what no bicycle can be.
    pub fn validate(&self) -> Result<(), MultibodyError> {
        super::validate::validate(self)
    }
}
