//! Sums of two `f64` (about 32 digits), for residuals of polynomials. Dekker (1971), Knuth; without
//! fused multiply-add, so that every machine gives the same bits.

use nalgebra::Complex;

/// An unevaluated sum `hi + lo`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Double {
    pub hi: f64,
    pub lo: f64,
}

fn two_sum(a: f64, b: f64) -> Double {
    let hi = a + b;
    let bb = hi - a;
    Double {
        hi,
        lo: (a - (hi - bb)) + (b - bb),
    }
}

fn split(a: f64) -> (f64, f64) {
    let t = 134_217_729.0 * a;
    let hi = t - (t - a);
    (hi, a - hi)
}

/// Exact product of two numbers.
pub(crate) fn product(a: f64, b: f64) -> Double {
    let hi = a * b;
    let ((ah, al), (bh, bl)) = (split(a), split(b));
    Double {
        hi,
        lo: ((ah * bh - hi) + ah * bl + al * bh) + al * bl,
    }
}

impl Double {
    pub const fn new(hi: f64) -> Self {
        Self { hi, lo: 0.0 }
    }

    pub fn value(self) -> f64 {
        self.hi + self.lo
    }

    pub fn times(self, b: f64) -> Self {
        let p = product(self.hi, b);
        let s = two_sum(p.hi, p.lo + self.lo * b);
        Self { hi: s.hi, lo: s.lo }
    }
}

impl core::ops::Add for Double {
    type Output = Self;
    fn add(self, b: Self) -> Self {
        let s = two_sum(self.hi, b.hi);
        two_sum(s.hi, s.lo + (self.lo + b.lo))
    }
}

impl core::ops::Neg for Double {
    type Output = Self;
    fn neg(self) -> Self {
        Self {
            hi: -self.hi,
            lo: -self.lo,
        }
    }
}

impl core::ops::Sub for Double {
    type Output = Self;
    fn sub(self, b: Self) -> Self {
        self + -b
    }
}

impl core::ops::Mul for Double {
    type Output = Self;
    fn mul(self, b: Self) -> Self {
        let p = product(self.hi, b.hi);
        two_sum(p.hi, p.lo + (self.hi * b.lo + self.lo * b.hi))
    }
}

/// The polynomial with coefficients `p` (constant first) at `z`, computed in double-double.
pub(crate) fn horner(p: &[Double], z: Complex<f64>) -> Complex<f64> {
    let (mut re, mut im) = (Double::new(0.0), Double::new(0.0));
    for c in p.iter().rev() {
        (re, im) = (
            re.times(z.re) - im.times(z.im) + *c,
            re.times(z.im) + im.times(z.re),
        );
    }
    Complex::new(re.value(), im.value())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keeps_what_a_double_loses() {
        let a = Double::new(1.0) + Double::new(1e-20);
        assert_eq!((a - Double::new(1.0)).value(), 1e-20);
        // (1 + e)(1 - e) - 1 = -e².
        let e = libm::exp2(-40.0);
        assert_eq!(
            (product(1.0 + e, 1.0 - e) - Double::new(1.0)).value(),
            -e * e
        );
        // (z - 1)^3 at 1 + 2^-30.
        let p = [-1.0, 3.0, -3.0, 1.0].map(Double::new);
        let d = libm::exp2(-30.0);
        let at = horner(&p, Complex::new(1.0 + d, 0.0)).re;
        assert!((at / (d * d * d) - 1.0).abs() < 1e-3, "{at:e}");
    }
}
