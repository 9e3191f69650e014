//! What: several numbers side by side in AVX registers, for one run of the physics: [`Registers`] of
//! four numbers (AVX2), [`Wide`] of eight (AVX-512).
//!
//! Equation: as in `lanes`, operation by operation: the same bits. The compiler packs plain lanes
//! into registers as it sees fit, which with thousands of them in one function is not well; here
//! every operation is one instruction per register.
//!
//! Source: as in `lanes`.
//!
//! Assumes and ignores: a processor with AVX2 or AVX-512. Values exist only inside functions of
//! `batch` that have looked first.
//!
//! Valid for: as `lanes`.
//!
//! Checked by: `lanes_in_registers_give_the_same_bits` in `multibody/tests`.

use crate::lanes::{Lanes, Side, atan, exp, sin_cos};
use crate::scalar::Scalar;
use core::arch::x86_64::*;
use core::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

/// Four times `M` numbers.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Registers<const M: usize>([__m256d; M]);

/// Does the same with each register.
macro_rules! each {
    ($k:ident, $body:expr) => {{
        if M > 0 {
            const $k: usize = 0;
            $body;
        }
        if M > 1 {
            const $k: usize = 1;
            $body;
        }
    }};
}

macro_rules! registerwise {
    ($($trait:ident $method:ident $op:ident),*) => {$(
        impl<const M: usize> $trait for Registers<M> {
            type Output = Self;
            #[inline(always)]
            fn $method(mut self, other: Self) -> Self {
                // SAFETY: the processor has AVX2, see above.
                each!(K, self.0[K] = unsafe { $op(self.0[K], other.0[K]) });
                self
            }
        }
    )*};
}

registerwise!(Add add _mm256_add_pd, Sub sub _mm256_sub_pd, Mul mul _mm256_mul_pd, Div div _mm256_div_pd);

impl<const M: usize> AddAssign for Registers<M> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl<const M: usize> SubAssign for Registers<M> {
    #[inline(always)]
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}

impl<const M: usize> Neg for Registers<M> {
    type Output = Self;
    #[inline(always)]
    fn neg(mut self) -> Self {
        // SAFETY: the processor has AVX2, see above.
        each!(
            K,
            self.0[K] = unsafe { _mm256_xor_pd(self.0[K], _mm256_set1_pd(-0.0)) }
        );
        self
    }
}

/// Four numbers of a register.
#[inline(always)]
fn numbers(register: __m256d) -> [f64; 4] {
    // SAFETY: four numbers of 64 bits each, any bits are valid.
    unsafe { core::mem::transmute(register) }
}

#[inline(always)]
fn register(numbers: [f64; 4]) -> __m256d {
    // SAFETY: as above.
    unsafe { core::mem::transmute(numbers) }
}

impl<const M: usize> Registers<M> {
    /// From lanes; there must be four times `M` of them.
    #[inline(always)]
    pub(crate) fn from_lanes<const N: usize>(lanes: Lanes<N>) -> Self {
        assert_eq!(N, 4 * M);
        Self(core::array::from_fn(|m| {
            register(core::array::from_fn(|k| lanes.0[4 * m + k]))
        }))
    }

    /// Back to lanes.
    #[inline(always)]
    pub(crate) fn to_lanes<const N: usize>(self) -> Lanes<N> {
        assert_eq!(N, 4 * M);
        Lanes(core::array::from_fn(|k| numbers(self.0[k / 4])[k % 4]))
    }

    /// Number by number.
    #[inline(always)]
    fn each_number(mut self, other: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        each!(K, {
            let (a, b) = (numbers(self.0[K]), numbers(other.0[K]));
            self.0[K] = register([f(a[0], b[0]), f(a[1], b[1]), f(a[2], b[2]), f(a[3], b[3])]);
        });
        self
    }
}

impl<const M: usize> Side for Registers<M> {
    #[inline(always)]
    fn bits(self, other: Self, f: impl Fn(u64, u64) -> u64) -> Self {
        self.each_number(other, |a, b| f64::from_bits(f(a.to_bits(), b.to_bits())))
    }
}

impl<const M: usize> Scalar for Registers<M> {
    #[inline(always)]
    fn from_f64(value: f64) -> Self {
        // SAFETY: the processor has AVX2, see above.
        Self([unsafe { _mm256_set1_pd(value) }; M])
    }
    #[inline(always)]
    fn value(self) -> f64 {
        numbers(self.0[0])[0]
    }
    #[inline(always)]
    fn largest(self) -> f64 {
        let all = self.0.into_iter().flat_map(numbers);
        all.fold(f64::NEG_INFINITY, f64::max)
    }
    #[inline(always)]
    fn sqrt(mut self) -> Self {
        // SAFETY: the processor has AVX2, see above.
        each!(K, self.0[K] = unsafe { _mm256_sqrt_pd(self.0[K]) });
        self
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
    fn atan2(self, x: Self) -> Self {
        self.each_number(x, libm::atan2)
    }
    #[inline(always)]
    fn exp(self) -> Self {
        exp(self)
    }
    #[inline(always)]
    fn tanh(self) -> Self {
        self.each_number(self, |a, _| libm::tanh(a))
    }
    #[inline(always)]
    fn select(self, then: Self, otherwise: Self) -> Self {
        let mut out = otherwise;
        // SAFETY: the processor has AVX2, see above.
        each!(
            K,
            out.0[K] = unsafe {
                let positive = _mm256_cmp_pd::<_CMP_GT_OQ>(self.0[K], _mm256_setzero_pd());
                _mm256_blendv_pd(otherwise.0[K], then.0[K], positive)
            }
        );
        out
    }
}

/// Eight numbers.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Wide(__m512d);

macro_rules! widely {
    ($($trait:ident $method:ident $op:ident),*) => {$(
        impl $trait for Wide {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                // SAFETY: the processor has AVX-512, see above.
                Self(unsafe { $op(self.0, other.0) })
            }
        }
    )*};
}

widely!(Add add _mm512_add_pd, Sub sub _mm512_sub_pd, Mul mul _mm512_mul_pd, Div div _mm512_div_pd);

impl AddAssign for Wide {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl SubAssign for Wide {
    #[inline(always)]
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}

impl Neg for Wide {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        // SAFETY: the processor has AVX-512, see above.
        Self(unsafe {
            let sign = _mm512_set1_epi64(i64::MIN);
            _mm512_castsi512_pd(_mm512_xor_si512(_mm512_castpd_si512(self.0), sign))
        })
    }
}

impl Wide {
    #[inline(always)]
    pub(crate) fn from_lanes<const N: usize>(lanes: Lanes<N>) -> Self {
        assert_eq!(N, 8);
        let l = lanes.0;
        Self::from_numbers([l[0], l[1], l[2], l[3], l[4], l[5], l[6], l[7]])
    }

    /// Back to lanes.
    #[inline(always)]
    pub(crate) fn to_lanes<const N: usize>(self) -> Lanes<N> {
        assert_eq!(N, 8);
        let numbers = self.numbers();
        Lanes(core::array::from_fn(|k| numbers[k]))
    }

    #[inline(always)]
    fn numbers(self) -> [f64; 8] {
        // SAFETY: eight numbers of 64 bits each, any bits are valid.
        unsafe { core::mem::transmute(self.0) }
    }

    #[inline(always)]
    fn from_numbers(numbers: [f64; 8]) -> Self {
        // SAFETY: as above.
        Self(unsafe { core::mem::transmute::<[f64; 8], __m512d>(numbers) })
    }

    /// Number by number.
    #[inline(always)]
    fn each_number(self, other: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        let (a, b) = (self.numbers(), other.numbers());
        Self::from_numbers([
            f(a[0], b[0]),
            f(a[1], b[1]),
            f(a[2], b[2]),
            f(a[3], b[3]),
            f(a[4], b[4]),
            f(a[5], b[5]),
            f(a[6], b[6]),
            f(a[7], b[7]),
        ])
    }
}

impl Side for Wide {
    #[inline(always)]
    fn bits(self, other: Self, f: impl Fn(u64, u64) -> u64) -> Self {
        self.each_number(other, |a, b| f64::from_bits(f(a.to_bits(), b.to_bits())))
    }
}

impl Scalar for Wide {
    #[inline(always)]
    fn from_f64(value: f64) -> Self {
        // SAFETY: the processor has AVX-512, see above.
        Self(unsafe { _mm512_set1_pd(value) })
    }
    #[inline(always)]
    fn value(self) -> f64 {
        self.numbers()[0]
    }
    #[inline(always)]
    fn largest(self) -> f64 {
        self.numbers().into_iter().fold(f64::NEG_INFINITY, f64::max)
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        // SAFETY: the processor has AVX-512, see above.
        Self(unsafe { _mm512_sqrt_pd(self.0) })
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
    fn atan2(self, x: Self) -> Self {
        self.each_number(x, libm::atan2)
    }
    #[inline(always)]
    fn exp(self) -> Self {
        exp(self)
    }
    #[inline(always)]
    fn tanh(self) -> Self {
        self.each_number(self, |a, _| libm::tanh(a))
    }
    #[inline(always)]
    fn select(self, then: Self, otherwise: Self) -> Self {
        // SAFETY: the processor has AVX-512, see above.
        Self(unsafe {
            let positive = _mm512_cmp_pd_mask::<_CMP_GT_OQ>(self.0, _mm512_setzero_pd());
            _mm512_mask_blend_pd(positive, otherwise.0, then.0)
        })
    }
}
