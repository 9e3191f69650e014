//! The number type of the physics: `f64`, dual numbers (exact derivatives) and SIMD lanes run the
//! same source.

use core::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

/// What the physics needs of a number.
///
/// Functions are those of the `libm` crate, so that results are the same bits on every machine.
/// Branches are written as `select(condition, then, otherwise)` on the sign of a number, so that
/// lanes can take different ways.
pub trait Scalar:
    Copy
    + core::fmt::Debug
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + AddAssign
    + SubAssign
    + 'static
{
    /// Whether the right-hand side is worth a second copy for AVX2.
    const WIDE: bool = false;
    /// A constant.
    fn from_f64(value: f64) -> Self;
    /// The value without derivatives; of lanes, the first.
    fn value(self) -> f64;
    /// The largest value of all lanes.
    #[inline(always)]
    fn largest(self) -> f64 {
        self.value()
    }
    /// Square root.
    fn sqrt(self) -> Self;
    /// Sine and cosine.
    fn sin_cos(self) -> (Self, Self);
    /// Arc tangent.
    fn atan(self) -> Self;
    /// Angle of the point (`x`, `self`).
    fn atan2(self, x: Self) -> Self;
    /// Exponential.
    fn exp(self) -> Self;
    /// Hyperbolic tangent.
    fn tanh(self) -> Self;
    /// `then` where `self` > 0, else `otherwise`.
    fn select(self, then: Self, otherwise: Self) -> Self;

    /// Sine.
    #[inline(always)]
    fn sin(self) -> Self {
        self.sin_cos().0
    }
    /// Cosine.
    #[inline(always)]
    fn cos(self) -> Self {
        self.sin_cos().1
    }
    /// Magnitude.
    #[inline(always)]
    fn abs(self) -> Self {
        self.select(self, -self)
    }
    /// The larger of two.
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        (self - other).select(self, other)
    }
    /// The smaller of two.
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        (other - self).select(self, other)
    }
    /// Within `[low, high]`.
    #[inline(always)]
    fn clamp(self, low: Self, high: Self) -> Self {
        self.max(low).min(high)
    }
    /// `self` squared.
    #[inline(always)]
    fn squared(self) -> Self {
        self * self
    }
    /// `self` times a constant.
    #[inline(always)]
    fn scale(self, factor: f64) -> Self {
        self * Self::from_f64(factor)
    }
    /// Zero.
    #[inline(always)]
    fn zero() -> Self {
        Self::from_f64(0.0)
    }
    /// One.
    #[inline(always)]
    fn one() -> Self {
        Self::from_f64(1.0)
    }
}

impl Scalar for f64 {
    const WIDE: bool = true;
    #[inline]
    fn from_f64(value: f64) -> Self {
        value
    }
    #[inline]
    fn value(self) -> f64 {
        self
    }
    #[inline]
    fn sqrt(self) -> Self {
        // Correctly rounded by definition, so the same bits as libm's; and compiled for the caller's
        // instruction set, where libm's own instruction stalls among AVX ones.
        f64::sqrt(self)
    }
    #[inline]
    fn sin_cos(self) -> (Self, Self) {
        libm::sincos(self)
    }
    #[inline]
    fn sin(self) -> Self {
        libm::sin(self)
    }
    #[inline]
    fn cos(self) -> Self {
        libm::cos(self)
    }
    #[inline]
    fn atan(self) -> Self {
        libm::atan(self)
    }
    #[inline]
    fn atan2(self, x: Self) -> Self {
        libm::atan2(self, x)
    }
    #[inline]
    fn exp(self) -> Self {
        libm::exp(self)
    }
    #[inline]
    fn tanh(self) -> Self {
        libm::tanh(self)
    }
    #[inline]
    fn select(self, then: Self, otherwise: Self) -> Self {
        if self > 0.0 { then } else { otherwise }
    }
}
