//! The pair of motor torques: it changes stiffness and pushes nothing.

use crate::multibody::{BulsinkBicycle, Case, Course, INPUTS, Multibody, Parameters, Reading};
use nalgebra::Matrix2;
use twinhub_linear::{Bicycle, Canonical};

/// Straight and upright no motor torque has an additive lateral effect, on tyres or without slip,
/// with a rigid rider or one that moves, whatever the torque.
#[test]
fn straight_and_upright_the_pair_pushes_nothing_sideways() {
    for case in [
        Case::NoSlipRigid,
        Case::NoSlipPassive,
        Case::TyresRigid,
        Case::Full,
    ] {
        let p = Parameters::bulsink2017(BulsinkBicycle::One, case, &Reading::default());
        let model = Multibody::new(&p).unwrap();
        for torque in [0.0, 40.0, 80.0] {
            let linear = model.linear(&Course::pair(5.0, torque)).unwrap();
            let lateral = linear.lateral();
            let column = |name| INPUTS.iter().position(|n| *n == name).unwrap();
            // The same torque on the bar, for comparison: that does steer.
            let steers = lateral.b.column(column("steer_torque_nm")).amax();
            assert!(steers > 1.0, "{case:?}");
            for input in ["front_brake_nm", "rear_traction_nm"] {
                let pushes = lateral.b.column(column(input)).amax();
                println!("{case:?} {torque} Nm {input}: {pushes:e} against {steers:.1}");
                assert!(pushes < 1.0e-13 * steers, "{case:?} {input}: {pushes:e}");
            }
        }
    }
}

/// Without slip the pair is a steering spring and nothing else: K_δδ grows by
/// F c (w + c) / w cos² λ, F = T / R.
#[test]
fn without_slip_the_pair_is_exactly_a_steering_spring() {
    for name in [
        "meijaard2007_benchmark",
        "bulsink2017_bicycle1",
        "bulsink2017_bicycle2",
    ] {
        let bicycle = Bicycle::load(name).unwrap();
        let model = Multibody::new(&Parameters::from_whipple(&bicycle)).unwrap();
        let mass = Canonical::new(&bicycle).unwrap().mass();
        let p = &bicycle.parameters;
        let states = [
            "roll_rad",
            "steer_rad",
            "roll_rate_rad_s",
            "steer_rate_rad_s",
        ];
        let at = |v, torque| {
            model
                .linear(&Course::pair(v, torque))
                .unwrap()
                .block(&states)
                .unwrap()
        };
        for (v, torque) in [(3.0, 20.0), (5.0, 80.0), (8.0, 100.0)] {
            let change = at(v, torque) - at(v, 0.0);
            let lower = Matrix2::from_fn(|i, j| change[(2 + i, j)]);
            let stiffness = -(Matrix2::from_fn(|i, j| mass[(i, j)]) * lower);
            let cosine = libm::cos(p.lam);
            let exact = torque / p.rF * p.c * (p.w + p.c) / p.w * cosine * cosine;
            println!("{name} {v} m/s {torque} Nm: {stiffness:?} against {exact}");
            assert!((stiffness[(1, 1)] / exact - 1.0).abs() < 1.0e-9, "{name}");
            for (i, j) in [(0, 0), (0, 1), (1, 0)] {
                assert!(
                    stiffness[(i, j)].abs() < 1.0e-9 * exact,
                    "{name} {i} {j}: {stiffness:?}"
                );
            }
            let damping = Matrix2::from_fn(|i, j| change[(2 + i, 2 + j)]);
            assert!(damping.amax() < 1.0e-9, "{name}: no damping, {damping:?}");
        }
    }
}
