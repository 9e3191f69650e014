//! What: where a wheel touches the road, how it slips there, and what the tyre gives back.
//!
//! Equation: with n the road normal (down), a the axle (to the right) and γ the camber,
//! sin γ = a·n, the contact point C lies at hub + l d, d = (n - a sin γ) / cos γ, where
//! l = h / cos γ and h is the distance of the hub from the road: the intersection of the road
//! plane, the wheel plane and the plane through the spin axis (Bulsink 2017, figure 3.3). The
//! radial deflection is ρ = R - l and the load N = K ρ / cos γ + B v_n ≥ 0 with v_n the speed of
//! C into the road; the elastic part is the derivative of ½ K ρ². Slip: tan α = v_y / s, κ = (Ω l - v_x) / s, s = √(v_x² + v_0²),
//! with v the velocity of C as a point of fork or frame. With a relaxation length σ the slips are
//! states: σ dα/dt = v_y - |v_x| α.
//!
//! Source: Bulsink (2017), section 3.2.1, figure 3.3; Pacejka (2006), Tyre and Vehicle Dynamics,
//! sections 2.2 and 7.2.1 (relaxation).
//!
//! A bicycle on its side is held by one point of frame and rider at 75° of roll (`lying_wrench`), a
//! guess that only serves to end a fall.
//!
//! Assumes and ignores: a wheel without thickness (the overturning torque stands for it), one
//! point of contact, a road that is plane over the contact patch. Pitch rate counts as speed of C.
//!
//! Valid for: camber up to 75°; beyond it the geometry is frozen so that a fall stays finite.
//!
//! Checked by: energy kept without slip forces (`energy`), tests below.

use super::state::{SLIP, SPIN, STEER_RATE, State};
use super::tree::Tree;
use super::vector::{Vec3, add, axpy, build, cross, dot, scale, sub};
use super::{dynamics::Pose, inertia::Spatial};
use crate::Scalar;
use crate::tyre::{Tyre, TyreInput, TyreModel, TyreOutput};

/// cos² of the largest camber that the contact geometry follows.
const FLATTEST_COS2: f64 = 0.067;

/// Deflection up to which the tyre's spring is followed, m: more than a tyre has. A wheel pushed
/// deeper in a crash is held by the same load.
const DEEPEST_M: f64 = 0.1;
/// Load beyond which a tyre is not followed, N: twenty times that of a rider at rest.
const LARGEST_LOAD_N: f64 = 8.0e3;
/// Longest lever of force about the vertical axis of the contact, m: half a long contact patch.
/// Coefficients that follow load, extrapolated, give more in a crash.
const PATCH_LEVER_M: f64 = 0.05;
/// Where frame and rider touch the ground when they lie on their side: height above the road and
/// half width at rest, m. They touch at 75° of roll.
const LYING_HEIGHT_M: f64 = 0.93;
const LYING_HALF_WIDTH_M: f64 = 0.25;
/// Stiffness, damping and friction of that contact, N/m, N s/m: a body with clothes on asphalt.
const LYING_STIFFNESS_N_M: f64 = 3.0e4;
const LYING_DAMPING_N_S_M: f64 = 2.0e3;
const LYING_FRICTION: f64 = 0.6;

/// The road under a wheel: a plane with friction.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ground<T> {
    /// A point of the plane, world axes, m.
    pub point: Vec3<T>,
    /// Normal, downward, world axes, unit length.
    pub normal: Vec3<T>,
    /// Friction coefficient.
    pub friction: T,
    /// True: the plane at height zero; point and normal need not be looked at.
    pub level: bool,
}

/// Contact geometry of a wheel, in base axes.
#[derive(Clone, Copy, Debug)]
pub(super) struct ContactPoint<T> {
    /// C from the base origin.
    pub arm: Vec3<T>,
    /// Forward, right and down.
    pub forward: Vec3<T>,
    pub right: Vec3<T>,
    pub down: Vec3<T>,
    /// Sine and one over the cosine of camber.
    pub sin_camber: T,
    pub inverse_cos: T,
    /// Distance hub to C.
    pub loaded_radius: T,
    /// Velocity of C as a point of fork or frame.
    pub velocity: Vec3<T>,
}

/// Slip, load and forces of a wheel.
#[derive(Clone, Copy, Debug)]
pub struct WheelContact<T> {
    /// Load of the road, N.
    pub load_n: T,
    /// Radial deflection of the tyre, m; negative off the ground.
    pub deflection_m: T,
    /// Longitudinal slip, driving positive.
    pub slip_ratio: T,
    /// Slip angle, rad, positive when the wheel slides to the right.
    pub slip_angle_rad: T,
    /// Camber, rad, positive to the right.
    pub camber_rad: T,
    /// Forward speed of the contact point, m/s.
    pub speed_m_s: T,
    /// Forces and moments of the tyre.
    pub tyre: TyreOutput<T>,
}

impl<T: Scalar> Ground<T> {
    /// The plane at height zero.
    #[inline(always)]
    pub(super) fn level(friction: T) -> Self {
        let z = T::zero();
        Self {
            point: [z; 3],
            normal: [z, z, T::one()],
            friction,
            level: true,
        }
    }

    /// The normal in base axes.
    #[inline(always)]
    fn down(&self, rotation: &[Vec3<T>; 3]) -> Vec3<T> {
        if self.level {
            rotation[2]
        } else {
            super::vector::columns_times(rotation, self.normal)
        }
    }

    /// How far `position` is above the plane, along its normal.
    #[inline(always)]
    fn below(&self, position: Vec3<T>) -> T {
        if self.level {
            -position[2]
        } else {
            dot(sub(self.point, position), self.normal)
        }
    }
}

/// One over the cosine of camber, held beyond the largest camber that is followed.
#[inline(always)]
fn inverse_cosine<T: Scalar>(sin_camber: T) -> T {
    let cos2 = T::one() - sin_camber * sin_camber;
    T::one() / cos2.max(T::from_f64(FLATTEST_COS2)).sqrt()
}

/// Contact point of the rear wheel: its hub is the origin, its axle the lateral axis.
#[inline(always)]
pub(super) fn rear_point<T: Scalar>(
    v: &Spatial<T>,
    position: Vec3<T>,
    rotation: &[Vec3<T>; 3],
    ground: &Ground<T>,
    rigid_radius: Option<f64>,
) -> ContactPoint<T> {
    let zero = T::zero();
    let down = ground.down(rotation);
    let sin_camber = down[1];
    let inverse_cos = inverse_cosine(sin_camber);
    let forward = [down[2] * inverse_cos, zero, -(down[0] * inverse_cos)];
    let loaded_radius = match rigid_radius {
        Some(radius) => T::from_f64(radius),
        None => ground.below(position) * inverse_cos,
    };
    let lever = loaded_radius * inverse_cos;
    let arm = [lever * down[0], zero, lever * down[2]];
    ContactPoint {
        arm,
        forward,
        right: [
            down[1] * forward[2],
            down[2] * forward[0] - down[0] * forward[2],
            -(down[1] * forward[0]),
        ],
        down,
        sin_camber,
        inverse_cos,
        loaded_radius,
        velocity: [
            v[3] + v[1] * arm[2],
            v[4] + v[2] * arm[0] - v[0] * arm[2],
            v[5] - v[1] * arm[0],
        ],
    }
}

/// Contact point of the front wheel, which turns with the steer joint at `rate`.
#[inline(always)]
fn front_point<T: Scalar>(
    (motion, rate): (&Spatial<f64>, T),
    v: &Spatial<T>,
    position: Vec3<T>,
    pose: &Pose<T>,
    ground: &Ground<T>,
    rigid_radius: Option<f64>,
) -> ContactPoint<T> {
    let (hub, axle) = (pose.front_hub, pose.front_axle);
    let down = ground.down(&pose.rotation);
    let sin_camber = dot(axle, down);
    let inverse_cos = inverse_cosine(sin_camber);
    let radial = scale(sub(down, scale(axle, sin_camber)), inverse_cos);
    let forward = scale(cross(axle, down), inverse_cos);
    let loaded_radius = match rigid_radius {
        Some(radius) => T::from_f64(radius),
        // Height of the hub without its world coordinates.
        None => (ground.below(position) - dot(hub, down)) * inverse_cos,
    };
    let arm = axpy(hub, loaded_radius, radial);
    // The steer axis has no lateral component: its motion at C is written out.
    let by_steer = [
        -(arm[1].scale(motion[2])),
        T::from_f64(motion[4]) + arm[0].scale(motion[2]) - arm[2].scale(motion[0]),
        arm[1].scale(motion[0]),
    ];
    let by_base = add([v[3], v[4], v[5]], cross([v[0], v[1], v[2]], arm));
    ContactPoint {
        arm,
        forward,
        right: cross(down, forward),
        down,
        sin_camber,
        inverse_cos,
        loaded_radius,
        velocity: axpy(by_base, rate, by_steer),
    }
}

/// Both contact points.
#[inline(always)]
pub(super) fn contact_points<T: Scalar>(
    tree: &Tree,
    x: &State<T>,
    pose: &Pose<T>,
    grounds: &[Ground<T>; 2],
    rigid: bool,
) -> [ContactPoint<T>; 2] {
    use super::state::StateAccess;
    let v = x.base_motion();
    let position = [x[0], x[1], x[2]];
    let radius = |k: usize| rigid.then_some(tree.wheels[k].radius);
    let steer = (&tree.steer.motion, x[STEER_RATE]);
    [
        rear_point(&v, position, &pose.rotation, &grounds[0], radius(0)),
        front_point(steer, &v, position, pose, &grounds[1], radius(1)),
    ]
}

/// What the tyre does at a contact point. Writes the derivatives of the relaxed slips: side slip of
/// both wheels, then longitudinal slip.
#[inline(always)]
pub(super) fn tyre_contact<T: Scalar>(
    (wheel, radius): (usize, f64),
    tyre: &Tyre,
    speed_floor: f64,
    at: &ContactPoint<T>,
    x: &State<T>,
    friction: T,
    slip_rates: &mut [T; 4],
) -> WheelContact<T> {
    let zero = T::zero();
    let speed = dot(at.velocity, at.forward);
    let slide = dot(at.velocity, at.right);
    let sink = dot(at.velocity, at.down);
    let deflection = T::from_f64(radius) - at.loaded_radius;
    let vertical = tyre.vertical();
    let spring = deflection
        .min(T::from_f64(DEEPEST_M))
        .scale(vertical.stiffness_n_m);
    let support = spring * at.inverse_cos + sink.scale(vertical.damping_n_s_m);
    let load = deflection.select(support.max(zero).min(T::from_f64(LARGEST_LOAD_N)), zero);

    let floor = T::from_f64(speed_floor);
    let reference = (speed * speed + floor * floor).sqrt();
    let creep = x[SPIN + wheel] * at.loaded_radius - speed;
    let (tangent, ratio) = match tyre.relaxation_length_m() {
        Some(length) => {
            let (tangent, ratio) = (x[SLIP + wheel], x[SLIP + 2 + wheel]);
            slip_rates[wheel] = (slide - reference * tangent).scale(1.0 / length);
            slip_rates[2 + wheel] = (creep - reference * ratio).scale(1.0 / length);
            (tangent, ratio)
        }
        None => {
            let inverse = T::one() / reference;
            (slide * inverse, creep * inverse)
        }
    };
    let camber = (at.sin_camber * at.inverse_cos).atan();
    let slip_angle = tangent.atan();
    let input = TyreInput {
        load_n: load,
        slip_ratio: ratio,
        slip_angle_rad: slip_angle,
        camber_rad: camber,
        speed_m_s: speed,
        friction_ratio: friction,
        radius_m: radius,
    };
    let mut output = tyre.output(&input);
    let most = load.scale(PATCH_LEVER_M);
    output.aligning_nm = output.aligning_nm.clamp(-most, most);
    WheelContact {
        load_n: load,
        deflection_m: deflection,
        slip_ratio: ratio,
        slip_angle_rad: slip_angle,
        camber_rad: camber,
        speed_m_s: speed,
        tyre: output,
    }
}

/// Wrench about the base origin (base axes) and torque that speeds up the wheel.
#[inline(always)]
pub(super) fn wheel_wrench<T: Scalar>(
    at: &ContactPoint<T>,
    axle: Vec3<T>,
    c: &WheelContact<T>,
) -> (Spatial<T>, T) {
    let t = &c.tyre;
    let force: Vec3<T> = build(|k| {
        at.forward[k] * t.longitudinal_n + at.right[k] * t.lateral_n - at.down[k] * c.load_n
    });
    let turn = cross(at.arm, force);
    let moment: Vec3<T> = build(|k| {
        turn[k]
            + at.down[k] * t.aligning_nm
            + at.forward[k] * t.overturning_nm
            + axle[k] * t.rolling_resistance_nm
    });
    let spin = -(t.longitudinal_n * at.loaded_radius
        + t.aligning_nm * at.sin_camber
        + t.rolling_resistance_nm);
    (
        [
            moment[0], moment[1], moment[2], force[0], force[1], force[2],
        ],
        spin,
    )
}

/// Wrench of the ground on frame and rider lying on their side, so that a fall ends. Zero upright.
#[inline(always)]
pub(super) fn lying_wrench<T: Scalar>(
    tree: &Tree,
    x: &State<T>,
    pose: &Pose<T>,
    ground: &Ground<T>,
) -> Spatial<T> {
    use super::state::StateAccess;
    let down = ground.down(&pose.rotation);
    let z = T::zero();
    // The side that is lower.
    let width = T::from_f64(LYING_HALF_WIDTH_M);
    let at = [
        T::from_f64(tree.lying_x),
        down[1].select(width, -width),
        T::from_f64(-tree.origin[2] - LYING_HEIGHT_M),
    ];
    let position = [x[0], x[1], x[2]];
    let depth = dot(at, down) - ground.below(position);
    let v = x.base_motion();
    let speed = add([v[3], v[4], v[5]], cross([v[0], v[1], v[2]], at));
    let sink = dot(speed, down);
    let load = depth.select(
        (depth.scale(LYING_STIFFNESS_N_M) + sink.scale(LYING_DAMPING_N_S_M)).max(z),
        z,
    );
    let slide = sub(speed, scale(down, sink));
    // Friction turns over smoothly at 0.1 m/s.
    let grip = load.scale(LYING_FRICTION) / (dot(slide, slide) + T::from_f64(0.01)).sqrt();
    let force: Vec3<T> = build(|k| -(down[k] * load) - slide[k] * grip);
    let turn = cross(at, force);
    [turn[0], turn[1], turn[2], force[0], force[1], force[2]]
}
