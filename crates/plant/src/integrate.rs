//! Fixed-step integration.

use crate::scalar::Scalar;

/// One step of the classical fourth-order Runge-Kutta method.
///
/// `rhs(x, dx)` writes the derivative of `x` into `dx`; `step_s` is the step in seconds. Local
/// error is of order `step_s`⁵ for a smooth right-hand side.
///
/// Source: Hairer, Nørsett and Wanner (1993), Solving Ordinary Differential Equations I, table 1.2.
#[inline]
pub fn rk4<T: Scalar, const N: usize>(
    x: &mut [T; N],
    step_s: f64,
    mut rhs: impl FnMut(&[T; N], &mut [T; N]),
) {
    let zero = T::from_f64(0.0);
    let (half, full) = (T::from_f64(0.5 * step_s), T::from_f64(step_s));
    let (sixth, two) = (T::from_f64(step_s / 6.0), T::from_f64(2.0));
    let mut k1 = [zero; N];
    let mut k2 = [zero; N];
    let mut k3 = [zero; N];
    let mut k4 = [zero; N];
    rhs(x, &mut k1);
    let y: [T; N] = core::array::from_fn(|i| x[i] + half * k1[i]);
    rhs(&y, &mut k2);
    let y: [T; N] = core::array::from_fn(|i| x[i] + half * k2[i]);
    rhs(&y, &mut k3);
    let y: [T; N] = core::array::from_fn(|i| x[i] + full * k3[i]);
    rhs(&y, &mut k4);
    for i in 0..N {
        x[i] += sixth * (k1[i] + two * (k2[i] + k3[i]) + k4[i]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn halving_the_step_divides_the_error_by_sixteen() {
        let error = |steps: usize| {
            let mut x = [1.0, 0.0];
            for _ in 0..steps {
                rk4(&mut x, 1.0 / steps as f64, |x, dx| *dx = [x[1], -x[0]]);
            }
            (x[0] - libm::cos(1.0)).hypot(x[1] + libm::sin(1.0))
        };
        let order = libm::log2(error(50) / error(100));
        assert!((order - 4.0).abs() < 0.1, "order {order}");
    }
}
