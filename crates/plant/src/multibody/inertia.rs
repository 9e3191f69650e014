//! Inertia of a rigid body about a point that need not be its centre of mass: second moment,
//! first moment and mass, ten numbers.

use super::vector::{Vec3, cross};
use crate::Scalar;

/// `[Jxx, Jyy, Jzz, Jxy, Jxz, Jyz, hx, hy, hz, m]`: the inertia tensor about the reference point
/// (kg m², off-diagonal entries as in the tensor, so `Jxz = -∫xz dm`), mass times centre of mass
/// (kg m) and mass (kg).
pub type Inertia<T> = [T; 10];

/// A motion (angular, linear at the reference point) or a wrench (moment about the reference
/// point, force).
pub type Spatial<T> = [T; 6];

/// Inertia of a body with mass `m`, centre of mass `c` and tensor `j` (xx, yy, zz, xy, xz, yz)
/// about its centre of mass.
pub fn about_point(m: f64, c: [f64; 3], j: [f64; 6]) -> Inertia<f64> {
    let [x, y, z] = c;
    [
        j[0] + m * (y * y + z * z),
        j[1] + m * (x * x + z * z),
        j[2] + m * (x * x + y * y),
        j[3] - m * x * y,
        j[4] - m * x * z,
        j[5] - m * y * z,
        m * x,
        m * y,
        m * z,
        m,
    ]
}

/// The same body rotated by `r` (rows) about the line through `p`, reference point at the origin.
pub fn rotated(i: &Inertia<f64>, r: &[[f64; 3]; 3], p: [f64; 3]) -> Inertia<f64> {
    let m = i[9];
    if m == 0.0 && i[..6].iter().all(|v| *v == 0.0) {
        return [0.0; 10];
    }
    let mass = if m == 0.0 { 1.0 } else { m };
    let c = [i[6] / mass, i[7] / mass, i[8] / mass];
    let shift = about_point(-m, c, [0.0; 6]);
    let j: [f64; 6] = core::array::from_fn(|k| i[k] + shift[k]);
    let full = [[j[0], j[3], j[4]], [j[3], j[1], j[5]], [j[4], j[5], j[2]]];
    let entry = |a: usize, b: usize| {
        let mut sum = 0.0;
        for k in 0..3 {
            for l in 0..3 {
                sum += r[a][k] * full[k][l] * r[b][l];
            }
        }
        sum
    };
    let turned = [
        entry(0, 0),
        entry(1, 1),
        entry(2, 2),
        entry(0, 1),
        entry(0, 2),
        entry(1, 2),
    ];
    let arm = [c[0] - p[0], c[1] - p[1], c[2] - p[2]];
    let centre =
        core::array::from_fn(|k| p[k] + r[k][0] * arm[0] + r[k][1] * arm[1] + r[k][2] * arm[2]);
    about_point(m, centre, turned)
}

/// Sum of bodies about the same point.
pub fn sum(bodies: &[Inertia<f64>]) -> Inertia<f64> {
    bodies
        .iter()
        .fold([0.0; 10], |a, b| core::array::from_fn(|i| a[i] + b[i]))
}

/// Inertia tensor times a vector.
#[inline(always)]
pub fn tensor_times<T: Scalar>(i: &Inertia<T>, w: Vec3<T>) -> Vec3<T> {
    [
        i[0] * w[0] + i[3] * w[1] + i[4] * w[2],
        i[3] * w[0] + i[1] * w[1] + i[5] * w[2],
        i[4] * w[0] + i[5] * w[1] + i[2] * w[2],
    ]
}

/// Momentum (angular about the reference point, linear) of a body that moves with `v`.
#[inline(always)]
pub fn momentum<T: Scalar>(i: &Inertia<T>, v: &Spatial<T>) -> Spatial<T> {
    let mut h = momentum_without_mass(i, v);
    for k in 3..6 {
        h[k] += i[9] * v[k];
    }
    h
}

/// The same for a body whose mass is zero: the change of an inertia when a part turns.
#[inline(always)]
pub fn momentum_without_mass<T: Scalar>(i: &Inertia<T>, v: &Spatial<T>) -> Spatial<T> {
    let (w, u) = ([v[0], v[1], v[2]], [v[3], v[4], v[5]]);
    let h = [i[6], i[7], i[8]];
    let angular = tensor_times(i, w);
    let from_linear = cross(h, u);
    let from_angular = cross(w, h);
    [
        angular[0] + from_linear[0],
        angular[1] + from_linear[1],
        angular[2] + from_linear[2],
        from_angular[0],
        from_angular[1],
        from_angular[2],
    ]
}

/// Rate of change, in a frame that moves with `v`, that momentum `h` must have to stay constant
/// in space: (ω × L + v × p, ω × p).
#[inline(always)]
pub fn transported<T: Scalar>(v: &Spatial<T>, h: &Spatial<T>) -> Spatial<T> {
    let (w, u) = ([v[0], v[1], v[2]], [v[3], v[4], v[5]]);
    let (l, p) = ([h[0], h[1], h[2]], [h[3], h[4], h[5]]);
    let a = cross(w, l);
    let b = cross(u, p);
    let c = cross(w, p);
    [a[0] + b[0], a[1] + b[1], a[2] + b[2], c[0], c[1], c[2]]
}

/// Power of a wrench on a motion.
#[inline(always)]
pub fn power<T: Scalar>(v: &Spatial<T>, f: &Spatial<T>) -> T {
    v[0] * f[0] + v[1] * f[1] + v[2] * f[2] + v[3] * f[3] + v[4] * f[4] + v[5] * f[5]
}
