//! The larger and the smaller of two numbers, with the same bits on every processor.
//!
//! `f32::max` and `f32::min` may give either of two zeros of different sign, and x86-64 and Arm do
//! differ there: a bicycle that stands still then has speed 0 on one and -0 on the other.

/// Bounds of a number.
pub(crate) trait Bounded {
    /// This number, or `low` if it is smaller or NaN. A `low` that is NaN is no bound.
    fn at_least(self, low: f32) -> f32;
    /// This number, or `high` if it is larger or NaN. A `high` that is NaN is no bound.
    fn at_most(self, high: f32) -> f32;
}

impl Bounded for f32 {
    #[inline]
    fn at_least(self, low: f32) -> f32 {
        if self < low || self.is_nan() {
            low
        } else {
            self
        }
    }

    #[inline]
    fn at_most(self, high: f32) -> f32 {
        if self > high || self.is_nan() {
            high
        } else {
            self
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_zeros_keep_their_sign_and_nan_is_no_bound() {
        for (x, bound) in [(0.0f32, -0.0f32), (-0.0, 0.0)] {
            assert_eq!(x.at_least(bound).to_bits(), x.to_bits());
            assert_eq!(x.at_most(bound).to_bits(), x.to_bits());
        }
        assert_eq!(1.0f32.at_least(2.0).at_most(1.5), 1.5);
        assert_eq!(f32::NAN.at_least(1.0), 1.0);
        assert_eq!(1.0f32.at_least(f32::NAN).at_most(f32::NAN), 1.0);
    }
}
