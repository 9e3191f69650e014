//! Past the limit of friction: the front wheel locks and the bicycle falls.

use crate::multibody::{BulsinkBicycle, Case, Input, Parameters, Reading, Ride, StateAccess};
use crate::road::Road;
use crate::truth::PlantModel;
use crate::tyre::{Combined, Friction, Tyre};

/// Case 6 with friction as a limit in all directions.
fn limited(case: Case) -> Parameters {
    let mut p = Parameters::bulsink2017(BulsinkBicycle::One, case, &Reading::default());
    for tyre in [&mut p.tyre.rear, &mut p.tyre.front] {
        if let Tyre::MagicFormula(m) = tyre {
            m.friction = Friction::Absolute;
            m.combined = Combined::Ellipse;
        }
    }
    p
}

/// What the front brake does once it has stopped the wheel.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Brake {
    /// Goes on with the same torque, as an ideal motor: the wheel is driven backwards.
    Drives,
    /// Holds the wheel, as a brake does.
    Holds,
}

/// What came of a pair past the limit: when the front wheel stopped, when the bicycle was down, s,
/// and how fast the wheel turned by then, rad/s.
struct Crash {
    locked_s: Option<f64>,
    down_s: Option<f64>,
    wheel_rad_s: f64,
}

/// A pair of this torque at 5 m/s on a road of this friction.
fn pair_at(friction: f64, torque_nm: f64, brake: Brake, seconds: f64) -> Crash {
    let mut ride = Ride::new(&limited(Case::TyresRigid), Some(Road::level(friction)), 5.0).unwrap();
    // Leaning a little, as everybody does.
    let mut x = *ride.state();
    x.set_attitude_rad(0.0, 0.05, x.yaw_roll_pitch_rad().2);
    ride.set_state(&x);
    let rear = ride.input().rear_traction_nm;
    let mut crash = Crash {
        locked_s: None,
        down_s: None,
        wheel_rad_s: 0.0,
    };
    for k in 0..(seconds * 1000.0) as usize {
        let rate = ride.truth().front_wheel_rate_rad_s;
        let input = Input {
            front_brake_nm: match brake {
                Brake::Drives => torque_nm,
                // Turned over smoothly within 1 rad/s: the wheel creeps where the torque balances.
                Brake::Holds => torque_nm * rate.clamp(-1.0, 1.0),
            },
            rear_traction_nm: rear + torque_nm,
            ..Input::default()
        };
        ride.advance(&input, 1.0e-3);
        let truth = ride.truth();
        let t = 1.0e-3 * (k + 1) as f64;
        assert!(
            ride.state().iter().all(|v| v.is_finite()) && truth.is_finite(),
            "not finite at {t} s"
        );
        if crash.locked_s.is_none() && truth.front_wheel_rate_rad_s < 1.0 {
            crash.locked_s = Some(t);
        }
        if crash.down_s.is_none() {
            crash.wheel_rad_s = truth.front_wheel_rate_rad_s;
            if truth.roll_rad.abs() > 1.0 {
                crash.down_s = Some(t);
            }
        }
    }
    crash
}

/// Known: locked within 35 to 200 ms, down in under a second; each within a factor of two.
#[test]
fn past_the_limit_the_front_wheel_locks_and_the_bicycle_falls() {
    for brake in [Brake::Drives, Brake::Holds] {
        for (friction, torque) in [
            (0.6, 78.0),
            (0.6, 85.0),
            (0.6, 100.0),
            (0.6, 120.0),
            (0.3, 45.0),
            (1.0, 130.0),
        ] {
            let crash = pair_at(friction, torque, brake, 2.5);
            let (locked, down) = (crash.locked_s.expect("locks"), crash.down_s);
            println!(
                "{brake:?}, friction {friction}, {torque} Nm: locked {locked} s, down {down:?} s, wheel {:.0} rad/s",
                crash.wheel_rad_s
            );
            assert!((0.0175..0.4).contains(&locked), "locks after {locked} s");
            assert!(down.expect("falls") < 2.0, "down after {down:?} s");
        }
    }
}

/// A torque that goes on drives the wheel backwards, and the wheel is then a gyroscope that holds the
/// bicycle up for longer than one that is locked: at 120 Nm on 0.6, twice as long.
#[test]
fn a_wheel_driven_backwards_delays_the_fall() {
    let [driven, held] = [Brake::Drives, Brake::Holds].map(|b| pair_at(0.6, 120.0, b, 2.5));
    assert!(driven.wheel_rad_s < -100.0, "{} rad/s", driven.wheel_rad_s);
    assert!(held.wheel_rad_s.abs() < 2.0, "{} rad/s", held.wheel_rad_s);
    let (driven, held) = (driven.down_s.expect("falls"), held.down_s.expect("falls"));
    println!("driven {driven} s, held {held} s");
    assert!(held < 1.2 && driven > 1.4 * held, "{driven} against {held}");
}

#[test]
fn below_the_limit_it_rolls_on() {
    for (friction, torque) in [(0.6, 55.0), (1.0, 95.0)] {
        let locked = pair_at(friction, torque, Brake::Drives, 0.5).locked_s;
        assert!(
            locked.is_none(),
            "friction {friction}, {torque} Nm: locked after {locked:?}"
        );
    }
}

#[test]
fn a_full_rider_falls_and_stays_finite() {
    let mut ride = Ride::new(&limited(Case::Full), Some(Road::level(0.5)), 3.0).unwrap();
    let input = Input {
        steer_torque_nm: 3.0,
        ..Input::default()
    };
    let mut fell = false;
    for _ in 0..6000 {
        ride.advance(&input, 1.0e-3);
        fell |= ride.truth().roll_rad.abs() > ride.fall_roll_rad();
        assert!(ride.state().iter().all(|v| v.is_finite()) && ride.truth().is_finite());
    }
    assert!(fell, "nobody rides it");
}

#[test]
fn an_accelerometer_at_rest_reads_gravity_upwards() {
    let ride = Ride::new(&limited(Case::Full), None, 4.0).unwrap();
    let truth = ride.truth();
    assert!(
        (truth.specific_force_m_s2[2] + 9.81).abs() < 1.0e-3,
        "{truth:?}"
    );
    let (front, rear) = ride.model().static_loads_n();
    assert!(
        (truth.front_load_n - front).abs() < 0.05 * front
            && (truth.rear_load_n - rear).abs() < 0.05 * rear
    );
    assert!((truth.speed_m_s - 4.0).abs() < 1.0e-3);
}

#[test]
fn it_falls_to_the_side_it_leans() {
    let mut ride = Ride::new(&limited(Case::TyresRigid), None, 0.5).unwrap();
    let mut x = *ride.state();
    x.set_attitude_rad(0.0, 0.05, 0.0);
    ride.set_state(&x);
    for _ in 0..500 {
        ride.advance(&Input::default(), 1.0e-3);
    }
    assert!(
        ride.truth().roll_rad > 0.06,
        "leaning right, nearly standing, it falls right"
    );
}
