//! What: several numbers side by side, so that one run of the physics serves `N` scenarios.
//!
//! Equation: every operation on each lane by itself. Sine, cosine and arc tangent are the
//! polynomials of fdlibm without its branches.
//!
//! Source: fdlibm 5.3 (Sun Microsystems, 1993): k_sin, k_cos, s_atan, e_exp.
//!
//! Assumes and ignores: arguments of sine and cosine below 1e5 in magnitude.
//!
//! Valid for: N of 2, 4 or 8; other numbers up to 8 work, without gain.
//!
//! Checked by: `lanes_agree_with_libm` (1 unit in the last place for sine, cosine, arc tangent,
//! exponential).

// Constants keep the digits of their source.
#![allow(clippy::excessive_precision)]

use crate::scalar::Scalar;
use core::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

/// `N` numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(align(32))]
pub struct Lanes<const N: usize>(pub [f64; N]);

/// Does `$body` for each `$k` below `N`, written out: thousands of short loops in one function take
/// the compiler minutes to unroll.
macro_rules! each_lane {
    ($k:ident, $body:expr) => {
        each_lane!(@ $k, $body, 0 1 2 3 4 5 6 7)
    };
    (@ $k:ident, $body:expr, $($lane:literal)*) => {$(
        if N > $lane {
            const $k: usize = $lane;
            $body;
        }
    )*};
}

macro_rules! lanewise {
    ($($trait:ident $method:ident $op:tt),*) => {$(
        impl<const N: usize> $trait for Lanes<N> {
            type Output = Self;
            #[inline(always)]
            fn $method(mut self, other: Self) -> Self {
                each_lane!(K, self.0[K] $op other.0[K]);
                self
            }
        }
    )*};
}

lanewise!(Add add +=, Sub sub -=, Mul mul *=, Div div /=);

impl<const N: usize> AddAssign for Lanes<N> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl<const N: usize> SubAssign for Lanes<N> {
    #[inline(always)]
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}

impl<const N: usize> Neg for Lanes<N> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        self.map(|a| -a)
    }
}

impl<const N: usize> Lanes<N> {
    #[inline(always)]
    fn map(mut self, f: impl Fn(f64) -> f64) -> Self {
        each_lane!(K, self.0[K] = f(self.0[K]));
        self
    }
}

/// Adding and subtracting this rounds to the nearest integer, whose low bits are then those of
/// the sum.
const ROUNDER: f64 = 6_755_399_441_055_744.0;

/// Numbers side by side whose bits can be got at: what the functions below are made of.
pub(crate) trait Side: Scalar {
    /// Bit operations lane by lane.
    fn bits(self, other: Self, f: impl Fn(u64, u64) -> u64) -> Self;
}

impl<const N: usize> Side for Lanes<N> {
    #[inline(always)]
    fn bits(mut self, other: Self, f: impl Fn(u64, u64) -> u64) -> Self {
        each_lane!(
            K,
            self.0[K] = f64::from_bits(f(self.0[K].to_bits(), other.0[K].to_bits()))
        );
        self
    }
}

/// Horner's scheme, constant first, at most six coefficients.
#[inline(always)]
fn polynomial<V: Side, const C: usize>(z: V, c: [f64; C]) -> V {
    let mut sum = V::from_f64(c[C - 1]);
    macro_rules! terms {
        ($($k:literal)*) => {$(
            if C > $k + 1 {
                sum = V::from_f64(c[$k]) + z * sum;
            }
        )*};
    }
    terms!(4 3 2 1 0);
    sum
}

/// Sine and cosine without branches.
#[inline(always)]
pub(crate) fn sin_cos<V: Side>(x: V) -> (V, V) {
    const PIO2_1: f64 = 1.570_796_326_734_125_614_17;
    const PIO2_1T: f64 = 6.077_100_506_506_192_249_32e-11;
    const S: [f64; 6] = [
        -1.666_666_666_666_663_243_48e-01,
        8.333_333_333_322_489_461_24e-03,
        -1.984_126_982_985_794_931_34e-04,
        2.755_731_370_707_006_767_89e-06,
        -2.505_076_025_340_686_341_95e-08,
        1.589_690_995_211_550_102_21e-10,
    ];
    const C: [f64; 6] = [
        4.166_666_666_666_660_190_37e-02,
        -1.388_888_888_887_410_957_49e-03,
        2.480_158_728_947_672_941_78e-05,
        -2.755_731_435_139_066_330_35e-07,
        2.087_572_321_298_174_827_90e-09,
        -1.135_964_755_778_819_482_65e-11,
    ];
    let one = V::from_f64(1.0);
    let quadrant = x.scale(core::f64::consts::FRAC_2_PI) + V::from_f64(ROUNDER);
    let k = quadrant - V::from_f64(ROUNDER);
    let head = x - k.scale(PIO2_1);
    let tail = k.scale(PIO2_1T);
    let r = head - tail;
    let rest = (head - r) - tail;
    let z = r * r;
    let w = z * z;
    let v = z * r;
    let ps = polynomial(z, [S[1], S[2], S[3]]) + z * w * polynomial(z, [S[4], S[5]]);
    let sine = r - ((z * (rest.scale(0.5) - v * ps) - rest) - v.scale(S[0]));
    let pc = z * polynomial(z, [C[0], C[1], C[2]]) + w * w * polynomial(z, [C[3], C[4], C[5]]);
    let hz = z.scale(0.5);
    let top = one - hz;
    let cosine = top + (((one - top) - hz) + (z * pc - r * rest));
    // Odd quadrants exchange the two; signs follow the quadrant.
    let both = sine.bits(cosine, |s, c| s ^ c);
    let swapped = both.bits(quadrant, |b, q| b & (q & 1).wrapping_neg());
    let s = sine.bits(swapped, |a, b| a ^ b);
    let c = cosine.bits(swapped, |a, b| a ^ b);
    (
        s.bits(quadrant, |a, q| a ^ ((q & 2) << 62)),
        c.bits(quadrant, |a, q| a ^ ((q.wrapping_add(1) & 2) << 62)),
    )
}

/// Arc tangent without branches.
#[inline(always)]
pub(crate) fn atan<V: Side>(x: V) -> V {
    const A: [f64; 11] = [
        3.333_333_333_333_293_180_27e-01,
        -1.999_999_999_987_648_324_76e-01,
        1.428_571_427_250_346_637_11e-01,
        -1.111_111_040_546_235_578_80e-01,
        9.090_887_133_436_506_561_96e-02,
        -7.691_876_205_044_829_994_95e-02,
        6.661_073_137_387_531_206_69e-02,
        -5.833_570_133_790_573_486_45e-02,
        4.976_877_994_615_932_360_17e-02,
        -3.653_157_274_421_691_552_70e-02,
        1.628_582_011_536_578_236_23e-02,
    ];
    let c = |v: f64| V::from_f64(v);
    let one = c(1.0);
    let a = x.bits(x, |v, _| v & !(1 << 63));
    // The argument is reduced about 0, 1/2, 1, 3/2 or infinity.
    let (near_half, near_one) = (a - c(0.4375), a - c(0.6875));
    let (near_three_halves, far) = (a - c(1.1875), a - c(2.4375));
    let numerator = near_half.select(a + a - one, a);
    let numerator = near_one.select(a - one, numerator);
    let numerator = near_three_halves.select(a - c(1.5), numerator);
    let numerator = far.select(c(-1.0), numerator);
    let denominator = near_half.select(c(2.0) + a, one);
    let denominator = near_one.select(a + one, denominator);
    let denominator = near_three_halves.select(one + a.scale(1.5), denominator);
    let denominator = far.select(a, denominator);
    let high = near_half.select(c(4.636_476_090_008_060_935_15e-01), c(0.0));
    let high = near_one.select(c(core::f64::consts::FRAC_PI_4), high);
    let high = near_three_halves.select(c(9.827_937_232_473_290_540_82e-01), high);
    let high = far.select(c(core::f64::consts::FRAC_PI_2), high);
    let low = near_half.select(c(2.269_877_745_296_168_709_24e-17), c(0.0));
    let low = near_one.select(c(3.061_616_997_868_383_017_93e-17), low);
    let low = near_three_halves.select(c(1.390_331_103_123_099_845_16e-17), low);
    let low = far.select(c(6.123_233_995_736_766_035_87e-17), low);
    let t = numerator / denominator;
    let z = t * t;
    let w = z * z;
    let s1 = z * polynomial(w, [A[0], A[2], A[4], A[6], A[8], A[10]]);
    let s2 = w * polynomial(w, [A[1], A[3], A[5], A[7], A[9]]);
    let y = high - ((t * (s1 + s2) - low) - t);
    y.bits(x, |a, b| a ^ (b & (1 << 63)))
}

/// Exponential without branches, held within the range of finite results.
#[inline(always)]
pub(crate) fn exp<V: Side>(x: V) -> V {
    const P: [f64; 5] = [
        1.666_666_666_666_660_190_37e-01,
        -2.777_777_777_701_559_338_42e-03,
        6.613_756_321_437_934_361_17e-05,
        -1.653_390_220_546_525_153_90e-06,
        4.138_136_797_057_238_460_39e-08,
    ];
    let c = |v: f64| V::from_f64(v);
    let x = x.clamp(c(-708.0), c(708.0));
    let turned = x.scale(core::f64::consts::LOG2_E) + c(ROUNDER);
    let k = turned - c(ROUNDER);
    let high = x - k.scale(6.931_471_803_691_238_164_90e-01);
    let low = k.scale(1.908_214_929_270_587_700_02e-10);
    let r = high - low;
    let z = r * r;
    let q = r - z * polynomial(z, P);
    let y = c(1.0) + (r * q / (c(2.0) - q) - low + high);
    // The low bits of the rounder's sum are k: shifted into the exponent they scale by 2^k.
    y.bits(turned, |a, b| a.wrapping_add(b << 52))
}

impl<const N: usize> Scalar for Lanes<N> {
    #[inline(always)]
    fn from_f64(value: f64) -> Self {
        const { assert!(N <= 8, "at most eight lanes") };
        Self([value; N])
    }
    #[inline(always)]
    fn value(self) -> f64 {
        self.0[0]
    }
    #[inline(always)]
    fn largest(self) -> f64 {
        self.0.into_iter().fold(f64::NEG_INFINITY, f64::max)
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        // Correctly rounded by definition, so the hardware's is the same as libm's.
        self.map(f64::sqrt)
    }
    #[inline(always)]
    fn sin_cos(self) -> (Self, Self) {
        sin_cos(self)
    }
    #[inline(always)]
    fn atan(self) -> Self {
        atan(self)
    }
    #[inline(always)]
    fn atan2(mut self, x: Self) -> Self {
        each_lane!(K, self.0[K] = libm::atan2(self.0[K], x.0[K]));
        self
    }
    #[inline(always)]
    fn exp(self) -> Self {
        exp(self)
    }
    #[inline(always)]
    fn tanh(self) -> Self {
        self.map(libm::tanh)
    }
    #[inline(always)]
    fn select(self, then: Self, otherwise: Self) -> Self {
        let mut out = otherwise;
        each_lane!(
            K,
            if self.0[K] > 0.0 {
                out.0[K] = then.0[K]
            }
        );
        out
    }
    #[inline(always)]
    fn scale(self, factor: f64) -> Self {
        self.map(|a| a * factor)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Distance in units of the last place of `b`.
    fn units(a: f64, b: f64) -> f64 {
        let ulp = f64::from_bits(b.abs().max(f64::MIN_POSITIVE).to_bits() + 1)
            - b.abs().max(f64::MIN_POSITIVE);
        (a - b).abs() / ulp
    }

    #[test]
    fn lanes_agree_with_libm() {
        let mut worst = [0.0_f64; 4];
        for k in -200_000_i32..200_000 {
            let x = f64::from(k) * 3.217e-4;
            let lane = Lanes([x; 2]);
            let (s, c) = lane.sin_cos();
            let (s, c) = (s.value(), c.value());
            let (ls, lc) = libm::sincos(x);
            worst[0] = worst[0].max(units(s, ls));
            worst[1] = worst[1].max(units(c, lc));
            worst[2] = worst[2].max(units(lane.atan().value(), libm::atan(x)));
            worst[3] = worst[3].max(units(lane.exp().value(), libm::exp(x)));
        }
        println!("units in the last place: {worst:?}");
        assert!(worst.iter().all(|w| *w <= 1.0), "{worst:?}");
        assert_eq!(Lanes([0.0; 2]).exp().value(), 1.0);
        assert_eq!(Lanes([0.0; 2]).atan().value(), 0.0);
        assert!((Lanes([1.0e9; 2]).atan().value() - core::f64::consts::FRAC_PI_2).abs() < 2.0e-9);
    }
}
