//! What: many scenarios of one model at once, in SIMD lanes.
//!
//! Equation: the same right-hand side and Runge-Kutta steps as one scenario, on `Lanes<N>`.
//!
//! Source: as in `model`.
//!
//! Assumes and ignores: one model and one road for all lanes; states and inputs differ.
//!
//! Valid for: tyres (without slip it works, at no gain). Gains most with 4 or 8 lanes; AVX2 is used
//! where the processor has it, with the same results to the last bit.
//!
//! Checked by: `lanes_ride_like_single_scenarios` in `multibody/tests`.

use super::model::{Input, Multibody};
use super::state::State;
use crate::Scalar;
use crate::integrate::rk4;
use crate::lanes::Lanes;
use crate::road::Road;

/// The right-hand side, with AVX2 where the processor has it. No fused operations: the same bits.
#[inline]
pub(super) fn rhs<T: Scalar>(
    model: &Multibody,
    x: &State<T>,
    input: &Input<T>,
    road: Option<&Road>,
    dx: &mut State<T>,
) {
    #[cfg(target_arch = "x86_64")]
    if T::WIDE && std::arch::is_x86_feature_detected!("avx2") {
        // SAFETY: the processor has AVX2.
        unsafe { rhs_avx2(model, x, input, road, dx) };
        return;
    }
    model.rhs_inlined(x, input, road, dx);
}

/// Steps `N` scenarios on by `steps` steps of `step_s` seconds.
pub fn advance_lanes<const N: usize>(
    model: &Multibody,
    x: &mut State<Lanes<N>>,
    input: &Input<Lanes<N>>,
    road: Option<&Road>,
    step_s: f64,
    steps: usize,
) {
    #[cfg(target_arch = "x86_64")]
    if std::arch::is_x86_feature_detected!("avx2") {
        // SAFETY: the processor has AVX2.
        unsafe { advance_avx2(model, x, input, road, step_s, steps) };
        return;
    }
    for _ in 0..steps {
        rk4(x, step_s, |x, dx| model.rhs_inlined(x, input, road, dx));
        model.project(x);
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn advance_avx2<const N: usize>(
    model: &Multibody,
    x: &mut State<Lanes<N>>,
    input: &Input<Lanes<N>>,
    road: Option<&Road>,
    step_s: f64,
    steps: usize,
) {
    for _ in 0..steps {
        rk4(x, step_s, |x, dx| rhs_avx2(model, x, input, road, dx));
        model.project(x);
    }
}

/// One copy of the right-hand side, compiled for AVX2.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn rhs_avx2<T: Scalar>(
    model: &Multibody,
    x: &State<T>,
    input: &Input<T>,
    road: Option<&Road>,
    dx: &mut State<T>,
) {
    model.rhs_inlined(x, input, road, dx);
}
