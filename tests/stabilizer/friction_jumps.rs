//! The road's friction jumps under the wheels while a large pair acts that trusts it too much.

use crate::lay_road;
use twinhub_plant::road::{Patch, Road};
use twinhub_sim::{Ride, Stepper};
use twinhub_types::LimitedBy;

/// When the front wheel reaches the slippery spot, s.
const JUMP_S: f64 = 3.0;
/// Below this tread speed, as a share of that of free rolling, a wheel counts as locked.
const LOCKED_RATIO: f64 = 0.1;

/// What a ride came to.
#[derive(Debug)]
struct Seen {
    /// Smallest tread speed of the front wheel by that of free rolling while its motor brakes.
    slowest_ratio: f64,
    /// Largest brake torque before the jump, Nm.
    before_nm: f64,
    /// Ticks in which a torque was beyond a limit.
    broken: u64,
    /// The guard saw a slip.
    slipped: bool,
}

/// `bulsink2017_bicycle1_full` under a constant pair of 80 Nm that is told that friction is 1.0.
/// Friction is `from` up to the jump, then `to` for 3 m, and so on in turn.
fn ride(speed_m_s: f64, from: f64, to: f64, seed: u64) -> Seen {
    let set = [
        "law=\"constant_80_nm\"".to_owned(),
        "sensors=\"as_bought\"".to_owned(),
        "duration_s=8.0".to_owned(),
        format!("seed={seed}"),
        format!("speed=[{{t_s=0.0,speed_m_s={speed_m_s:?}}}]"),
        "law.limits.speed_min_m_s=0.5".to_owned(),
        "law.limits.ramp_up_nm_s=50.0".to_owned(),
    ];
    let mut ride = Ride::load("three_to_eight", &set).expect("a ride");
    let start_m = speed_m_s * JUMP_S + ride.law.bicycle.wheelbase_m as f64;
    let mut road = Road::level(from);
    road.patches = (0..20)
        .map(|n| start_m + 6.0 * f64::from(n))
        .map(|x_m| Patch {
            x_m: [x_m, x_m + 3.0],
            y_m: None,
            friction_ratio: to,
            edge_m: 0.05,
        })
        .collect();
    lay_road(&mut ride, road);
    let most_nm = f64::from(ride.law.limits.torque_max_nm);
    let mut seen = Seen {
        slowest_ratio: 1.0,
        before_nm: 0.0,
        broken: 0,
        slipped: false,
    };
    let mut last_nm = 0.0f32;
    let mut stepper = Stepper::new(&ride).expect("starts");
    while let Some(step) = stepper.step(None) {
        let (truth, command) = (&step.truth, &step.output.command);
        if stepper.time_s() < JUMP_S {
            seen.before_nm = seen.before_nm.max(truth.front_brake_nm);
        }
        if truth.front_brake_nm > 1.0 {
            seen.slowest_ratio = seen.slowest_ratio.min(1.0 + truth.front_slip_ratio);
        }
        let grown_nm = command.front_brake_nm - last_nm;
        let torques = [command.front_brake_nm, command.rear_traction_nm];
        let beyond = torques
            .iter()
            .any(|t| !t.is_finite() || f64::from(t.abs()) > most_nm + 1e-3);
        seen.broken += u64::from(beyond || command.front_brake_nm < 0.0 || grown_nm > 0.0501);
        seen.slipped |= LimitedBy::from_bits(step.output.limited_by).any(LimitedBy::SLIP);
        last_nm = command.front_brake_nm;
    }
    seen
}

#[test]
fn friction_jumps_lock_no_wheel_and_break_no_limit() {
    let (mut slips, mut slowest_ratio) = (0, 1.0f64);
    for speed_m_s in [0.5, 1.0, 2.0, 3.0, 5.0, 7.0] {
        for (from, to) in [
            (1.0, 0.15),
            (1.0, 0.3),
            (0.6, 0.15),
            (0.3, 1.0),
            (0.15, 0.15),
        ] {
            for seed in 1..=4 {
                let seen = ride(speed_m_s, from, to, seed);
                let what =
                    format!("{speed_m_s} m/s, friction {from} to {to}, seed {seed}: {seen:?}");
                assert!(seen.slowest_ratio > LOCKED_RATIO, "a locked wheel: {what}");
                assert_eq!(seen.broken, 0, "a broken limit: {what}");
                slips += u64::from(seen.slipped);
                slowest_ratio = slowest_ratio.min(seen.slowest_ratio);
            }
        }
    }
    println!("slowest wheel: {slowest_ratio:.2} of free rolling");
    assert!(
        slips > 40,
        "a pair that never slips proves nothing: {slips}"
    );
}
