//! Parameter sets of the multibody model, by the name of their publication, and the cases of the
//! thesis.
//!
//! Source: Bulsink (2017), tables 3.3 and A.1, appendix A.3; Meijaard et al. (2007) through
//! `twinhub_linear`.
//!
//! Readings that the source leaves open are options here ([`Reading`]), not silent choices.

use super::parameters::{
    Air, Arms, Body, Geometry, Joint, Joints, Leg, Parameters, Rider, Tyres, Wheel,
};
use super::rider_body::{Posture, RiderBody};
use crate::tyre::{NoSlip, Tyre};

/// How the rider of Bulsink (2017) sits on bicycle 1. Saddle height, 0.700 m, is read as length
/// of the seat tube (0.86 m above the road) from the bottom bracket (0.575, 0.250) to the saddle at x = 0.230; hands lie at the published place of fork and forearms.
pub const BULSINK_POSTURE: Posture = Posture {
    saddle_x_m: 0.230,
    saddle_z_m: -0.849,
    bracket_x_m: 0.575,
    bracket_z_m: -0.250,
    back_angle_rad: 0.467,
    grip_x_m: 0.75,
    // Half the steer width of 0.176 m: with it linear arms of 525 N/m make about the published
    // 5 Nm/rad of torsional stiffness.
    grip_y_m: 0.088,
    grip_z_m: -1.05,
    // What table A.1 leaves for the forearms (3.82 kg) of fork (2.42 kg at 0.980, 0.720) and fork
    // with forearms (at 0.815, 0.955).
    forearm_centre_m: Some([0.7105, -1.1039]),
};

/// Speed below which slip is smoothed, m/s: small against the 0.3 m/s that the model reaches down
/// to.
pub const SLIP_SPEED_FLOOR_M_S: f64 = 0.05;

/// Where the handlebar stops, rad: a guess (70°), far beyond any ride.
pub const STEER_STOP_RAD: f64 = 1.2;

/// The cases of Bulsink (2017), table 3.3.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Case {
    /// 1: no slip, rigid rider, no arms.
    NoSlipRigid,
    /// 2: no slip, passive rider, no arms.
    NoSlipPassive,
    /// 3: no slip, rigid rider, forearm mass on the front assembly.
    NoSlipArmMass,
    /// 4: no slip, rigid rider, arm damping.
    NoSlipArmDamping,
    /// 5: no slip, rigid rider, arm stiffness.
    NoSlipArmStiffness,
    /// 6: tyres, rigid rider, no arms.
    TyresRigid,
    /// 7: tyres, passive rider, arms with mass, stiffness and damping.
    Full,
}

impl Case {
    /// All cases, in the order of the table.
    pub const ALL: [Self; 7] = [
        Self::NoSlipRigid,
        Self::NoSlipPassive,
        Self::NoSlipArmMass,
        Self::NoSlipArmDamping,
        Self::NoSlipArmStiffness,
        Self::TyresRigid,
        Self::Full,
    ];

    fn no_slip(self) -> bool {
        !matches!(self, Self::TyresRigid | Self::Full)
    }
    fn passive(self) -> bool {
        matches!(self, Self::NoSlipPassive | Self::Full)
    }
    fn arm_mass(self) -> bool {
        matches!(self, Self::NoSlipArmMass | Self::Full)
    }
    fn arm_stiffness(self) -> bool {
        matches!(self, Self::NoSlipArmStiffness | Self::Full)
    }
    fn arm_damping(self) -> bool {
        matches!(self, Self::NoSlipArmDamping | Self::Full)
    }
}

/// How table A.1 is read where it leaves room.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reading {
    /// Products of inertia of frame, fork and rider: true by the table's footnote (entry =
    /// +∫xz dm, z up), false as the usual tensor.
    pub products_by_footnote: bool,
    /// Wheel spin inertia over m R²; not published.
    pub wheel_inertia_ratio: f64,
    /// Arms as linear spring-dampers (true) or as torsional ones.
    pub linear_arms: bool,
    /// The rider's height, m.
    pub rider_height_m: f64,
    /// The rider's mass, kg.
    pub rider_mass_kg: f64,
}

impl Default for Reading {
    fn default() -> Self {
        Self {
            products_by_footnote: true,
            wheel_inertia_ratio: 0.43,
            linear_arms: false,
            rider_height_m: 1.80,
            rider_mass_kg: 80.0,
        }
    }
}

/// The bicycles of table A.1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BulsinkBicycle {
    /// Twade city bicycle, chapters 3 and 7.
    One,
    /// Trek L200, chapters 4 to 6.
    Two,
}

/// A body of table A.1: mass, x and height of the centre, xx, yy, zz and the printed off-diagonal
/// entry, z up.
fn row(mass: f64, x: f64, height: f64, [xx, yy, zz, entry]: [f64; 4], footnote: bool) -> Body {
    Body {
        mass_kg: mass,
        x_m: x,
        z_m: -height,
        inertia_xx_kg_m2: xx,
        inertia_yy_kg_m2: yy,
        inertia_zz_kg_m2: zz,
        // Here xz = -∫xz dm with z down, that is +∫xz dm with z up.
        inertia_xz_kg_m2: if footnote { entry } else { -entry },
    }
}

/// A joint that may move.
fn free(stiffness: f64, damping: f64) -> Joint {
    Joint {
        free: true,
        stiffness_nm_rad: stiffness,
        damping_nm_s_rad: damping,
        preload_nm: 0.0,
    }
}

impl Parameters {
    /// Bulsink (2017), table A.1, in one of the cases of table 3.3. With a locked rider his mass
    /// and inertia are the printed ones; a rider that moves is made of the segments of A.3, with
    /// the reference height and mass the printed centre of mass.
    pub fn bulsink2017(bicycle: BulsinkBicycle, case: Case, reading: &Reading) -> Self {
        let one = bicycle == BulsinkBicycle::One;
        let by_footnote = reading.products_by_footnote;
        let (wheelbase, trail, head) = if one {
            (1.150, 0.041, 1.21)
        } else {
            (1.125, 0.112, 1.18)
        };
        let (rear_mass, front_mass) = if one { (4.01, 3.34) } else { (4.22, 3.72) };
        let (frame, fork) = if one {
            (
                row(
                    8.30,
                    0.320,
                    0.590,
                    [0.694, 1.105, 0.509, -0.103],
                    by_footnote,
                ),
                row(
                    2.42,
                    0.980,
                    0.720,
                    [0.168, 0.158, 0.046, 0.067],
                    by_footnote,
                ),
            )
        } else {
            (
                row(
                    8.62,
                    0.334,
                    0.466,
                    [0.506, 0.214, 0.612, -0.117],
                    by_footnote,
                ),
                row(
                    3.72,
                    0.907,
                    0.808,
                    [0.272, 0.214, 0.178, 0.146],
                    by_footnote,
                ),
            )
        };
        let wheel = |mass: f64| {
            let spin = reading.wheel_inertia_ratio * mass * 0.350 * 0.350;
            Wheel {
                radius_m: 0.350,
                mass_kg: mass,
                spin_inertia_kg_m2: spin,
                diameter_inertia_kg_m2: 0.5 * spin,
            }
        };
        let segments = RiderBody::new(
            reading.rider_height_m,
            reading.rider_mass_kg,
            &BULSINK_POSTURE,
        );
        let published = reading.rider_height_m == 1.80 && reading.rider_mass_kg == 80.0;
        let whole = if published {
            row(
                80.0,
                0.39,
                1.06,
                [10.4737, 10.9094, 2.17315, 0.10307],
                by_footnote,
            )
        } else {
            segments.rigid()
        };
        let mut rider = if case.passive() {
            segments.rider
        } else {
            let forearms = segments.rider.forearms;
            let zero_leg = Leg {
                mass_kg: 0.0,
                ..segments.rider.leg
            };
            Rider {
                pelvis: if case.arm_mass() {
                    whole.without(&forearms)
                } else {
                    whole
                },
                trunk: Body::default(),
                forearms: if case.arm_mass() {
                    forearms
                } else {
                    Body::default()
                },
                leg: Leg {
                    inertia_xx_kg_m2: 0.0,
                    inertia_yy_kg_m2: 0.0,
                    inertia_zz_kg_m2: 0.0,
                    inertia_xy_kg_m2: 0.0,
                    inertia_xz_kg_m2: 0.0,
                    inertia_yz_kg_m2: 0.0,
                    ..zero_leg
                },
                ..segments.rider
            }
        };
        rider.forearms_on_front = case.arm_mass();
        let moving = |joint: Joint| {
            if case.passive() {
                joint
            } else {
                Joint {
                    free: false,
                    ..joint
                }
            }
        };
        let on = |flag: bool, value: f64| if flag { value } else { 0.0 };
        let (linear, torsional) = (reading.linear_arms, !reading.linear_arms);
        let tyre = if case.no_slip() {
            Tyre::NoSlip(NoSlip {})
        } else {
            crate::tyre::set("bulsink2017").map_or(Tyre::NoSlip(NoSlip {}), |set| set.tyre)
        };
        Self {
            name: if one { "bulsink2017_bicycle1" } else { "bulsink2017_bicycle2" }.to_owned(),
            source: "V. E. Bulsink (2017), Bicycling stability, University of Twente, tables 3.3 and A.1, appendix A.3"
                .to_owned(),
            gravity_m_s2: 9.81,
            geometry: Geometry {
                wheelbase_m: wheelbase,
                trail_m: trail,
                steer_tilt_rad: core::f64::consts::FRAC_PI_2 - head,
                steer_stop_rad: STEER_STOP_RAD,
            },
            rear_wheel: wheel(rear_mass),
            front_wheel: wheel(front_mass),
            frame,
            fork,
            rider,
            joints: Joints {
                steer: free(0.0, 0.0),
                trunk_lean: moving(free(1000.0, 50.0)),
                trunk_pitch: moving(free(1000.0, 50.0)),
                trunk_twist: moving(free(75.0, 5.0)),
                legs: moving(free(1000.0, 50.0)),
                rear_wheel: free(0.0, 0.0),
                front_wheel: free(0.0, 0.0),
            },
            arms: Arms {
                stiffness_n_m: on(linear && case.arm_stiffness(), 525.0),
                damping_n_s_m: on(linear && case.arm_damping(), 100.0),
                torsional_stiffness_nm_rad: on(torsional && case.arm_stiffness(), 5.0),
                torsional_damping_nm_s_rad: on(torsional && case.arm_damping(), 0.9),
                shoulder_x_m: segments.shoulder_m[0],
                shoulder_y_m: segments.shoulder_m[1],
                shoulder_z_m: segments.shoulder_m[2],
                grip_x_m: BULSINK_POSTURE.grip_x_m,
                grip_y_m: BULSINK_POSTURE.grip_y_m,
                grip_z_m: BULSINK_POSTURE.grip_z_m,
                torque_on_trunk: false,
            },
            tyre: Tyres { rear: tyre, front: tyre, slip_speed_floor_m_s: SLIP_SPEED_FLOOR_M_S },
            air: Air::default(),
            pedalling: None,
        }
    }

    /// The 25 parameters of a Whipple-Carvallo bicycle: rigid rider, no slip, nothing passive.
    pub fn from_whipple(bicycle: &twinhub_linear::Bicycle) -> Self {
        let p = &bicycle.parameters;
        let body = |mass, x, z, [xx, yy, zz, xz]: [f64; 4]| Body {
            mass_kg: mass,
            x_m: x,
            z_m: z,
            inertia_xx_kg_m2: xx,
            inertia_yy_kg_m2: yy,
            inertia_zz_kg_m2: zz,
            inertia_xz_kg_m2: xz,
        };
        let wheel = |radius, mass, spin, diameter| Wheel {
            radius_m: radius,
            mass_kg: mass,
            spin_inertia_kg_m2: spin,
            diameter_inertia_kg_m2: diameter,
        };
        let tyre = Tyre::NoSlip(NoSlip {});
        Self {
            name: bicycle.name.clone(),
            source: bicycle.source.clone(),
            gravity_m_s2: p.g,
            geometry: Geometry {
                wheelbase_m: p.w,
                trail_m: p.c,
                steer_tilt_rad: p.lam,
                steer_stop_rad: STEER_STOP_RAD,
            },
            rear_wheel: wheel(p.rR, p.mR, p.IRyy, p.IRxx),
            front_wheel: wheel(p.rF, p.mF, p.IFyy, p.IFxx),
            frame: body(p.mB, p.xB, p.zB, [p.IBxx, p.IByy, p.IBzz, p.IBxz]),
            fork: body(p.mH, p.xH, p.zH, [p.IHxx, p.IHyy, p.IHzz, p.IHxz]),
            rider: Rider::default(),
            joints: Joints {
                steer: free(0.0, 0.0),
                rear_wheel: free(0.0, 0.0),
                front_wheel: free(0.0, 0.0),
                ..Joints::default()
            },
            arms: Arms::default(),
            tyre: Tyres {
                rear: tyre,
                front: tyre,
                slip_speed_floor_m_s: SLIP_SPEED_FLOOR_M_S,
            },
            air: Air::default(),
            pedalling: None,
        }
    }
}

/// A full rider on frictionless, undamped tyres with springs: nothing dissipates.
#[cfg(test)]
pub(super) fn frictionless_full() -> Parameters {
    use crate::tyre::{LinearTyre, Vertical};
    let reading = Reading {
        linear_arms: true,
        ..Reading::default()
    };
    let mut p = Parameters::bulsink2017(BulsinkBicycle::One, Case::Full, &reading);
    let slippery = Tyre::Linear(LinearTyre {
        nominal_load_n: 400.0,
        longitudinal_stiffness_ratio: 0.0,
        cornering_stiffness_per_rad: 0.0,
        camber_stiffness_per_rad: 0.0,
        pneumatic_trail_m: 0.0,
        twisting_m_per_rad: 0.0,
        crown_radius_m: 0.0,
        rolling_resistance_ratio: 0.0,
        vertical: Vertical {
            stiffness_n_m: 108_970.0,
            damping_n_s_m: 0.0,
        },
        relaxation_length_m: None,
    });
    p.geometry.steer_stop_rad = 10.0;
    p.tyre.rear = slippery;
    p.tyre.front = slippery;
    p.arms.damping_n_s_m = 0.0;
    let joints = &mut p.joints;
    for joint in [
        &mut joints.trunk_lean,
        &mut joints.trunk_pitch,
        &mut joints.trunk_twist,
        &mut joints.legs,
    ] {
        joint.damping_nm_s_rad = 0.0;
    }
    p
}
