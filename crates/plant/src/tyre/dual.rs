//! A dual number for the conformance suite.

use crate::Scalar;
use core::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

/// Value and one derivative: written here, apart from the duals that the plant itself uses.
#[derive(Clone, Copy, Debug)]
pub(super) struct Dual(pub f64, pub f64);

impl Add for Dual {
    type Output = Self;
    fn add(self, o: Self) -> Self {
        Self(self.0 + o.0, self.1 + o.1)
    }
}
impl Sub for Dual {
    type Output = Self;
    fn sub(self, o: Self) -> Self {
        Self(self.0 - o.0, self.1 - o.1)
    }
}
impl Mul for Dual {
    type Output = Self;
    fn mul(self, o: Self) -> Self {
        Self(self.0 * o.0, self.1 * o.0 + self.0 * o.1)
    }
}
impl Div for Dual {
    type Output = Self;
    fn div(self, o: Self) -> Self {
        Self(self.0 / o.0, (self.1 * o.0 - self.0 * o.1) / (o.0 * o.0))
    }
}
impl Neg for Dual {
    type Output = Self;
    fn neg(self) -> Self {
        Self(-self.0, -self.1)
    }
}
impl AddAssign for Dual {
    fn add_assign(&mut self, o: Self) {
        *self = *self + o;
    }
}
impl SubAssign for Dual {
    fn sub_assign(&mut self, o: Self) {
        *self = *self - o;
    }
}
impl Scalar for Dual {
    fn from_f64(value: f64) -> Self {
        Self(value, 0.0)
    }
    fn value(self) -> f64 {
        self.0
    }
    fn sqrt(self) -> Self {
        let root = libm::sqrt(self.0);
        Self(root, self.1 / (2.0 * root))
    }
    fn sin_cos(self) -> (Self, Self) {
        let (s, c) = libm::sincos(self.0);
        (Self(s, c * self.1), Self(c, -s * self.1))
    }
    fn atan(self) -> Self {
        Self(libm::atan(self.0), self.1 / (1.0 + self.0 * self.0))
    }
    fn atan2(self, x: Self) -> Self {
        let r2 = self.0 * self.0 + x.0 * x.0;
        Self(libm::atan2(self.0, x.0), (self.1 * x.0 - self.0 * x.1) / r2)
    }
    fn exp(self) -> Self {
        let e = libm::exp(self.0);
        Self(e, e * self.1)
    }
    fn tanh(self) -> Self {
        let t = libm::tanh(self.0);
        Self(t, (1.0 - t * t) * self.1)
    }
    fn select(self, then: Self, otherwise: Self) -> Self {
        if self.0 > 0.0 { then } else { otherwise }
    }
}
