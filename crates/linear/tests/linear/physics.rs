//! Signs and sanity by physics.

use crate::built_in;
use nalgebra::{Vector2, Vector4};
use twinhub_linear::{Bicycle, BicycleError, Canonical, MotorPair};

const ZERO: Vector2<f64> = Vector2::new(0.0, 0.0);

#[test]
fn leaning_right_hands_off_standing_still_it_falls_right() {
    for name in twinhub_linear::sets::NAMES {
        let (_, e) = built_in(name);
        let right = e.acceleration(0.0, MotorPair::OFF, Vector2::new(0.05, 0.0), ZERO, ZERO);
        assert!(right[0] > 0.0, "{name}: {right}");
    }
}

#[test]
fn torques_to_the_right_turn_to_the_right() {
    let (_, e) = built_in("meijaard2007_benchmark");
    let push = e.acceleration(0.0, MotorPair::OFF, ZERO, ZERO, Vector2::new(1.0, 0.0));
    assert!(push[0] > 0.0);
    let steer = e.acceleration(0.0, MotorPair::OFF, ZERO, ZERO, Vector2::new(0.0, 1.0));
    assert!(steer[1] > 0.0);
    // Steered right while rolling: it yaws right, and falls left (centrifugal force).
    assert!(e.yaw_rate_rad_s(5.0, 0.1, 0.0) > 0.0);
    let turn = e.acceleration(8.0, MotorPair::OFF, Vector2::new(0.0, 0.1), ZERO, ZERO);
    assert!(turn[0] < 0.0, "{turn}");
}

#[test]
fn rear_traction_speeds_up_and_front_brake_slows_down() {
    let (b, e) = built_in("bulsink2017_bicycle1");
    let drive = e.longitudinal_accel_m_s2(MotorPair {
        front_brake_nm: 0.0,
        rear_traction_nm: 35.0,
    });
    // 35 Nm at 0.35 m push with 100 N; 98.07 kg and 3.16 kg of spinning wheels.
    assert!(
        (drive - 100.0 / (98.07 + 0.43 * 7.35)).abs() < 1e-12,
        "{drive}"
    );
    assert!(
        e.longitudinal_accel_m_s2(MotorPair {
            front_brake_nm: 35.0,
            rear_traction_nm: 0.0
        }) < 0.0
    );
    assert_eq!(
        e.longitudinal_accel_m_s2(MotorPair::balanced(33.3, &b)),
        0.0
    );
}

#[test]
fn a_pair_of_unequal_wheels_is_balanced() {
    let (b, e) = built_in("meijaard2007_benchmark");
    let pair = MotorPair::balanced(33.3, &b);
    assert!((pair.rear_traction_nm - 33.3 * 0.3 / 0.35).abs() < 1e-12);
    assert_eq!(e.longitudinal_accel_m_s2(pair), 0.0);
}

#[test]
fn state_matrix_and_acceleration_agree() {
    let (b, e) = built_in("bulsink2017_bicycle2");
    let pair = MotorPair::balanced(25.0, &b);
    let x = Vector4::new(0.1, -0.05, 0.3, 0.7);
    let torque = Vector2::new(2.0, -1.0);
    let dx = e.state_matrix(6.0, pair) * x + e.input_matrix() * torque;
    let q = e.acceleration(
        6.0,
        pair,
        Vector2::new(x[0], x[1]),
        Vector2::new(x[2], x[3]),
        torque,
    );
    assert_eq!((dx[0], dx[1]), (x[2], x[3]));
    assert!(
        (dx[2] - q[0]).abs() < 1e-12 && (dx[3] - q[1]).abs() < 1e-11,
        "{dx} {q}"
    );
}

#[test]
fn absurd_bicycles_are_refused_with_figures() {
    for (assignment, parts) in [
        ("mB=-1", vec!["mB", "-1", "at least 0 kg"]),
        ("w=0", vec!["`w`", "above 0 m"]),
        ("g=nan", vec!["`g`", "finite"]),
        ("zB=0.9", vec!["zB", "z points down"]),
        ("lam=18", vec!["lam", "not degrees"]),
        ("IBxx=1000", vec!["rear body", "sum of the two others"]),
        ("IHxz=5", vec!["front assembly", "negative principal"]),
        ("rF=0", vec!["IFyy", "skate"]),
        ("ibxx=9", vec!["did you mean `IBxx`"]),
        ("IBxx", vec!["SYMBOL=NUMBER"]),
        ("IBxx=nine", vec!["SYMBOL=NUMBER", "nine"]),
    ] {
        let (bicycle, _) = built_in("meijaard2007_benchmark");
        let message = bicycle.with(&[assignment]).unwrap_err().to_string();
        for part in parts {
            assert!(
                message.contains(part),
                "{assignment}: `{message}` lacks `{part}`"
            );
        }
    }
}

#[test]
fn a_singular_mass_matrix_is_an_error() {
    let (mut bicycle, _) = built_in("meijaard2007_benchmark");
    // All mass on the ground line of the steer axis and no inertia: steer has none left.
    for symbol in [
        "mR", "mF", "IRxx", "IRyy", "IFxx", "IFyy", "mH", "IHxx", "IHyy", "IHzz", "IHxz", "c",
    ] {
        bicycle.set(symbol, 0.0).unwrap();
    }
    assert!(matches!(
        Canonical::new(&bicycle),
        Err(BicycleError::SingularMass { .. })
    ));
}

#[test]
fn unknown_names_list_the_known_ones() {
    let message = Bicycle::load("meijard2007").unwrap_err().to_string();
    for name in twinhub_linear::sets::NAMES {
        assert!(message.contains(name), "{message}");
    }
    assert_eq!(
        Bicycle::load("Meijaard2007_Benchmark").unwrap().name,
        "meijaard2007_benchmark"
    );
    let message = Bicycle::load("bulsink2017_bicycle1:products=maybe")
        .unwrap_err()
        .to_string();
    assert!(
        message.contains("products=maybe") && message.contains("products=tensor"),
        "{message}"
    );
    assert!(Bicycle::load("meijaard2007_benchmark:k=1").is_err());
}
