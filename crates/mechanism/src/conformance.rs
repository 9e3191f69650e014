//! What every mechanism is held to.

use crate::registry::{ALL, find};
use crate::{Body, InputModel, Inputs, Mechanism, Moment, Quantity, SensorModel, Wrench};
use twinhub_linear::Bicycle;

const QUANTITIES: [Quantity; 8] = [
    Quantity::Roll,
    Quantity::RollRate,
    Quantity::Steer,
    Quantity::Speed,
    Quantity::SteerTorque,
    Quantity::LateralForce,
    Quantity::FrontBrake,
    Quantity::RearTraction,
];

fn moment<'a>(body: &'a Body, sign: f64) -> Moment<'a> {
    Moment {
        body,
        t_s: 1.0,
        dt_s: 0.01,
        speed_m_s: 4.0,
        accel_m_s2: 0.3,
        travel_m: 4.0,
        angle_rad: [0.05 * sign, 0.08 * sign],
        rate_rad_s: [0.2 * sign, -0.3 * sign],
        accel_rad_s2: [0.5 * sign, 1.0 * sign],
        inputs: Inputs {
            steer_torque_nm: 0.7 * sign,
            ..Inputs::default()
        },
        crank_rad: Some(1.0),
        wheel_rad: Some(2.0),
        trunk_lean_rad: Some(0.1 * sign),
        way: 1.0,
    }
}

fn push(mechanism: &dyn Mechanism, p: &[f64], at: &Moment<'_>) -> Wrench {
    let mut memory = vec![0.0; mechanism.memory()];
    mechanism.remember(p, at, &mut memory, true);
    mechanism.remember(p, at, &mut memory, false);
    mechanism.wrench(p, at, &memory)
}

fn benchmark() -> Bicycle {
    Bicycle::load("meijaard2007_benchmark").unwrap()
}

#[test]
fn names_are_unique_and_partners_exist() {
    for (index, mechanism) in ALL.iter().enumerate() {
        let card = mechanism.card();
        assert!(ALL[..index].iter().all(|m| m.card().name != card.name));
        for other in card.confounded_with {
            assert!(find(other).is_some(), "{}: {other}", card.name);
        }
        assert!(!card.parameters.is_empty() && !card.equations.is_empty());
    }
}

#[test]
fn absent_at_null() {
    let bicycle = benchmark();
    let bare = Body::with(&bicycle, &[]).unwrap();
    for mechanism in ALL {
        let name = mechanism.card().name;
        let p = mechanism.null(&bicycle.parameters);
        let body = Body::with(&bicycle, &[(*mechanism, &p)]).unwrap();
        assert_eq!(body.terms, bare.terms, "{name}");
        let at = moment(&body, 1.0);
        let wrench = push(*mechanism, &p, &at);
        let size = wrench.roll_nm.abs() + wrench.steer_nm.abs() + wrench.force_n.abs();
        assert!(
            size + wrench.yaw_rate_rad_s.abs() == 0.0,
            "{name}: {wrench:?}"
        );
        for quantity in QUANTITIES {
            let mut input = InputModel::IDEAL;
            mechanism.input(&p, quantity, &mut input);
            assert!(input.limit > 150.0, "{name}");
            input.limit = f64::INFINITY;
            assert_eq!(input, InputModel::IDEAL, "{name}");
            let mut sensor = SensorModel::IDEAL;
            mechanism.sensor(&p, quantity, &mut sensor);
            assert_eq!(sensor, SensorModel::IDEAL, "{name}");
            assert_eq!(mechanism.reading(&p, quantity, &at), 0.0, "{name}");
        }
        assert_eq!(mechanism.law_delay_s(&p), 0.0);
        let random = mechanism.random_force(&p, &bicycle.parameters);
        assert_eq!(random, None, "{name}");
    }
}

/// Each probe stays within the bounds and does something finite.
#[test]
fn probes_act() {
    let bicycle = benchmark();
    let bare = Body::with(&bicycle, &[]).unwrap();
    for mechanism in ALL {
        let card = mechanism.card();
        for p in mechanism.probes(&bicycle.parameters) {
            for (value, param) in p.iter().zip(card.parameters) {
                assert!((param.least..=param.most).contains(value), "{}", card.name);
            }
            let body = Body::with(&bicycle, &[(*mechanism, &p)]).unwrap();
            let at = moment(&body, 1.0);
            let wrench = push(*mechanism, &p, &at);
            let sum = wrench.roll_nm + wrench.steer_nm + wrench.force_n;
            assert!(sum.is_finite(), "{}", card.name);
            let models = QUANTITIES.iter().any(|q| {
                let (mut input, mut sensor) = (InputModel::IDEAL, SensorModel::IDEAL);
                mechanism.input(&p, *q, &mut input);
                mechanism.sensor(&p, *q, &mut sensor);
                input != InputModel::IDEAL
                    || sensor != SensorModel::IDEAL
                    || mechanism.reading(&p, *q, &at) != 0.0
            });
            let acts = body.terms != bare.terms
                || body.parameters != bare.parameters
                || wrench != Wrench::default()
                || models
                || mechanism.random_force(&p, &bicycle.parameters).is_some()
                || mechanism.law_delay_s(&p) > 0.0;
            assert!(acts, "{}", card.name);
        }
    }
}

/// What follows from the motion alone changes sign with it.
#[test]
fn feedback_is_symmetric() {
    let bicycle = benchmark();
    let body = Body::with(&bicycle, &[]).unwrap();
    for mechanism in ALL.iter().filter(|m| m.feeds_back()) {
        let p = mechanism.probes(&bicycle.parameters).remove(0);
        let right = push(*mechanism, &p, &moment(&body, 1.0));
        let left = push(*mechanism, &p, &moment(&body, -1.0));
        let name = mechanism.card().name;
        assert!((right.roll_nm + left.roll_nm).abs() < 1e-9, "{name}");
        assert!((right.steer_nm + left.steer_nm).abs() < 1e-9, "{name}");
    }
}

/// Friction and drag take energy.
#[test]
fn dissipation() {
    let bicycle = benchmark();
    let body = Body::with(&bicycle, &[]).unwrap();
    for name in [
        "steer_coulomb_friction",
        "rolling_resistance",
        "aerodynamic_drag",
    ] {
        let mechanism = find(name).unwrap();
        let p = mechanism.probes(&bicycle.parameters).remove(0);
        let at = moment(&body, 1.0);
        let wrench = push(mechanism, &p, &at);
        let power = wrench.steer_nm * at.rate_rad_s[1] + wrench.force_n * at.speed_m_s;
        assert!(power < 0.0, "{name}: {power}");
    }
}

/// Friction larger than all other torque holds the steering still.
#[test]
fn friction_sticks() {
    let bicycle = benchmark();
    let body = Body::with(&bicycle, &[]).unwrap();
    let mut at = moment(&body, 1.0);
    at.rate_rad_s[1] = 1e-4;
    let wrench = push(find("steer_coulomb_friction").unwrap(), &[5.0], &at);
    let after = at.rate_rad_s[1]
        + at.dt_s * (at.accel_rad_s2[1] + wrench.steer_nm / body.steer_inertia_kg_m2());
    assert!(after.abs() < 1e-12, "{after}");
}

/// What belongs to the road or the air changes sides on the way back; what belongs to the bicycle does not.
#[test]
fn the_way_back() {
    let bicycle = benchmark();
    let body = Body::with(&bicycle, &[]).unwrap();
    let sideways = |name: &str, way: f64| {
        let mechanism = find(name).unwrap();
        let p = mechanism.probes(&bicycle.parameters).remove(0);
        let at = Moment {
            way,
            ..moment(&body, 1.0)
        };
        let w = push(mechanism, &p, &at);
        [w.roll_nm, w.steer_nm, w.force_n]
    };
    for name in ["crosswind", "cross_slope", "longitudinal_slope"] {
        assert_eq!(sideways(name, -1.0), sideways(name, 1.0).map(|x| -x));
    }
    for name in ["lateral_offset", "rolling_resistance"] {
        assert_eq!(sideways(name, -1.0), sideways(name, 1.0));
    }
}
