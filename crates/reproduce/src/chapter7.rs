//! What: the figures of chapter 7: one motor, two motors, the push at 7 m/s, the corner.
//!
//! Equation: weave speeds by linearisation; the push and the corner on the nonlinear model.
//!
//! Source: Bulsink (2017), sections 7.2.2 and 7.3.
//!
//! Assumes and ignores: speed, gains and lean of the corner are not printed. Ours: 6 m/s, a stiff
//! hold of 1.5° of steer for 0.2 s, then torque T = kp (φ - φ0) + kd φ' - ks δ' with φ0 = 3°, speed
//! held by the rear motor until 7.5 s.
//!
//! Valid for: bicycle 1, case 7 of table 3.3.
//!
//! Checked by: `tests/reproduction.rs`.

use crate::assumed::Assumed;
use crate::error::ReproduceError;
use crate::misses::{Lever, explain};
use crate::motion::{Seen, Trace};
use crate::row::Row;
use crate::stability::weave_on_m_s;
use twinhub_plant::multibody::{Course, Multibody, Parameters};

type Rows = Result<Vec<Row>, ReproduceError>;

const LEVERS: &[Lever] = &[
    Lever::WheelInertia,
    Lever::Twisting,
    Lever::ForkProduct,
    Lever::TrunkTwist,
];

/// Weave speed at steady speed, driven by the front wheel alone, or by the rear one.
fn driven_weave_m_s(p: &Parameters, front: bool) -> Option<f64> {
    let mut course = Course::straight(5.0);
    if front {
        // Rolling resistance does not depend on speed: the torque that the rear motor needed.
        let model = Multibody::new(p).ok()?;
        let radii = p.front_wheel.radius_m / p.rear_wheel.radius_m;
        let rear = model.steady(&course, None).ok()?.input.rear_traction_nm;
        course.front_brake_nm = -rear * radii;
    }
    weave_on_m_s(p, &course).ok()?
}

/// One motor (section 7.3.1).
pub fn one_motor(assumed: &Assumed) -> Rows {
    let p = assumed.chapter7();
    let mut rows = Vec::new();
    for (id, thesis, front) in [
        ("rear_drive_weave", 8.34, false),
        ("front_drive_weave", 8.39, true),
    ] {
        let figure = move |p: &Parameters| driven_weave_m_s(p, front);
        let mut row = Row::number(id, thesis, figure(&p), "m/s").noted(
            "section 7.3.1",
            format!(
                "case 7; the {} motor overcomes rolling resistance",
                if front { "front" } else { "rear" }
            ),
        );
        explain(&mut row, assumed, &p, LEVERS, &figure);
        rows.push(row);
    }
    Ok(rows)
}

/// Weave speed under a pair of `torque_nm`, m/s.
pub fn pair_weave_m_s(p: &Parameters, torque_nm: f64) -> Option<f64> {
    weave_on_m_s(p, &Course::pair(5.0, torque_nm)).ok()?
}

/// Change of weave speed by a pair of `torque_nm`, percent.
fn pair_percent(p: &Parameters, torque_nm: f64) -> Option<f64> {
    Some(100.0 * (pair_weave_m_s(p, torque_nm)? / pair_weave_m_s(p, 0.0)? - 1.0))
}

/// Two motors (section 7.3.2).
pub fn two_motors(assumed: &Assumed) -> Rows {
    let p = assumed.chapter7();
    let figure = |p: &Parameters| pair_percent(p, 100.0);
    let mut row = Row::number("pair_100nm_percent", -23.0, figure(&p), "%").noted(
        "section 7.3.2, figure 7.5",
        "case 7; change of weave speed by a pair of 100 Nm",
    );
    explain(&mut row, assumed, &p, LEVERS, &figure);
    Ok(vec![row])
}

/// When the push of figure 7.4 comes and when the motors stop, s.
pub const PUSHED_S: f64 = 15.0;
/// See [`PUSHED_S`].
pub const STOPPED_S: f64 = 20.0;
/// End of figure 7.4, s.
const END_S: f64 = 25.0;
/// The push of figure 7.4, N for 0.1 s: its size is not printed, and does not matter while roll is
/// small.
const PUSH_N: f64 = 20.0;

/// When the pair of figure 7.4 is on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PairOn {
    /// Never (a).
    Never,
    /// From the push until 5 s later (b).
    Between,
    /// Throughout (c).
    Always,
}

/// Figure 7.4: a push at 7 m/s.
pub fn pushed(p: &Parameters, on: PairOn, torque_nm: f64) -> Result<Trace, ReproduceError> {
    let frame = p.frame;
    let radii = p.rear_wheel.radius_m / p.front_wheel.radius_m;
    let start = match on {
        PairOn::Always => Course::pair(7.0, torque_nm),
        _ => Course::straight(7.0),
    };
    // Nothing happens before the push: the run begins a second earlier.
    let begin = PUSHED_S - 1.0;
    let mut trace = Trace::ride(p, &start, END_S - begin, |seen, steady| {
        let t = seen.t_s + begin;
        let mut input = *steady;
        if on == PairOn::Between && (PUSHED_S..STOPPED_S).contains(&t) {
            input.front_brake_nm += torque_nm;
            input.rear_traction_nm += torque_nm * radii;
        }
        if (PUSHED_S..PUSHED_S + 0.1).contains(&t) {
            input.force_n = [0.0, PUSH_N, 0.0];
            input.force_at_m = [frame.x_m, 0.0, frame.z_m];
        }
        input
    })?;
    trace.t_s.iter_mut().for_each(|t| *t += begin);
    Ok(trace)
}

/// Growth rate of the swing between two times, 1/s: from the amplitudes of roll in both halves.
fn swing_growth_per_s(trace: &Trace, from_s: f64, to_s: f64) -> f64 {
    let middle = 0.5 * (from_s + to_s);
    let first = trace.amplitude(&trace.roll_rad, from_s, middle);
    let second = trace.amplitude(&trace.roll_rad, middle, to_s);
    libm::log(second / first) / (middle - from_s)
}

/// The push at 7 m/s (figure 7.4).
pub fn push_at_7(assumed: &Assumed) -> Rows {
    let p = assumed.chapter7();
    let run = |on| pushed(&p, on, 80.0);
    let (never, between, always) = (
        run(PairOn::Never)?,
        run(PairOn::Between)?,
        run(PairOn::Always)?,
    );
    let growth = [
        swing_growth_per_s(&never, PUSHED_S + 1.0, STOPPED_S),
        swing_growth_per_s(&between, PUSHED_S + 1.0, STOPPED_S),
        swing_growth_per_s(&between, STOPPED_S + 0.5, END_S - 0.5),
        swing_growth_per_s(&always, PUSHED_S + 1.0, END_S),
    ];
    let same = growth[0] > 0.0 && growth[1] < 0.0 && growth[2] > 0.0 && growth[3] < 0.0;
    let thesis = "unstable at 0 Nm, stable at 80 Nm, unstable again when switched off";
    let word = |g: f64| if g < 0.0 { "stable" } else { "unstable" };
    let ours = if same {
        thesis.to_owned()
    } else {
        format!(
            "{} at 0 Nm, {} at 80 Nm, {} when switched off",
            word(growth[0]),
            word(growth[1]),
            word(growth[2])
        )
    };
    let note = format!(
        "case 7 at 7 m/s; roll grows at {:+.2} 1/s without, {:+.2} with, {:+.2} after, {:+.2} with the pair throughout",
        growth[0], growth[1], growth[2], growth[3]
    );
    Ok(vec![
        Row::words("pair_7ms_verdict", thesis, ours, same).noted("section 7.3.2, figure 7.4", note),
    ])
}

/// Which motor drives after the corner of figure 7.3.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Drive {
    /// None (a).
    None,
    /// The front motor (b).
    Front,
    /// The rear motor (c).
    Rear,
}

/// When the corner begins and when hands and controller let go, s.
pub const TURN_S: f64 = 3.0;
/// See [`TURN_S`].
pub const HANDS_OFF_S: f64 = 7.5;
/// End of figure 7.3, s.
pub const CORNER_END_S: f64 = 11.0;
/// Torque of the motor in figure 7.3, Nm.
const DRIVE_NM: f64 = 80.0;
/// Speed of the corner, m/s: a guess.
pub const CORNER_M_S: f64 = 6.0;
/// Lean that the steering controller holds, rad: a guess, 3°.
const CORNER_ROLL_RAD: f64 = 0.052;

/// Figure 7.3: a corner, then hands off under a drive torque.
pub fn corner(p: &Parameters, drive: Drive, speed_m_s: f64) -> Result<Trace, ReproduceError> {
    // Nothing happens before the turn: the run begins half a second earlier.
    let begin = TURN_S - 0.5;
    let mut trace = Trace::ride(
        p,
        &Course::straight(speed_m_s),
        CORNER_END_S - begin,
        |seen, steady| {
            let t = seen.t_s + begin;
            let mut input = *steady;
            if t >= HANDS_OFF_S {
                match drive {
                    Drive::None => {}
                    Drive::Front => input.front_brake_nm = -DRIVE_NM,
                    Drive::Rear => input.rear_traction_nm = DRIVE_NM,
                }
                return input;
            }
            input.steer_torque_nm = steering(t, seen);
            input.rear_traction_nm += 20.0 * (speed_m_s - seen.speed_m_s);
            input
        },
    )?;
    trace.t_s.iter_mut().for_each(|t| *t += begin);
    Ok(trace)
}

/// Torque of the steering controller, Nm.
fn steering(t: f64, seen: &Seen) -> f64 {
    if t < TURN_S {
        0.0
    } else if t < TURN_S + 0.2 {
        200.0 * (0.0262 - seen.steer_rad) - 8.0 * seen.steer_rate_rad_s
    } else {
        12.0 * (seen.roll_rad - CORNER_ROLL_RAD) + 8.0 * seen.roll_rate_rad_s
            - 2.0 * seen.steer_rate_rad_s
    }
}

/// Does the swing of steer die out after hands off: is the steer rate's amplitude in the last second
/// below that of the first?
fn settles(trace: &Trace) -> (bool, [f64; 2]) {
    let rate: Vec<f64> = trace
        .steer_rad
        .windows(2)
        .zip(trace.t_s.windows(2))
        .map(|(s, t)| (s[1] - s[0]) / (t[1] - t[0]))
        .chain([0.0])
        .collect();
    let first = trace.amplitude(&rate, HANDS_OFF_S, HANDS_OFF_S + 1.0);
    let last = trace.amplitude(&rate, CORNER_END_S - 1.0, CORNER_END_S);
    let upright = trace.amplitude(&trace.roll_rad, HANDS_OFF_S, CORNER_END_S) < 1.0;
    (upright && last < first, [first, last])
}

/// The corner (figure 7.3).
pub fn corners(assumed: &Assumed) -> Rows {
    let p = assumed.chapter7();
    let none = settles(&corner(&p, Drive::None, CORNER_M_S)?);
    let mut rows = Vec::new();
    for (id, drive, thesis, wanted) in [
        (
            "corner_front_verdict",
            Drive::Front,
            "stays unstable",
            false,
        ),
        ("corner_rear_verdict", Drive::Rear, "settles", true),
    ] {
        let trace = corner(&p, drive, CORNER_M_S)?;
        let (settled, [first, last]) = settles(&trace);
        let same = settled == wanted;
        let ours = if settled { "settles" } else { "stays unstable" };
        rows.push(Row::words(id, thesis, ours.to_owned(), same).noted(
            "section 7.3.1, figure 7.3",
            format!(
                "case 7, corner at {CORNER_M_S} m/s (a guess), hands off at 7.5 s with 80 Nm; steer swings at up to {first:.2} rad/s in the first second and {last:.2} in the last, without motor {:.2} and {:.2}",
                none.1[0], none.1[1]
            ),
        ));
    }
    Ok(rows)
}
