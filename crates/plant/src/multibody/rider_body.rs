//! What: the bodies of a cyclist from height and mass.
//!
//! Equation: segment masses and moments of inertia are linear in body mass (in grams; moments in
//! g cm²). Segment lengths are fractions of height.
//!
//! Source: Bulsink (2017), appendix A.3.1, after McConville et al. (mass and inertia); segment
//! lengths after Drillis and Contini as in Winter (2009), Biomechanics and Motor Control of Human
//! Movement, figure 4.1; centres of mass from A.3.
//!
//! Assumes and ignores: the pelvis is part of the printed "upper body" and is counted once (with
//! it counted twice an 80 kg rider has 84.8 kg); segments are scaled together to the given mass.
//! Posture is a guess where the source is silent: see [`Posture`]. The printed constant of the
//! head, 1.906, is read as 1906 g, which closes the sum of masses within 0.6 %.
//!
//! Valid for: adults, 40 to 120 kg, 1.4 to 2.1 m.
//!
//! Against table A.1: an 80 kg rider of 1.80 m has 8.03, 8.75 and 2.84 kg m² here, where 10.47, 10.91
//! and 2.17 are printed (77, 80 and 131 %). Posture cannot close the gap: with the trunk from 0.2 to
//! 0.47 rad, the saddle 4 cm lower or not, and the torso's centre at 2/3 of its length (as A.3.1
//! has it for the upper body above L4-L5; half is used here, which keeps the printed centre of
//! mass), xx stays between 77 and 93 %, yy between 80 and 96 % and zz between 123 and 131 %. The
//! segments' own zz with legs that sit add up to more than is printed: the printed tensor is not the
//! sum of these segments in any seated posture. Locked riders therefore take the printed tensor as it
//! is, and only a rider that moves is made of segments.
//!
//! Checked by: `the_published_rider_comes_out` here: mass exactly, centre of mass within 3 cm,
//! moments of inertia within 25 % (xx, yy) and 40 % (zz) of table A.1.

use super::inertia::{Inertia, about_point, rotated, sum};
use super::parameters::{Body, Leg, Rider};

/// How the rider sits. Coordinates of the parameters: x forward, z down, from the rear contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Posture {
    /// Saddle, forward, m.
    pub saddle_x_m: f64,
    /// Saddle, down, m (negative).
    pub saddle_z_m: f64,
    /// Bottom bracket, forward, m.
    pub bracket_x_m: f64,
    /// Bottom bracket, down, m (negative).
    pub bracket_z_m: f64,
    /// Forward lean of the trunk from upright, rad.
    pub back_angle_rad: f64,
    /// Grip of the right hand, forward, m.
    pub grip_x_m: f64,
    /// Grip of the right hand, to the right, m.
    pub grip_y_m: f64,
    /// Grip of the right hand, down, m (negative).
    pub grip_z_m: f64,
    /// Centre of mass of both forearms and hands (forward, down), m, where it is known; else it
    /// follows from shoulder and grip.
    pub forearm_centre_m: Option<[f64; 2]>,
}

/// The rider's bodies and joints, and the right shoulder.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RiderBody {
    /// Bodies.
    pub rider: Rider,
    /// Right shoulder, m.
    pub shoulder_m: [f64; 3],
}

/// Gram square centimetre to kg m².
const G_CM2: f64 = 1.0e-7;

/// Linear regression on body mass in grams: slope, constant.
type Line = (f64, f64);

struct Segment {
    mass: Line,
    xx: Line,
    yy: Line,
    zz: Line,
}

const HEAD: Segment = Segment {
    mass: (0.032, 1906.0),
    xx: (2.129, 32030.0),
    yy: (1.676, 54918.0),
    zz: (3.186, -6846.0),
};
const UPPER_BODY: Segment = Segment {
    mass: (0.532, -706.0),
    xx: (269.9, -3156034.0),
    yy: (284.493, -7664880.0),
    zz: (102.507, -2895524.0),
};
const UPPER_ARM: Segment = Segment {
    mass: (0.016, 809.0),
    xx: (0.535, 98150.0),
    yy: (0.661, 89662.0),
    zz: (0.400, -4018.0),
};
const LOWER_ARM: Segment = Segment {
    mass: (0.020, -218.0),
    xx: (1.508, -31431.0),
    yy: (1.397, -26562.0),
    zz: (0.313, -11645.0),
};
const HAND: Segment = Segment {
    mass: (0.007, -30.0),
    xx: (0.129, -850.0),
    yy: (0.134, -2599.0),
    zz: (0.085, -3401.0),
};
const UPPER_LEG: Segment = Segment {
    mass: (0.126, -1688.0),
    xx: (24.102, -233522.0),
    yy: (21.186, -222796.0),
    zz: (9.262, -378738.0),
};
const LOWER_LEG: Segment = Segment {
    mass: (0.038, 179.0),
    xx: (5.434, 37127.0),
    yy: (5.341, 44749.0),
    zz: (0.949, -32220.0),
};
const FOOT: Segment = Segment {
    mass: (0.008, 343.0),
    xx: (0.433, 5371.0),
    yy: (0.355, 7296.0),
    zz: (0.153, -2989.0),
};
/// Mass of the pelvis as a fraction of body mass.
const PELVIS_MASS: f64 = 0.0662;
/// Moments of inertia of the pelvis, kg m² per gram of body mass as printed (6.3e-4 kg m² per kg).
const PELVIS_INERTIA: [f64; 3] = [6.3e-4, 2.40e-4, 5.17e-4];

impl Segment {
    fn mass_kg(&self, grams: f64) -> f64 {
        (self.mass.0 * grams + self.mass.1) * 1.0e-3
    }
    fn tensor(&self, grams: f64) -> [f64; 3] {
        [self.xx, self.yy, self.zz]
            .map(|(slope, constant)| ((slope * grams + constant) * G_CM2).max(0.0))
    }
    /// About the origin: centre at `at`, segment axis z (long axis, up) turned to `along`.
    fn placed(&self, grams: f64, at: [f64; 3], along: [f64; 3]) -> Inertia<f64> {
        let [xx, yy, zz] = self.tensor(grams);
        let body = about_point(self.mass_kg(grams), at, [xx, yy, zz, 0.0, 0.0, 0.0]);
        rotated(&body, &frame_along(along), at)
    }
}

/// A rotation (rows) whose third column is `along`, with the second axis as lateral as can be.
fn frame_along(along: [f64; 3]) -> [[f64; 3]; 3] {
    let length = libm::sqrt(along.iter().map(|v| v * v).sum::<f64>());
    let z = along.map(|v| v / length);
    let y = {
        let raw = [-z[1] * z[0], 1.0 - z[1] * z[1], -z[1] * z[2]];
        let n = libm::sqrt(raw.iter().map(|v| v * v).sum::<f64>());
        raw.map(|v| v / n)
    };
    let x = super::vector::cross_const(&y, &z);
    core::array::from_fn(|k| [x[k], y[k], z[k]])
}

/// Centre of mass and tensor about it (xx, yy, zz, xy, xz, yz).
fn centred(i: &Inertia<f64>) -> ([f64; 3], [f64; 6]) {
    let c = [i[6] / i[9], i[7] / i[9], i[8] / i[9]];
    let shift = about_point(-i[9], c, [0.0; 6]);
    (c, core::array::from_fn(|k| i[k] + shift[k]))
}

/// A symmetric body.
fn symmetric(i: &Inertia<f64>) -> Body {
    let (c, j) = centred(i);
    Body {
        mass_kg: i[9],
        x_m: c[0],
        z_m: c[2],
        inertia_xx_kg_m2: j[0],
        inertia_yy_kg_m2: j[1],
        inertia_zz_kg_m2: j[2],
        inertia_xz_kg_m2: j[4],
    }
}

/// Point at fraction `f` from `a` to `b`.
fn between(a: [f64; 3], b: [f64; 3], f: f64) -> [f64; 3] {
    core::array::from_fn(|k| a[k] + f * (b[k] - a[k]))
}

fn mirrored(a: [f64; 3]) -> [f64; 3] {
    [a[0], -a[1], a[2]]
}

/// Joint between two links of given lengths that span from `a` to `b`, bent towards `bend`.
fn bent(a: [f64; 3], b: [f64; 3], first: f64, second: f64, bend: [f64; 3]) -> [f64; 3] {
    let d: [f64; 3] = core::array::from_fn(|k| b[k] - a[k]);
    let length = libm::sqrt(d.iter().map(|v| v * v).sum::<f64>());
    let u = d.map(|v| v / length);
    let span = length.min(first + second);
    let along = (first * first - second * second + span * span) / (2.0 * span);
    let off = libm::sqrt((first * first - along * along).max(0.0));
    let dot = bend[0] * u[0] + bend[1] * u[1] + bend[2] * u[2];
    let side: [f64; 3] = core::array::from_fn(|k| bend[k] - dot * u[k]);
    let n = libm::sqrt(side.iter().map(|v| v * v).sum::<f64>());
    core::array::from_fn(|k| a[k] + along * u[k] + off * side[k] / n)
}

impl RiderBody {
    /// The cyclist of this height and mass in this posture.
    pub fn new(height_m: f64, mass_kg: f64, posture: &Posture) -> Self {
        let grams = 1000.0 * mass_kg;
        let h = height_m;
        // Lengths as fractions of height (Winter 2009).
        let (thigh, shank) = (0.245 * h, 0.246 * h);
        let (upper_arm, forearm, hand) = (0.186 * h, 0.146 * h, 0.108 * h);
        let (half_hips, half_shoulders) = (0.0955 * h * 0.5, 0.129 * h);
        let (trunk_length, waist, head) = (0.288 * h, 0.06 * h, 0.130 * h);
        let ankle_height = 0.039 * h;

        // Hips rest on the saddle with their flesh.
        let hip = [posture.saddle_x_m, half_hips, posture.saddle_z_m - 0.04 * h];
        // Feet level at half stroke: the pedals of both legs at mid height.
        let ankle = [
            posture.bracket_x_m - 0.02 * h,
            half_hips,
            posture.bracket_z_m - ankle_height,
        ];
        let knee = bent(hip, ankle, thigh, shank, [1.0, 0.0, -0.5]);
        let up = [
            libm::sin(posture.back_angle_rad),
            0.0,
            -libm::cos(posture.back_angle_rad),
        ];
        let mid_hip = [hip[0], 0.0, hip[2]];
        // Pelvis upright under the waist joint.
        let waist_at = [mid_hip[0], 0.0, mid_hip[2] - waist];
        let from_waist = |d: f64| -> [f64; 3] { core::array::from_fn(|k| waist_at[k] + d * up[k]) };
        let shoulder_mid = from_waist(trunk_length - waist);
        let shoulder = [shoulder_mid[0], half_shoulders, shoulder_mid[2]];
        let wrist = [
            posture.grip_x_m - hand * 0.3,
            posture.grip_y_m,
            posture.grip_z_m,
        ];
        let elbow = bent(shoulder, wrist, upper_arm, forearm, [-0.2, 0.6, 1.0]);
        let head_at = from_waist(trunk_length - waist + 0.052 * h + 0.5 * head);

        let axis = |from: [f64; 3], to: [f64; 3]| -> [f64; 3] {
            core::array::from_fn(|k| to[k] - from[k])
        };
        // Both sides of a segment.
        let pair = |segment: &Segment, at: [f64; 3], along: [f64; 3]| {
            sum(&[
                segment.placed(grams, at, along),
                segment.placed(grams, mirrored(at), mirrored(along)),
            ])
        };
        let torso_mass = UPPER_BODY.mass_kg(grams) - PELVIS_MASS * mass_kg;
        let torso = {
            // The printed upper body holds the pelvis: what is left scales with its mass.
            let [xx, yy, zz] = UPPER_BODY
                .tensor(grams)
                .map(|v| v * torso_mass / UPPER_BODY.mass_kg(grams));
            let at = from_waist(0.5 * (trunk_length - waist));
            let body = about_point(torso_mass, at, [xx, yy, zz, 0.0, 0.0, 0.0]);
            // Shorter by the pelvis: its own lateral moments shrink with length squared.
            rotated(&body, &frame_along(up), at)
        };
        let pelvis = {
            let [xx, yy, zz] = PELVIS_INERTIA.map(|v| v * mass_kg);
            let at = [mid_hip[0], 0.0, mid_hip[2] - 0.5 * waist];
            about_point(PELVIS_MASS * mass_kg, at, [xx, yy, zz, 0.0, 0.0, 0.0])
        };
        let trunk = sum(&[
            torso,
            HEAD.placed(grams, head_at, [0.0, 0.0, -1.0]),
            pair(
                &UPPER_ARM,
                between(shoulder, elbow, 0.436),
                axis(elbow, shoulder),
            ),
        ]);
        let forearms = sum(&[
            pair(&LOWER_ARM, between(elbow, wrist, 0.43), axis(wrist, elbow)),
            pair(
                &HAND,
                between(elbow, wrist, 1.0 + 0.3 * hand / forearm),
                axis(wrist, elbow),
            ),
        ]);
        let forearms = match posture.forearm_centre_m {
            None => forearms,
            Some([x, z]) => {
                let (_, tensor) = centred(&forearms);
                about_point(forearms[9], [x, 0.0, z], tensor)
            }
        };
        // A.3: centres of mass at 0.607 of the thigh and 0.581 of the shank, from the far end.
        let leg = sum(&[
            UPPER_LEG.placed(grams, between(knee, hip, 0.607), axis(knee, hip)),
            LOWER_LEG.placed(grams, between(ankle, knee, 0.581), axis(ankle, knee)),
            FOOT.placed(
                grams,
                [ankle[0] + 0.04 * h, ankle[1], ankle[2] + 0.7 * ankle_height],
                [1.0, 0.0, 0.0],
            ),
        ]);
        let total = pelvis[9] + trunk[9] + forearms[9] + 2.0 * leg[9];
        let scale = mass_kg / total;
        let scaled = |i: &Inertia<f64>| -> Inertia<f64> { i.map(|v| v * scale) };
        let (leg_centre, leg_tensor) = centred(&scaled(&leg));
        Self {
            rider: Rider {
                pelvis: symmetric(&scaled(&pelvis)),
                trunk: symmetric(&scaled(&trunk)),
                forearms: symmetric(&scaled(&forearms)),
                forearms_on_front: false,
                leg: Leg {
                    mass_kg: leg[9] * scale,
                    x_m: leg_centre[0],
                    y_m: leg_centre[1],
                    z_m: leg_centre[2],
                    inertia_xx_kg_m2: leg_tensor[0],
                    inertia_yy_kg_m2: leg_tensor[1],
                    inertia_zz_kg_m2: leg_tensor[2],
                    inertia_xy_kg_m2: leg_tensor[3],
                    inertia_xz_kg_m2: leg_tensor[4],
                    inertia_yz_kg_m2: leg_tensor[5],
                    hip_x_m: hip[0],
                    hip_y_m: hip[1],
                    hip_z_m: hip[2],
                    ankle_x_m: ankle[0],
                    ankle_y_m: ankle[1],
                    ankle_z_m: ankle[2],
                },
                waist_x_m: waist_at[0],
                waist_z_m: waist_at[2],
            },
            shoulder_m: shoulder,
        }
    }

    /// The whole rider as one rigid body.
    pub fn rigid(&self) -> Body {
        let r = &self.rider;
        let leg = &r.leg;
        let side = |sign: f64| {
            let mut tensor = super::tree::leg_tensor(leg);
            tensor[3] *= sign;
            tensor[5] *= sign;
            about_point(leg.mass_kg, [leg.x_m, sign * leg.y_m, leg.z_m], tensor)
        };
        let body = |b: &Body| about_point(b.mass_kg, [b.x_m, 0.0, b.z_m], b.tensor());
        symmetric(&sum(&[
            body(&r.pelvis),
            body(&r.trunk),
            body(&r.forearms),
            side(1.0),
            side(-1.0),
        ]))
    }
}

#[cfg(test)]
mod tests {
    use super::super::sets::BULSINK_POSTURE;
    use super::*;

    #[test]
    fn the_published_rider_comes_out() {
        let body = RiderBody::new(1.80, 80.0, &BULSINK_POSTURE);
        let whole = body.rigid();
        assert!((whole.mass_kg - 80.0).abs() < 1.0e-12);
        assert!(
            (2.0 * body.rider.forearms.mass_kg / 2.0 - 3.82).abs() < 0.05,
            "{:?}",
            body.rider.forearms
        );
        let near = |ours: f64, printed: f64, tolerance: f64, what: &str| {
            assert!(
                (ours - printed).abs() < tolerance,
                "{what}: {ours} against {printed}"
            );
        };
        println!("{whole:?}");
        near(whole.x_m, 0.39, 0.03, "x");
        near(whole.z_m, -1.06, 0.03, "z");
        near(whole.inertia_xx_kg_m2, 10.4737, 0.25 * 10.4737, "xx");
        near(whole.inertia_yy_kg_m2, 10.9094, 0.25 * 10.9094, "yy");
        near(whole.inertia_zz_kg_m2, 2.17315, 0.40 * 2.17315, "zz");
    }
}
