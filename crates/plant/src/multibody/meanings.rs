//! What the parameters of a plant file mean, and their units: for `list`, `explain` and tables.

/// Units by the end of a name; the longest that fits counts.
const UNITS: &[(&str, &str)] = &[
    ("_nm_s_rad", "Nm s/rad"),
    ("_nm_rad", "Nm/rad"),
    ("_m_per_rad", "m/rad"),
    ("_per_rad", "1/rad"),
    ("_n_s_m", "N s/m"),
    ("_kg_m2", "kg m²"),
    ("_kg_m3", "kg/m³"),
    ("_rad_s", "rad/s"),
    ("_m_s2", "m/s²"),
    ("_n_m", "N/m"),
    ("_m_s", "m/s"),
    ("_rad", "rad"),
    ("_m2", "m²"),
    ("_nm", "Nm"),
    ("_kg", "kg"),
    ("_hz", "Hz"),
    ("_m", "m"),
    ("_n", "N"),
    ("_s", "s"),
    ("_w", "W"),
];

/// The unit of the parameter at a path; "-" without one.
pub fn unit(path: &str) -> &'static str {
    let name = path.rsplit('.').next().unwrap_or(path);
    UNITS
        .iter()
        .find(|(end, _)| name.ends_with(end))
        .map_or("-", |(_, unit)| unit)
}

/// What a table of the file describes: the longest beginning that fits counts.
const GROUPS: &[(&str, &str)] = &[
    ("geometry", "bicycle"),
    ("rear_wheel", "rear wheel"),
    ("front_wheel", "front wheel"),
    ("frame", "rear frame"),
    (
        "fork",
        "front assembly without wheel: fork, stem, handlebar",
    ),
    ("rider.pelvis", "pelvis, fixed to the frame"),
    ("rider.trunk", "trunk with head and upper arms"),
    ("rider.forearms", "both forearms and hands"),
    ("rider.leg", "right leg; the left one mirrors it"),
    ("rider", "rider"),
    ("joints.steer", "steer axis"),
    ("joints.trunk_lean", "trunk lean, about the forward axis"),
    ("joints.trunk_pitch", "trunk pitch, about the lateral axis"),
    ("joints.trunk_twist", "trunk twist, about the vertical axis"),
    ("joints.legs", "each leg about its hip-ankle line"),
    ("joints.rear_wheel", "rear wheel on its axle"),
    ("joints.front_wheel", "front wheel on its axle"),
    ("arms", "arms"),
    ("tyre.rear", "rear tyre"),
    ("tyre.front", "front tyre"),
    ("tyre", "both tyres"),
    ("air", "air on the frame"),
    ("pedalling", "pedalling legs"),
];

/// What a key says.
const KEYS: &[(&str, &str)] = &[
    ("name", "name of the set"),
    ("source", "where the numbers come from"),
    ("gravity_m_s2", "gravity"),
    ("wheelbase_m", "wheelbase"),
    ("trail_m", "trail"),
    (
        "steer_tilt_rad",
        "steer axis tilt: 90 degrees less the head angle",
    ),
    ("steer_stop_rad", "steer angle at which the handlebar stops"),
    ("radius_m", "radius"),
    ("mass_kg", "mass"),
    ("spin_inertia_kg_m2", "moment of inertia about the axle"),
    (
        "diameter_inertia_kg_m2",
        "moment of inertia about a diameter",
    ),
    ("x_m", "centre forward of the rear contact point at rest"),
    ("y_m", "centre to the right"),
    ("z_m", "centre below the road (negative: above)"),
    (
        "inertia_xx_kg_m2",
        "moment of inertia about x, in the centre of mass",
    ),
    (
        "inertia_yy_kg_m2",
        "moment of inertia about y, in the centre of mass",
    ),
    (
        "inertia_zz_kg_m2",
        "moment of inertia about z, in the centre of mass",
    ),
    ("inertia_xy_kg_m2", "product of inertia -∫xy dm"),
    ("inertia_xz_kg_m2", "product of inertia -∫xz dm"),
    ("inertia_yz_kg_m2", "product of inertia -∫yz dm"),
    ("hip_x_m", "hip, forward"),
    ("hip_y_m", "hip, to the right"),
    ("hip_z_m", "hip, down"),
    ("ankle_x_m", "ankle, forward"),
    ("ankle_y_m", "ankle, to the right"),
    ("ankle_z_m", "ankle, down"),
    (
        "forearms_on_front",
        "true: forearms and hands are part of the front assembly",
    ),
    ("waist_x_m", "L4-L5 joint between pelvis and trunk, forward"),
    ("waist_z_m", "L4-L5 joint, down"),
    ("free", "false: locked at zero"),
    ("stiffness_nm_rad", "stiffness about zero"),
    ("damping_nm_s_rad", "damping"),
    ("preload_nm", "torque of the spring at zero angle"),
    ("stiffness_n_m", "stiffness of each, along its line"),
    ("damping_n_s_m", "damping of each, along its line"),
    (
        "torsional_stiffness_nm_rad",
        "stiffness of both about the steer axis",
    ),
    (
        "torsional_damping_nm_s_rad",
        "damping of both about the steer axis",
    ),
    ("shoulder_x_m", "right shoulder, forward"),
    ("shoulder_y_m", "right shoulder, to the right"),
    ("shoulder_z_m", "right shoulder, down"),
    ("grip_x_m", "right grip, forward"),
    ("grip_y_m", "right grip, to the right"),
    ("grip_z_m", "right grip, down"),
    (
        "torque_on_trunk",
        "true: the trunk reacts the rider's steer torque; false: the frame",
    ),
    ("slip_speed_floor_m_s", "speed below which slip is smoothed"),
    ("drag_area_m2", "drag coefficient times frontal area"),
    ("side_area_m2", "side force coefficient times lateral area"),
    ("density_kg_m3", "density"),
    ("cadence_rad_s", "rate of the crank while the rider pedals"),
    ("crank_length_m", "length of the crank"),
    (
        "pedal_offset_m",
        "middle of each pedal from the middle of the frame",
    ),
    ("leg_mass_kg", "mass of each leg"),
    ("leg_aside_m", "its centre from the middle of the frame"),
    ("resting_force_n", "force on each pedal while the legs rest"),
    (
        "through_trunk_ratio",
        "share of the pedals' roll moment that the trunk balances",
    ),
    (
        "leg_forward_cos_ratio",
        "forward motion of a leg's centre over crank length, with cos θ",
    ),
    (
        "leg_forward_sin_ratio",
        "forward motion of a leg's centre over crank length, with sin θ",
    ),
    (
        "leg_down_cos_ratio",
        "downward motion of a leg's centre over crank length, with cos θ",
    ),
    (
        "leg_down_sin_ratio",
        "downward motion of a leg's centre over crank length, with sin θ",
    ),
    ("nominal_load_n", "load at which the tyre was measured"),
    (
        "longitudinal_shape_ratio",
        "shape of longitudinal force Cx [PCX1]",
    ),
    (
        "longitudinal_friction_ratio",
        "longitudinal friction [PDX1]",
    ),
    (
        "longitudinal_stiffness_ratio",
        "longitudinal stiffness over load [PKX1]",
    ),
    ("slip_shape_ratio", "shape of side-slip force [PCY1]"),
    ("camber_shape_ratio", "shape of camber force [PCY2]"),
    ("lateral_friction_ratio", "lateral friction [PDY1]"),
    (
        "lateral_friction_load_ratio",
        "exponent of lateral friction with load [PDY2]",
    ),
    (
        "cornering_max_per_rad",
        "largest cornering stiffness over nominal load [PKY1]",
    ),
    (
        "cornering_peak_ratio",
        "load factor of cornering stiffness [PKY3]",
    ),
    (
        "cornering_stiffness_per_rad",
        "cornering stiffness over load",
    ),
    (
        "camber_stiffness_per_rad",
        "camber stiffness over load [PKY6]",
    ),
    (
        "camber_stiffness_load_per_rad",
        "its variation with load [PKY7]",
    ),
    (
        "trail_slope_per_rad",
        "slope factor of the pneumatic trail [QBZ1]",
    ),
    ("trail_slope_load_per_rad", "its variation with load [QBZ2]"),
    ("trail_shape_ratio", "shape of the pneumatic trail [QCZ1]"),
    (
        "trail_peak_ratio",
        "peak pneumatic trail over radius [QDZ1]",
    ),
    ("trail_peak_load_ratio", "its variation with load [QDZ2]"),
    ("pneumatic_trail_m", "pneumatic trail"),
    (
        "twisting_per_rad",
        "twisting torque over load and radius [QDZ8]",
    ),
    ("twisting_load_per_rad", "its variation with load [QDZ9]"),
    ("twisting_m_per_rad", "twisting torque over load"),
    ("crown_radius_m", "radius of the tyre's cross section"),
    (
        "rolling_resistance_ratio",
        "rolling resistance moment over load and radius [QSY1]",
    ),
    ("overturning_ratio", "crown radius over wheel radius [QSX2]"),
    (
        "longitudinal_gain",
        "scales longitudinal stiffness; 1 as measured",
    ),
    (
        "cornering_gain",
        "scales cornering stiffness; 1 as measured",
    ),
    ("camber_gain", "scales camber stiffness; 1 as measured"),
    ("trail_gain", "scales pneumatic trail; 1 as measured"),
    ("twisting_gain", "scales twisting torque; 1 as measured"),
    (
        "overturning_gain",
        "scales overturning moment; 1 as measured",
    ),
    ("friction", "how the friction of the road acts"),
    ("combined", "how longitudinal slip takes away side force"),
    ("lateral_form", "how side slip and camber add up"),
    (
        "frozen_load_n",
        "coefficients as at this load, at every load",
    ),
    (
        "load_range_n",
        "coefficients follow load within these bounds",
    ),
    (
        "relaxation_length_m",
        "distance over which side slip builds up; absent: none",
    ),
    ("side_force", "coefficients x1 to x14 of side force"),
    ("aligning", "coefficients x1 to x18 of the moment about z"),
    (
        "remove_offsets",
        "leaves out what a perfect tyre does not have",
    ),
    (
        "slip_angle_limit_rad",
        "slip angle beyond which forces are held",
    ),
    ("camber_limit_rad", "camber beyond which forces are held"),
];

/// The same where the end of the path alone would say it wrong.
const PATHS: &[(&str, &str)] = &[
    ("air.x_m", "centre of pressure, forward"),
    ("air.z_m", "centre of pressure, down"),
    ("vertical.stiffness_n_m", "vertical spring"),
    ("vertical.damping_n_s_m", "vertical damper"),
];

/// What the parameter at a path means; `None` if nothing is known of it.
pub fn meaning(path: &str) -> Option<String> {
    let key = path.rsplit('.').next()?;
    let (_, says) = PATHS
        .iter()
        .find(|(end, _)| path.ends_with(end))
        .or_else(|| KEYS.iter().find(|(name, _)| *name == key))?;
    let group = GROUPS
        .iter()
        .filter(|(start, _)| path.starts_with(&format!("{start}.")))
        .max_by_key(|(start, _)| start.len());
    Some(match group {
        Some((_, group)) => format!("{group}: {says}"),
        None => (*says).to_owned(),
    })
}

#[cfg(test)]
mod tests {
    use super::super::{BulsinkBicycle, Case, Parameters, Reading};
    use super::*;

    #[test]
    fn every_parameter_has_a_meaning_and_a_unit() {
        let mut p = Parameters::bulsink2017(BulsinkBicycle::One, Case::Full, &Reading::default());
        p.pedalling = Some(super::super::Pedalling::default());
        for set in crate::tyre::SETS {
            (p.tyre.rear, p.tyre.front) = (set.tyre, set.tyre);
            for entry in p.entries() {
                let path = &entry.path;
                assert!(meaning(path).is_some(), "{path} has no meaning");
                // A number with a dimension says so in its name.
                let plain = ["_ratio", "_gain"].iter().any(|end| path.ends_with(end));
                if let toml::Value::Float(_) = entry.value {
                    assert!((unit(path) == "-") == plain, "{path}: {}", unit(path));
                }
            }
        }
        assert_eq!(unit("joints.legs.damping_nm_s_rad"), "Nm s/rad");
        assert_eq!(unit("tyre.front.linear.twisting_m_per_rad"), "m/rad");
        assert_eq!(
            meaning("tyre.front.magic_formula.vertical.stiffness_n_m").unwrap(),
            "front tyre: vertical spring"
        );
        assert_eq!(meaning("frame.mass_kg").unwrap(), "rear frame: mass");
    }
}
