//! What: dual numbers: a value with its derivatives along `N` directions.
//!
//! Equation: (a + ε a')(b + ε b') = ab + ε (a'b + ab'), ε² = 0; functions by the chain rule. Duals
//! nest: `Dual<1, Dual<8>>` gives mixed second derivatives.
//!
//! Source: Griewank and Walther (2008), Evaluating Derivatives, chapter 3.
//!
//! Assumes and ignores: at a kink (`select`, `max`) the derivative is that of the branch taken.
//!
//! Operations are calls, not inlined: inlined, one right-hand side with 26 directions takes the
//! compiler minutes.
//!
//! Valid for: any smooth function of [`Scalar`].
//!
//! Checked by: `derivatives_agree_with_differences` here (1e-8).

use crate::scalar::Scalar;
use core::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

/// A value and its derivatives along `N` directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dual<const N: usize, T = f64> {
    /// The value.
    pub re: T,
    /// Derivatives.
    pub eps: [T; N],
}

impl<const N: usize, T: Scalar> Dual<N, T> {
    /// A constant.
    #[inline]
    pub fn constant(re: T) -> Self {
        Self {
            re,
            eps: [T::zero(); N],
        }
    }

    /// The variable of direction `direction`.
    #[inline]
    pub fn variable(re: T, direction: usize) -> Self {
        let mut dual = Self::constant(re);
        dual.eps[direction] = T::one();
        dual
    }

    /// f(self) given value and slope of f.
    #[inline(never)]
    fn chain(self, value: T, slope: T) -> Self {
        let mut eps = self.eps;
        for e in &mut eps {
            *e = *e * slope;
        }
        Self { re: value, eps }
    }
}

impl<const N: usize, T: Scalar> Add for Dual<N, T> {
    type Output = Self;
    #[inline(never)]
    fn add(mut self, other: Self) -> Self {
        self += other;
        self
    }
}

impl<const N: usize, T: Scalar> Sub for Dual<N, T> {
    type Output = Self;
    #[inline(never)]
    fn sub(mut self, other: Self) -> Self {
        self -= other;
        self
    }
}

impl<const N: usize, T: Scalar> AddAssign for Dual<N, T> {
    #[inline(never)]
    fn add_assign(&mut self, other: Self) {
        self.re += other.re;
        for (a, b) in self.eps.iter_mut().zip(other.eps) {
            *a += b;
        }
    }
}

impl<const N: usize, T: Scalar> SubAssign for Dual<N, T> {
    #[inline(never)]
    fn sub_assign(&mut self, other: Self) {
        self.re -= other.re;
        for (a, b) in self.eps.iter_mut().zip(other.eps) {
            *a -= b;
        }
    }
}

impl<const N: usize, T: Scalar> Mul for Dual<N, T> {
    type Output = Self;
    #[inline(never)]
    fn mul(mut self, other: Self) -> Self {
        for (a, b) in self.eps.iter_mut().zip(other.eps) {
            *a = *a * other.re + self.re * b;
        }
        self.re = self.re * other.re;
        self
    }
}

impl<const N: usize, T: Scalar> Div for Dual<N, T> {
    type Output = Self;
    #[inline(never)]
    fn div(mut self, other: Self) -> Self {
        let inverse = T::one() / other.re;
        self.re = self.re / other.re;
        for (a, b) in self.eps.iter_mut().zip(other.eps) {
            *a = (*a - self.re * b) * inverse;
        }
        self
    }
}

impl<const N: usize, T: Scalar> Neg for Dual<N, T> {
    type Output = Self;
    #[inline(never)]
    fn neg(mut self) -> Self {
        self.re = -self.re;
        for e in &mut self.eps {
            *e = -*e;
        }
        self
    }
}

impl<const N: usize, T: Scalar> Scalar for Dual<N, T> {
    #[inline]
    fn from_f64(value: f64) -> Self {
        Self::constant(T::from_f64(value))
    }
    #[inline]
    fn value(self) -> f64 {
        self.re.value()
    }
    #[inline(never)]
    fn sqrt(self) -> Self {
        let root = self.re.sqrt();
        self.chain(root, T::from_f64(0.5) / root)
    }
    #[inline(never)]
    fn sin_cos(self) -> (Self, Self) {
        let (s, c) = self.re.sin_cos();
        (self.chain(s, c), self.chain(c, -s))
    }
    #[inline(never)]
    fn atan(self) -> Self {
        self.chain(self.re.atan(), T::one() / (T::one() + self.re * self.re))
    }
    #[inline(never)]
    fn atan2(self, x: Self) -> Self {
        let inverse = T::one() / (self.re * self.re + x.re * x.re);
        let (along_y, along_x) = (x.re * inverse, self.re * inverse);
        let mut eps = self.eps;
        for (a, b) in eps.iter_mut().zip(x.eps) {
            *a = *a * along_y - b * along_x;
        }
        Self {
            re: self.re.atan2(x.re),
            eps,
        }
    }
    #[inline(never)]
    fn exp(self) -> Self {
        let value = self.re.exp();
        self.chain(value, value)
    }
    #[inline(never)]
    fn tanh(self) -> Self {
        let value = self.re.tanh();
        self.chain(value, T::one() - value * value)
    }
    #[inline(never)]
    fn select(self, then: Self, otherwise: Self) -> Self {
        Self {
            re: self.re.select(then.re, otherwise.re),
            eps: core::array::from_fn(|k| self.re.select(then.eps[k], otherwise.eps[k])),
        }
    }
    #[inline(never)]
    fn scale(mut self, factor: f64) -> Self {
        self.re = self.re.scale(factor);
        for e in &mut self.eps {
            *e = e.scale(factor);
        }
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn every_function<T: Scalar>(x: T, y: T) -> T {
        let (s, c) = (x * y).sin_cos();
        let a = (s.exp() + c.squared()).sqrt() / (x - y.scale(3.0));
        let b = x.atan2(y) + (x * x).atan() - (y - a).tanh().abs();
        let mut sum = a.max(b) * (-x).select(x, y);
        sum += a;
        sum -= b.min(x);
        sum
    }

    #[test]
    fn derivatives_agree_with_differences() {
        for (x, y) in [(0.3, 0.8), (-0.7, 0.4), (1.3, -0.6)] {
            let dual = every_function(Dual::<2>::variable(x, 0), Dual::<2>::variable(y, 1));
            let h = 1.0e-6;
            let dx = (every_function(x + h, y) - every_function(x - h, y)) / (2.0 * h);
            let dy = (every_function(x, y + h) - every_function(x, y - h)) / (2.0 * h);
            assert_eq!(dual.re, every_function(x, y));
            assert!((dual.eps[0] - dx).abs() < 1.0e-8, "{} {dx}", dual.eps[0]);
            assert!((dual.eps[1] - dy).abs() < 1.0e-8, "{} {dy}", dual.eps[1]);
        }
    }

    #[test]
    fn nested_duals_give_second_derivatives() {
        type Second = Dual<1, Dual<1>>;
        let x = Second {
            re: Dual::variable(0.7, 0),
            eps: [Dual::constant(1.0)],
        };
        let second = (x.sin() * x.exp()).eps[0].eps[0];
        // (sin x e^x)'' = 2 cos x e^x.
        assert!((second - 2.0 * libm::cos(0.7) * libm::exp(0.7)).abs() < 1.0e-14);
    }
}
