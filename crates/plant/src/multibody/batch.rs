//! What: right-hand side and steps for one scenario or many, compiled for the processor at hand.
//!
//! Equation: the same source for one scenario (`f64`) and for several in SIMD lanes (`Lanes<N>`).
//!
//! Source: as in `model` and `step`.
//!
//! Assumes and ignores: one model and one road for all lanes; states and inputs differ. A step is
//! divided as the stiffest lane needs.
//!
//! Valid for: tyres (without slip it works, at no gain). Gains most with 4 or 8 lanes; AVX2 or AVX-512
//! is used where the processor has it, with the same results to the last bit: no fused operations.
//!
//! Checked by: `lanes_ride_like_single_scenarios` and `lanes_in_registers_give_the_same_bits` in
//! `multibody/tests`.

use super::contact::WheelContact;
use super::model::{Input, Multibody, Prepared};
use super::state::State;
use crate::Scalar;
use crate::lanes::Lanes;
#[cfg(target_arch = "x86_64")]
use crate::lanes_avx::{Registers, Wide};
use crate::road::Road;

/// What a right-hand side gives besides the derivative.
type Contacts<T> = Option<[WheelContact<T>; 2]>;

/// The right-hand side, and the contacts of the tyres.
#[inline]
pub(super) fn rhs<T: Scalar>(
    model: &Multibody,
    x: &State<T>,
    input: &Input<T>,
    road: Option<&Road>,
    dx: &mut State<T>,
) -> Contacts<T> {
    #[cfg(target_arch = "x86_64")]
    if T::WIDE && has_avx2() {
        // SAFETY: the processor has AVX2.
        return unsafe { rhs_avx2(model, x, input, road, dx) };
    }
    rhs_plain(model, x, input, road, dx)
}

/// Goes on by `steps` steps of `step_s` seconds.
pub(super) fn advance<T: Scalar>(
    model: &Multibody,
    x: &mut State<T>,
    input: &Input<T>,
    road: Option<&Road>,
    step_s: f64,
    steps: usize,
) {
    #[cfg(target_arch = "x86_64")]
    if T::WIDE && has_avx2() {
        // SAFETY: the processor has AVX2.
        unsafe { advance_avx2(model, x, input, road, step_s, steps) };
        return;
    }
    advance_plain(model, x, input, road, step_s, steps);
}

/// What the right-hand side on tyres needs of a state.
pub(super) fn prepare(
    model: &Multibody,
    x: &State,
    rear_road_y_m_s: f64,
    road: Option<&Road>,
) -> Prepared<f64> {
    #[cfg(target_arch = "x86_64")]
    if has_avx2() {
        // SAFETY: the processor has AVX2.
        return unsafe { prepare_avx2(model, x, rear_road_y_m_s, road) };
    }
    model.prepare_inlined(x, rear_road_y_m_s, road)
}

/// The right-hand side on tyres of a prepared state.
pub(super) fn finish(
    model: &Multibody,
    prepared: &Prepared<f64>,
    x: &State,
    input: &Input,
    dx: &mut State,
) {
    #[cfg(target_arch = "x86_64")]
    if has_avx2() {
        // SAFETY: the processor has AVX2.
        return unsafe { finish_avx2(model, prepared, x, input, dx) };
    }
    model.finish_inlined(prepared, x, input, dx);
}

/// Goes on by one step of `step_s` seconds from a prepared state.
pub(super) fn advance_prepared(
    model: &Multibody,
    x: &mut State,
    input: &Input,
    road: Option<&Road>,
    step_s: f64,
    prepared: &Prepared<f64>,
) {
    let first = |x: &State, dx: &mut State| {
        finish(model, prepared, x, input, dx);
        Some(prepared.tyres.contacts)
    };
    model.step_by(x, step_s, first, |x, dx| rhs(model, x, input, road, dx));
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn prepare_avx2(
    model: &Multibody,
    x: &State,
    rear_road_y_m_s: f64,
    road: Option<&Road>,
) -> Prepared<f64> {
    model.prepare_inlined(x, rear_road_y_m_s, road)
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn finish_avx2(
    model: &Multibody,
    prepared: &Prepared<f64>,
    x: &State,
    input: &Input,
    dx: &mut State,
) {
    model.finish_inlined(prepared, x, input, dx);
}

/// Right-hand sides of `N` scenarios.
pub fn rhs_lanes<const N: usize>(
    model: &Multibody,
    x: &State<Lanes<N>>,
    input: &Input<Lanes<N>>,
    road: Option<&Road>,
    dx: &mut State<Lanes<N>>,
) {
    #[cfg(target_arch = "x86_64")]
    if !model.no_slip && has_avx2() {
        match N {
            4 => return in_registers::<N, 1>(model, x, input, road, dx),
            8 if has_avx512() => return in_wide_registers(model, x, input, road, dx),
            8 => return in_registers::<N, 2>(model, x, input, road, dx),
            _ => {}
        }
    }
    rhs_plain(model, x, input, road, dx);
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
    if !model.no_slip && has_avx2() {
        match N {
            4 => return advance_in_registers::<N, 1>(model, x, input, road, step_s, steps),
            8 if has_avx512() => {
                return advance_in_wide_registers(model, x, input, road, step_s, steps);
            }
            8 => return advance_in_registers::<N, 2>(model, x, input, road, step_s, steps),
            _ => {}
        }
    }
    advance_plain(model, x, input, road, step_s, steps);
}

#[cfg(target_arch = "x86_64")]
fn has_avx2() -> bool {
    std::arch::is_x86_feature_detected!("avx2")
}

#[cfg(target_arch = "x86_64")]
fn has_avx512() -> bool {
    std::arch::is_x86_feature_detected!("avx512f")
}

/// Right-hand sides of eight lanes in one register. Only after `has_avx512`.
#[cfg(target_arch = "x86_64")]
fn in_wide_registers<const N: usize>(
    model: &Multibody,
    x: &State<Lanes<N>>,
    input: &Input<Lanes<N>>,
    road: Option<&Road>,
    dx: &mut State<Lanes<N>>,
) {
    let wide = x.map(Wide::from_lanes);
    let input = input.mapped(Wide::from_lanes);
    let mut slope = wide;
    // SAFETY: the caller has looked for AVX-512.
    unsafe { rhs_avx512(model, &wide, &input, road, &mut slope) };
    *dx = slope.map(Wide::to_lanes);
}

/// Steps of eight lanes in one register. Only after `has_avx512`.
#[cfg(target_arch = "x86_64")]
fn advance_in_wide_registers<const N: usize>(
    model: &Multibody,
    x: &mut State<Lanes<N>>,
    input: &Input<Lanes<N>>,
    road: Option<&Road>,
    step_s: f64,
    steps: usize,
) {
    let mut wide = x.map(Wide::from_lanes);
    let input = input.mapped(Wide::from_lanes);
    // SAFETY: the caller has looked for AVX-512.
    unsafe { advance_avx512(model, &mut wide, &input, road, step_s, steps) };
    *x = wide.map(Wide::to_lanes);
}

/// Right-hand sides of lanes, four to a register. Only after `has_avx2`.
#[cfg(target_arch = "x86_64")]
fn in_registers<const N: usize, const M: usize>(
    model: &Multibody,
    x: &State<Lanes<N>>,
    input: &Input<Lanes<N>>,
    road: Option<&Road>,
    dx: &mut State<Lanes<N>>,
) {
    let wide = x.map(Registers::<M>::from_lanes);
    let mut slope = wide;
    // SAFETY: the caller has looked for AVX2.
    unsafe {
        rhs_avx2(
            model,
            &wide,
            &input.mapped(Registers::from_lanes),
            road,
            &mut slope,
        )
    };
    *dx = slope.map(Registers::to_lanes);
}

/// Steps of lanes, four to a register. Only after `has_avx2`.
#[cfg(target_arch = "x86_64")]
fn advance_in_registers<const N: usize, const M: usize>(
    model: &Multibody,
    x: &mut State<Lanes<N>>,
    input: &Input<Lanes<N>>,
    road: Option<&Road>,
    step_s: f64,
    steps: usize,
) {
    let mut wide = x.map(Registers::<M>::from_lanes);
    let input = input.mapped(Registers::from_lanes);
    // SAFETY: the caller has looked for AVX2.
    unsafe { advance_avx2(model, &mut wide, &input, road, step_s, steps) };
    *x = wide.map(Registers::to_lanes);
}

/// One copy of the right-hand side: a step calls it from nine places.
#[inline(never)]
fn rhs_plain<T: Scalar>(
    model: &Multibody,
    x: &State<T>,
    input: &Input<T>,
    road: Option<&Road>,
    dx: &mut State<T>,
) -> Contacts<T> {
    model.rhs_inlined(x, input, road, dx)
}

/// The same, compiled for AVX2.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
#[inline(never)]
fn rhs_avx2<T: Scalar>(
    model: &Multibody,
    x: &State<T>,
    input: &Input<T>,
    road: Option<&Road>,
    dx: &mut State<T>,
) -> Contacts<T> {
    model.rhs_inlined(x, input, road, dx)
}

/// Steps for any processor.
pub(super) fn advance_plain<T: Scalar>(
    model: &Multibody,
    x: &mut State<T>,
    input: &Input<T>,
    road: Option<&Road>,
    step_s: f64,
    steps: usize,
) {
    for _ in 0..steps {
        let rhs = |x: &State<T>, dx: &mut State<T>| rhs_plain(model, x, input, road, dx);
        model.step_by(x, step_s, rhs, rhs);
    }
}

/// The same, compiled for AVX2.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn advance_avx2<T: Scalar>(
    model: &Multibody,
    x: &mut State<T>,
    input: &Input<T>,
    road: Option<&Road>,
    step_s: f64,
    steps: usize,
) {
    for _ in 0..steps {
        let rhs = |x: &State<T>, dx: &mut State<T>| rhs_avx2(model, x, input, road, dx);
        model.step_by(x, step_s, rhs, rhs);
    }
}

/// The right-hand side, compiled for AVX-512.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f")]
#[inline(never)]
fn rhs_avx512(
    model: &Multibody,
    x: &State<Wide>,
    input: &Input<Wide>,
    road: Option<&Road>,
    dx: &mut State<Wide>,
) -> Contacts<Wide> {
    model.rhs_inlined(x, input, road, dx)
}

/// Steps, compiled for AVX-512.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f")]
fn advance_avx512(
    model: &Multibody,
    x: &mut State<Wide>,
    input: &Input<Wide>,
    road: Option<&Road>,
    step_s: f64,
    steps: usize,
) {
    for _ in 0..steps {
        let rhs = |x: &State<Wide>, dx: &mut State<Wide>| rhs_avx512(model, x, input, road, dx);
        model.step_by(x, step_s, rhs, rhs);
    }
}
