//! What: several numbers side by side, so that one run of the physics serves `N` scenarios.
//!
//! Equation: every operation on each lane by itself. Sine, cosine and arc tangent are the
//! polynomials of fdlibm without its branches.
//!
//! Source: fdlibm 5.3 (Sun Microsystems, 1993): k_sin, k_cos, s_atan, e_exp.
//!
//! Assumes and ignores: arguments of sine and cosine below 1e5 in magnitude.
//!
//! Valid for: N of 2, 4 or 8; other numbers work, without gain.
//!
//! Checked by: `lanes_agree_with_libm` (1 unit in the last place for sine, cosine, arc tangent,
//! exponential).

use crate::scalar::Scalar;
use core::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

/// `N` numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(align(32))]
pub struct Lanes<const N: usize>(pub [f64; N]);

macro_rules! lanewise {
    ($($trait:ident $method:ident $op:tt),*) => {$(
        impl<const N: usize> $trait for Lanes<N> {
            type Output = Self;
            #[inline(always)]
            fn $method(mut self, other: Self) -> Self {
                for k in 0..N {
                    self.0[k] = self.0[k] $op other.0[k];
                }
                self
            }
        }
    )*};
}

lanewise!(Add add +, Sub sub -, Mul mul *, Div div /);

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
        for k in 0..N {
            self.0[k] = f(self.0[k]);
        }
        self
    }
}

/// Adding and subtracting this rounds to the nearest integer, whose low bits are then those of
/// the sum.
const ROUNDER: f64 = 6_755_399_441_055_744.0;

/// Sine and cosine without branches.
#[inline(always)]
fn sin_cos(x: f64) -> (f64, f64) {
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
    let turned = x * core::f64::consts::FRAC_2_PI + ROUNDER;
    let quadrant = turned.to_bits();
    let k = turned - ROUNDER;
    let head = x - k * PIO2_1;
    let tail = k * PIO2_1T;
    let r = head - tail;
    let rest = (head - r) - tail;
    let z = r * r;
    let w = z * z;
    let v = z * r;
    let ps = S[1] + z * (S[2] + z * S[3]) + z * w * (S[4] + z * S[5]);
    let sine = r - ((z * (0.5 * rest - v * ps) - rest) - v * S[0]);
    let pc = z * (C[0] + z * (C[1] + z * C[2])) + w * w * (C[3] + z * (C[4] + z * C[5]));
    let hz = 0.5 * z;
    let one = 1.0 - hz;
    let cosine = one + (((1.0 - one) - hz) + (z * pc - r * rest));
    let swap = (quadrant & 1).wrapping_neg();
    let (sb, cb) = (sine.to_bits(), cosine.to_bits());
    let s = (sb & !swap) | (cb & swap);
    let c = (cb & !swap) | (sb & swap);
    let s_sign = (quadrant & 2) << 62;
    let c_sign = (quadrant.wrapping_add(1) & 2) << 62;
    (f64::from_bits(s ^ s_sign), f64::from_bits(c ^ c_sign))
}

/// Arc tangent without branches.
#[inline(always)]
fn atan(x: f64) -> f64 {
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
    let a = x.abs();
    let pick = |from: f64, then: f64, otherwise: f64| if a >= from { then } else { otherwise };
    let (p, q, r, s) = (0.4375, 0.6875, 1.1875, 2.4375);
    let numerator = pick(
        s,
        -1.0,
        pick(r, a - 1.5, pick(q, a - 1.0, pick(p, 2.0 * a - 1.0, a))),
    );
    let denominator = pick(
        s,
        a,
        pick(r, 1.0 + 1.5 * a, pick(q, a + 1.0, pick(p, 2.0 + a, 1.0))),
    );
    let high = pick(
        s,
        1.570_796_326_794_896_558_00,
        pick(
            r,
            9.827_937_232_473_290_540_82e-01,
            pick(
                q,
                7.853_981_633_974_482_789_99e-01,
                pick(p, 4.636_476_090_008_060_935_15e-01, 0.0),
            ),
        ),
    );
    let low = pick(
        s,
        6.123_233_995_736_766_035_87e-17,
        pick(
            r,
            1.390_331_103_123_099_845_16e-17,
            pick(
                q,
                3.061_616_997_868_383_017_93e-17,
                pick(p, 2.269_877_745_296_168_709_24e-17, 0.0),
            ),
        ),
    );
    let t = numerator / denominator;
    let z = t * t;
    let w = z * z;
    let s1 = z * (A[0] + w * (A[2] + w * (A[4] + w * (A[6] + w * (A[8] + w * A[10])))));
    let s2 = w * (A[1] + w * (A[3] + w * (A[5] + w * (A[7] + w * A[9]))));
    let y = high - ((t * (s1 + s2) - low) - t);
    f64::from_bits(y.to_bits() ^ (x.to_bits() & (1 << 63)))
}

/// Exponential without branches, held within the range of finite results.
#[inline(always)]
fn exp(x: f64) -> f64 {
    const P: [f64; 5] = [
        1.666_666_666_666_660_190_37e-01,
        -2.777_777_777_701_559_338_42e-03,
        6.613_756_321_437_934_361_17e-05,
        -1.653_390_220_546_525_153_90e-06,
        4.138_136_797_057_238_460_39e-08,
    ];
    let x = if x > 708.0 { 708.0 } else { x };
    let x = if x < -708.0 { -708.0 } else { x };
    let turned = x * core::f64::consts::LOG2_E + ROUNDER;
    let k = turned - ROUNDER;
    let high = x - k * 6.931_471_803_691_238_164_90e-01;
    let low = k * 1.908_214_929_270_587_700_02e-10;
    let r = high - low;
    let z = r * r;
    let c = r - z * (P[0] + z * (P[1] + z * (P[2] + z * (P[3] + z * P[4]))));
    let y = 1.0 + (r * c / (2.0 - c) - low + high);
    // The low bits of the rounder's sum are k: shifted into the exponent they scale by 2^k.
    f64::from_bits(y.to_bits().wrapping_add(turned.to_bits() << 52))
}

impl<const N: usize> Scalar for Lanes<N> {
    #[inline(always)]
    fn from_f64(value: f64) -> Self {
        Self([value; N])
    }
    #[inline(always)]
    fn value(self) -> f64 {
        self.0[0]
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        // Correctly rounded by definition, so the hardware's is the same as libm's.
        self.map(f64::sqrt)
    }
    #[inline(always)]
    fn sin_cos(self) -> (Self, Self) {
        let (mut s, mut c) = (self, self);
        for k in 0..N {
            (s.0[k], c.0[k]) = sin_cos(self.0[k]);
        }
        (s, c)
    }
    #[inline(always)]
    fn atan(self) -> Self {
        self.map(atan)
    }
    #[inline(always)]
    fn atan2(mut self, x: Self) -> Self {
        for k in 0..N {
            self.0[k] = libm::atan2(self.0[k], x.0[k]);
        }
        self
    }
    #[inline(always)]
    fn exp(self) -> Self {
        self.map(exp)
    }
    #[inline(always)]
    fn tanh(self) -> Self {
        self.map(libm::tanh)
    }
    #[inline(always)]
    fn select(self, then: Self, otherwise: Self) -> Self {
        let mut out = otherwise;
        for k in 0..N {
            out.0[k] = if self.0[k] > 0.0 {
                then.0[k]
            } else {
                otherwise.0[k]
            };
        }
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
            let (s, c) = sin_cos(x);
            let (ls, lc) = libm::sincos(x);
            worst[0] = worst[0].max(units(s, ls));
            worst[1] = worst[1].max(units(c, lc));
            worst[2] = worst[2].max(units(atan(x), libm::atan(x)));
            worst[3] = worst[3].max(units(exp(x), libm::exp(x)));
        }
        println!("units in the last place: {worst:?}");
        assert!(worst.iter().all(|w| *w <= 1.0), "{worst:?}");
        assert_eq!(exp(0.0), 1.0);
        assert_eq!(atan(0.0), 0.0);
        assert!((atan(1.0e9) - core::f64::consts::FRAC_PI_2).abs() < 2.0e-9);
    }
}
