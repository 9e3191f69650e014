//! What: the thesis's own method: a lateral push, a model of four poles fitted to roll and steer,
//! its weave mode, and the speed at which that mode turns stable.
//!
//! Equation: 0.1 N for 0.1 s at the centre of mass of the rear frame, on the nonlinear model;
//! `twinhub_ident::FourPoles` on roll and steer; weave speed by bisection and regula falsi on the
//! real part, without any use of the linearised model.
//!
//! Source: Bulsink (2017), sections 3.2.3 and 7.2.2.1.
//!
//! Assumes and ignores: the record ends where roll or steer leave the range in which the model is
//! linear; where the bicycle falls sooner than that, there is no fit, as in the source.
//!
//! Valid for: speeds at which growth is below about 4 1/s.
//!
//! Checked by: `tests/reproduction.rs`: weave speed within 0.5 % of linearisation, the benchmark's
//! four eigenvalues within 0.1 %.

use crate::error::ReproduceError;
use nalgebra::Complex;
use twinhub_ident::{FourPoles, Response};
use twinhub_plant::multibody::{Course, Input, Parameters, Ride, StateAccess, state};

/// Size of the push, N.
pub const PUSH_N: f64 = 0.1;
/// How long it lasts, s.
pub const PUSH_S: f64 = 0.1;
/// Integration step, s.
const STEP_S: f64 = 1.0e-3;
/// Steps to a sample of the record.
const STEPS_PER_SAMPLE: usize = 10;
/// Longest record, s.
const RECORD_S: f64 = 12.0;
/// Roll or steer at which the record ends, rad: of growing records the end weighs most, and cubic
/// terms there must be small against the push's own response of 1e-5 rad.
const LINEAR_RAD: f64 = 1.0e-3;
/// An oscillation faster than this is wobble, rad/s.
const WEAVE_LIMIT_RAD_S: f64 = 15.0;

/// Roll and steer after a push.
#[derive(Clone, Debug)]
pub struct Record {
    /// Time from one sample to the next, s.
    pub step_s: f64,
    /// Push, N.
    pub force_n: Vec<f64>,
    /// Roll, rad.
    pub roll_rad: Vec<f64>,
    /// Steer, rad.
    pub steer_rad: Vec<f64>,
}

impl Record {
    /// The push on a bicycle that rides steadily along `course`.
    ///
    /// # Errors
    /// Where the course has no steady state.
    pub fn of(parameters: &Parameters, course: &Course) -> Result<Self, ReproduceError> {
        let mut ride = Ride::new(parameters, None, course.speed_m_s)?;
        let steady = ride.model().steady(course, None)?;
        ride.set_state(&steady.state);
        let frame = &parameters.frame;
        let pushed = Input {
            force_n: [0.0, PUSH_N, 0.0],
            force_at_m: [frame.x_m, 0.0, frame.z_m],
            ..steady.input
        };
        let step_s = STEP_S * STEPS_PER_SAMPLE as f64;
        let mut record = Self {
            step_s,
            force_n: Vec::new(),
            roll_rad: Vec::new(),
            steer_rad: Vec::new(),
        };
        for k in 0..(RECORD_S / step_s) as usize {
            let (_, roll, _) = ride.state().yaw_roll_pitch_rad();
            let steer = ride.state()[state::STEER];
            if roll.abs().max(steer.abs()) > LINEAR_RAD {
                break;
            }
            let pushes = (k as f64 + 0.5) * step_s < PUSH_S;
            record.force_n.push(if pushes { PUSH_N } else { 0.0 });
            record.roll_rad.push(roll);
            record.steer_rad.push(steer);
            for _ in 0..STEPS_PER_SAMPLE {
                ride.advance(if pushes { &pushed } else { &steady.input }, STEP_S);
            }
        }
        Ok(record)
    }

    /// Four poles of roll and steer.
    ///
    /// # Errors
    /// Where the record has no four poles in it, or is too short.
    pub fn four_poles(&self) -> Result<FourPoles, ReproduceError> {
        Ok(FourPoles::fit(&Response {
            step_s: self.step_s,
            input: &self.force_n,
            outputs: &[&self.roll_rad, &self.steer_rad],
        })?)
    }
}

/// The weave mode of the fit at one speed; `None` where the fit has no oscillation.
pub fn weave(
    parameters: &Parameters,
    course: &Course,
) -> Result<Option<Complex<f64>>, ReproduceError> {
    Ok(Record::of(parameters, course)?
        .four_poles()?
        .weave(WEAVE_LIMIT_RAD_S))
}

/// Lowest of the speeds above which the fitted weave mode stays stable up to the last of `speeds_m_s`
/// (ascending); `None` where it does not turn stable between two of them.
pub fn weave_speed_m_s(
    parameters: &Parameters,
    course: &Course,
    speeds_m_s: &[f64],
) -> Result<Option<f64>, ReproduceError> {
    let growth = |speed_m_s: f64| -> Option<f64> {
        weave(
            parameters,
            &Course {
                speed_m_s,
                ..*course
            },
        )
        .ok()
        .flatten()
        .map(|w| w.re)
    };
    // Downwards from a speed at which it is stable to the first at which it is not.
    let mut above: Option<(f64, f64)> = None;
    for &v in speeds_m_s.iter().rev() {
        match (growth(v), above) {
            (Some(g), Some(high)) if g > 0.0 => return Ok(Some(root(&growth, (v, g), high))),
            (Some(g), _) if g <= 0.0 => above = Some((v, g)),
            _ => above = None,
        }
    }
    Ok(None)
}

/// Root of `growth` between an unstable and a stable speed, to 1e-4 m/s.
fn root(growth: &dyn Fn(f64) -> Option<f64>, low: (f64, f64), high: (f64, f64)) -> f64 {
    let ((mut a, mut fa), (mut b, mut fb)) = (low, high);
    let mut side = 0;
    for _ in 0..40 {
        let v = (fa * b - fb * a) / (fa - fb);
        let Some(f) = growth(v) else { return v };
        if f.abs() < 1.0e-6 || b - a < 1.0e-4 {
            return v;
        }
        if f > 0.0 {
            (a, fa) = (v, f);
            if side == 1 {
                fb *= 0.5;
            }
            side = 1;
        } else {
            (b, fb) = (v, f);
            if side == -1 {
                fa *= 0.5;
            }
            side = -1;
        }
    }
    0.5 * (a + b)
}
