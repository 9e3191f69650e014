//! Vectors and rotations in three dimensions, over any [`Scalar`].

use crate::Scalar;

/// Three components.
pub type Vec3<T> = [T; 3];

/// An array from its entries. Written out as a loop, so that it is compiled into its caller with
/// the caller's instruction set.
#[inline(always)]
pub fn build<T: Scalar, const N: usize>(entry: impl Fn(usize) -> T) -> [T; N] {
    let mut out = [T::zero(); N];
    for k in 0..N {
        out[k] = entry(k);
    }
    out
}

/// A constant vector.
#[inline(always)]
pub fn lift<T: Scalar, const N: usize>(a: &[f64; N]) -> [T; N] {
    build(|i| T::from_f64(a[i]))
}

#[inline(always)]
pub fn add<T: Scalar, const N: usize>(a: [T; N], b: [T; N]) -> [T; N] {
    build(|i| a[i] + b[i])
}

#[inline(always)]
pub fn sub<T: Scalar, const N: usize>(a: [T; N], b: [T; N]) -> [T; N] {
    build(|i| a[i] - b[i])
}

#[inline(always)]
pub fn scale<T: Scalar, const N: usize>(a: [T; N], k: T) -> [T; N] {
    build(|i| a[i] * k)
}

/// `a + k b`.
#[inline(always)]
pub fn axpy<T: Scalar, const N: usize>(a: [T; N], k: T, b: [T; N]) -> [T; N] {
    build(|i| a[i] + k * b[i])
}

#[inline(always)]
pub fn dot<T: Scalar>(a: Vec3<T>, b: Vec3<T>) -> T {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
pub fn cross<T: Scalar>(a: Vec3<T>, b: Vec3<T>) -> Vec3<T> {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

/// Cross product of constant vectors.
pub fn cross_const(a: &[f64; 3], b: &[f64; 3]) -> [f64; 3] {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

/// Rotation from base axes to world axes of the quaternion (w, x, y, z), of any length > 0: rows
/// are world axes in base components.
#[inline(always)]
pub fn rotation<T: Scalar>(q: &[T; 4]) -> [Vec3<T>; 3] {
    let [w, x, y, z] = *q;
    let s = T::from_f64(2.0) / (w * w + x * x + y * y + z * z);
    let one = T::one();
    let (xs, ys, zs) = (x * s, y * s, z * s);
    let (wx, wy, wz) = (w * xs, w * ys, w * zs);
    let (xx, xy, xz) = (x * xs, x * ys, x * zs);
    let (yy, yz, zz) = (y * ys, y * zs, z * zs);
    [
        [one - (yy + zz), xy - wz, xz + wy],
        [xy + wz, one - (xx + zz), yz - wx],
        [xz - wy, yz + wx, one - (xx + yy)],
    ]
}

/// Matrix, given by rows, times vector.
#[inline(always)]
pub fn rows_times<T: Scalar>(rows: &[Vec3<T>; 3], v: Vec3<T>) -> Vec3<T> {
    [dot(rows[0], v), dot(rows[1], v), dot(rows[2], v)]
}

/// Transpose of a matrix, given by rows, times vector.
#[inline(always)]
pub fn columns_times<T: Scalar>(rows: &[Vec3<T>; 3], v: Vec3<T>) -> Vec3<T> {
    build(|i| rows[0][i] * v[0] + rows[1][i] * v[1] + rows[2][i] * v[2])
}

/// Quaternion (w, x, y, z) of yaw, then roll, then pitch (the 3-1-2 sequence of Meijaard et al.
/// 2007).
pub fn quaternion<T: Scalar>(yaw_rad: T, roll_rad: T, pitch_rad: T) -> [T; 4] {
    let (sy, cy) = yaw_rad.scale(0.5).sin_cos();
    let (sr, cr) = roll_rad.scale(0.5).sin_cos();
    let (sp, cp) = pitch_rad.scale(0.5).sin_cos();
    // q_yaw (cy, 0, 0, sy) times q_roll (cr, sr, 0, 0) times q_pitch (cp, 0, sp, 0).
    let (w, x, y, z) = (cy * cr, cy * sr, sy * sr, sy * cr);
    [
        w * cp - y * sp,
        x * cp - z * sp,
        w * sp + y * cp,
        x * sp + z * cp,
    ]
}

/// Yaw, roll and pitch of a rotation from base to world (rows). Roll in [-π/2, π/2].
pub fn yaw_roll_pitch<T: Scalar>(r: &[Vec3<T>; 3]) -> (T, T, T) {
    // R = Rz(yaw) Rx(roll) Ry(pitch): column y of R is (-sin yaw cos roll, cos yaw cos roll,
    // sin roll), row z is (-cos roll sin pitch, sin roll, cos roll cos pitch).
    let cos_roll = (r[0][1].squared() + r[1][1].squared()).sqrt();
    (
        (-r[0][1]).atan2(r[1][1]),
        r[2][1].atan2(cos_roll),
        (-r[2][0]).atan2(r[2][2]),
    )
}
