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

/// Time to lock and time to fall under a pair of this torque at 5 m/s, s.
fn pair_at(friction: f64, torque_nm: f64, seconds: f64) -> (Option<f64>, Option<f64>) {
    let mut ride = Ride::new(&limited(Case::TyresRigid), Some(Road::level(friction)), 5.0).unwrap();
    // Leaning a little, as everybody does.
    let mut x = *ride.state();
    x.set_attitude_rad(0.0, 0.05, x.yaw_roll_pitch_rad().2);
    ride.set_state(&x);
    let rear = ride.input().rear_traction_nm;
    let (mut locked, mut down) = (None, None);
    for k in 0..(seconds * 1000.0) as usize {
        let input = Input {
            front_brake_nm: torque_nm,
            rear_traction_nm: rear + torque_nm,
            ..Input::default()
        };
        ride.advance(&input, 1.0e-3);
        let truth = ride.truth();
        let t = 1.0e-3 * (k + 1) as f64;
        if ride.state().iter().any(|v| !v.is_finite()) {
            panic!("not finite at {t} s");
        }
        if locked.is_none() && truth.front_wheel_rate_rad_s <= 0.0 {
            locked = Some(t);
        }
        if down.is_none() && truth.roll_rad.abs() > 1.0 {
            down = Some(t);
        }
    }
    (locked, down)
}

#[test]
fn past_the_limit_the_front_wheel_locks_and_the_bicycle_falls() {
    for (friction, torque) in [(0.6, 78.0), (0.6, 85.0), (0.3, 45.0), (1.0, 130.0)] {
        let (locked, down) = pair_at(friction, torque, 4.0);
        println!("friction {friction}, {torque} Nm: locked {locked:?} s, down {down:?} s");
        let (locked, down) = (locked.expect("locks"), down.expect("falls"));
        assert!((0.0175..0.4).contains(&locked), "locks after {locked} s");
        assert!(down < 2.0, "down after {down} s");
    }
}

#[test]
fn below_the_limit_it_rolls_on() {
    for (friction, torque) in [(0.6, 55.0), (1.0, 95.0)] {
        let (locked, _) = pair_at(friction, torque, 0.5);
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
