//! The nonlinear model against its own linearisation, its mirror image, its energy.

use crate::integrate::rk4;
use crate::lanes::Lanes;
use crate::multibody::batch::{advance, advance_plain};
use crate::multibody::state::{STEER, STEER_RATE, TRUNK, VELOCITY};
use crate::multibody::{
    BulsinkBicycle, Case, Course, Input, Multibody, Parameters, Reading, Ride, STATES, State,
    StateAccess, advance_lanes, mirrored,
};
use nalgebra::DVector;

fn model(case: Case) -> Multibody {
    Multibody::new(&Parameters::bulsink2017(
        BulsinkBicycle::One,
        case,
        &Reading::default(),
    ))
    .unwrap()
}

#[test]
fn a_small_disturbance_grows_as_linearised() {
    for case in [Case::TyresRigid, Case::Full] {
        let model = model(case);
        let steady = model.steady(&Course::pair(6.0, 30.0), None).unwrap();
        let linear = model.linearise(&steady);
        let amplitude = 1.0e-6;
        let mut x = steady.state;
        let start = |x: &mut State| {
            let (_, roll, pitch) = x.yaw_roll_pitch_rad();
            x.set_attitude_rad(0.0, roll + amplitude, pitch);
            x[STEER] += 0.5 * amplitude;
        };
        start(&mut x);
        let mut xi = DVector::zeros(linear.a.nrows());
        xi[linear.index("roll_rad").unwrap()] = amplitude;
        xi[linear.index("steer_rad").unwrap()] = 0.5 * amplitude;
        for _ in 0..2000 {
            rk4(&mut x, 2.5e-4, |x, dx| {
                model.rhs(x, &steady.input, None, dx)
            });
            let h = 2.5e-4;
            let k1 = &linear.a * &xi;
            let k2 = &linear.a * (&xi + &k1 * (0.5 * h));
            let k3 = &linear.a * (&xi + &k2 * (0.5 * h));
            let k4 = &linear.a * (&xi + &k3 * h);
            xi += (k1 + (k2 + k3) * 2.0 + k4) * (h / 6.0);
        }
        let (_, roll, _) = x.yaw_roll_pitch_rad();
        let grown = [roll, x[STEER], x[STEER_RATE]];
        let expected =
            ["roll_rad", "steer_rad", "steer_rate_rad_s"].map(|n| xi[linear.index(n).unwrap()]);
        for (a, b) in grown.iter().zip(expected) {
            println!("{case:?} {a:e} {b:e} relative {:e}", (a / b - 1.0).abs());
            assert!((a / b - 1.0).abs() < 1.0e-5, "{case:?}: {a} against {b}");
        }
    }
}

#[test]
fn the_state_matrix_agrees_with_differences() {
    let model = model(Case::Full);
    let course = Course {
        roll_rad: 0.15,
        ..Course::pair(5.0, 40.0)
    };
    let steady = model.steady(&course, None).unwrap();
    let mut dx = [0.0; STATES];
    model.rhs(&steady.state, &steady.input, None, &mut dx);
    assert!(
        dx[15..29].iter().all(|v| v.abs() < 1.0e-8),
        "steady turn: {dx:?}"
    );
    // Full-state Jacobian by duals against central differences.
    use crate::dual::Dual;
    let mut worst: f64 = 0.0;
    for k in 3..STATES {
        let x: State<Dual<1>> = core::array::from_fn(|i| Dual {
            re: steady.state[i],
            eps: [if i == k { 1.0 } else { 0.0 }],
        });
        let mut d = [Dual::constant(0.0); STATES];
        model.rhs(&x, &steady.input.lifted(), None, &mut d);
        let h = 1.0e-6;
        let at = |step: f64| {
            let (mut x, mut dx) = (steady.state, [0.0; STATES]);
            x[k] += step;
            model.rhs(&x, &steady.input, None, &mut dx);
            dx
        };
        let (up, down) = (at(h), at(-h));
        let size = d.iter().map(|v| v.eps[0].abs()).fold(1.0, f64::max);
        for i in 0..STATES {
            let difference = (up[i] - down[i]) / (2.0 * h);
            worst = worst.max((d[i].eps[0] - difference).abs() / size);
        }
    }
    println!("largest difference {worst:e}");
    assert!(worst < 1.0e-7, "{worst:e}");
}

#[test]
fn mirrored_starts_mirror_the_motion() {
    let model = model(Case::Full);
    let steady = model.steady(&Course::straight(5.0), None).unwrap();
    let mut a = steady.state;
    a.set_attitude_rad(0.1, 0.1, 0.0);
    a[STEER] = -0.05;
    a[TRUNK] = 0.03;
    a[11] = 0.02;
    a[VELOCITY + 1] = 0.05;
    let mut b = mirrored(&a);
    for _ in 0..1000 {
        rk4(&mut a, 1.0e-3, |x, dx| {
            model.rhs(x, &steady.input, None, dx)
        });
        rk4(&mut b, 1.0e-3, |x, dx| {
            model.rhs(x, &steady.input, None, dx)
        });
    }
    let c = mirrored(&b);
    let worst = (0..STATES).map(|k| (a[k] - c[k]).abs()).fold(0.0, f64::max);
    println!("largest difference {worst:e}");
    assert!(worst < 1.0e-9, "{worst:e}");
    assert!(a[STEER].abs() > 1.0e-3, "it moved");
}

#[test]
fn halving_the_step_shows_the_fourth_order() {
    // Without slip nothing is stiff: larger steps, or rounding hides the error.
    for (case, coarse) in [(Case::Full, 800), (Case::NoSlipRigid, 20)] {
        let model = model(case);
        let steady = model.steady(&Course::straight(6.0), None).unwrap();
        let run = |steps: usize| {
            let mut x = steady.state;
            x.set_attitude_rad(0.0, 0.1, x.yaw_roll_pitch_rad().2);
            model.project(&mut x);
            for _ in 0..steps {
                rk4(&mut x, 0.4 / steps as f64, |x, dx| {
                    model.rhs(x, &steady.input, None, dx)
                });
            }
            x
        };
        // Reference with a step well below.
        let fine = run(12_800);
        let error = |steps: usize| {
            let x = run(steps);
            (3..29).map(|k| (x[k] - fine[k]).abs()).fold(0.0, f64::max)
        };
        let order = libm::log2(error(coarse) / error(2 * coarse));
        println!("{case:?} order {order}");
        assert!((order - 4.0).abs() < 0.3, "{case:?}: order {order}");
    }
}

/// Total energy over a ride without dissipation.
fn drift(model: &Multibody, speed: f64, seconds: f64, step_s: f64) -> f64 {
    let steady = model.steady(&Course::straight(speed), None).unwrap();
    let mut x = steady.state;
    let (_, _, pitch) = x.yaw_roll_pitch_rad();
    x.set_attitude_rad(0.0, 0.03, pitch);
    x[STEER_RATE] = 0.1;
    let free = &model.parameters().joints;
    if free.trunk_lean.free {
        for (k, rate) in [0.3, -0.2, 0.4, 0.5, -0.3].into_iter().enumerate() {
            x[STEER_RATE + 1 + k] = rate;
        }
    }
    model.project(&mut x);
    let start = model.energy(&x);
    for _ in 0..(seconds / step_s) as usize {
        rk4(&mut x, step_s, |x, dx| {
            model.rhs(x, &Input::default(), None, dx)
        });
        model.project(&mut x);
    }
    let slip = model
        .contact_velocities_m_s(&x)
        .iter()
        .fold(0.0_f64, |a, c| a.max(c.abs()));
    assert!(slip < 1.0e-9, "contacts slip at {slip:e} m/s");
    (model.energy(&x).total_j() - start.total_j()).abs() / start.kinetic_j
}

#[test]
fn without_dissipation_energy_is_kept_for_a_minute() {
    let bicycle = twinhub_linear::Bicycle::load("meijaard2007_benchmark").unwrap();
    let model = Multibody::new(&Parameters::from_whipple(&bicycle)).unwrap();
    let drift = drift(&model, 5.0, 60.0, 2.0e-3);
    println!("drift {drift:e}");
    assert!(drift < 1.0e-6, "{drift:e}");
}

#[test]
fn a_springy_rider_keeps_energy_too() {
    let mut p = Parameters::bulsink2017(
        BulsinkBicycle::One,
        Case::NoSlipPassive,
        &Reading::default(),
    );
    for joint in [
        &mut p.joints.trunk_lean,
        &mut p.joints.trunk_pitch,
        &mut p.joints.trunk_twist,
        &mut p.joints.legs,
    ] {
        joint.damping_nm_s_rad = 0.0;
    }
    let drift = drift(&Multibody::new(&p).unwrap(), 6.0, 4.0, 5.0e-4);
    println!("drift {drift:e}");
    assert!(drift < 1.0e-6, "{drift:e}");
}

#[test]
fn lanes_ride_like_single_scenarios() {
    let model = model(Case::Full);
    let steady = model.steady(&Course::straight(6.0), None).unwrap();
    let start = |k: usize| {
        let mut x = steady.state;
        x.set_attitude_rad(0.0, 0.02 * k as f64, 0.0);
        x
    };
    let mut lanes: State<Lanes<4>> =
        core::array::from_fn(|i| Lanes(core::array::from_fn(|k| start(k)[i])));
    let input = steady.input.lifted();
    advance_lanes(&model, &mut lanes, &input, None, 1.0e-3, 300);
    for k in 0..4 {
        let mut x = start(k);
        advance(&model, &mut x, &steady.input, None, 1.0e-3, 300);
        let worst = (0..STATES)
            .map(|i| (lanes[i].0[k] - x[i]).abs())
            .fold(0.0, f64::max);
        println!("lane {k}: {worst:e}");
        assert!(worst < 1.0e-9, "lane {k}: {worst:e}");
    }
}

fn same_in_registers<const N: usize>(model: &Multibody) {
    let steady = model.steady(&Course::straight(6.0), None).unwrap();
    let start: State<Lanes<N>> = core::array::from_fn(|i| {
        Lanes(core::array::from_fn(|k| {
            let mut x = steady.state;
            x.set_attitude_rad(0.0, 0.03 * k as f64 - 0.02, 0.0);
            x[STEER_RATE] = 0.1 * k as f64;
            x[i]
        }))
    });
    let input = steady.input.lifted();
    let (mut a, mut b) = (start, start);
    advance_lanes(model, &mut a, &input, None, 1.0e-3, 100);
    advance_plain(model, &mut b, &input, None, 1.0e-3, 100);
    assert_eq!(a, b);
    assert_ne!(a, start, "it moved");
}

#[test]
fn lanes_in_registers_give_the_same_bits() {
    let model = model(Case::Full);
    same_in_registers::<4>(&model);
    same_in_registers::<8>(&model);
}

#[test]
fn sensitivities_agree_with_differences_of_the_mode() {
    let model = model(Case::TyresRigid);
    let course = Course::straight(7.0);
    let at = |p: &Parameters| {
        let model = Multibody::new(p).unwrap();
        let pairs = model
            .linear(&course)
            .unwrap()
            .lateral()
            .eigenpairs()
            .unwrap();
        let slow = |z: &nalgebra::Complex<f64>| z.im > 0.0 && z.im < 15.0;
        pairs
            .iter()
            .map(|p| p.value)
            .filter(slow)
            .max_by(|a, b| a.re.total_cmp(&b.re))
            .unwrap()
    };
    let p = model.parameters().clone();
    let weave = at(&p);
    let all = model.sensitivities(&course, weave).unwrap();
    assert!(all.len() > 40, "{}", all.len());
    for path in [
        "geometry.trail_m",
        "tyre.front.magic_formula.twisting_per_rad",
        "frame.mass_kg",
    ] {
        let found = all.iter().find(|s| s.path == path).unwrap();
        let step = 1.0e-4 * found.value;
        let moved = |sign: f64| {
            let mut q = p.clone();
            q.set(path, found.value + sign * step).unwrap();
            at(&q)
        };
        let difference = (moved(1.0) - moved(-1.0)) / (2.0 * step);
        let error = (difference - found.per_unit).norm_sqr().sqrt() / difference.norm_sqr().sqrt();
        println!("{path}: {} against {difference}, {error:e}", found.per_unit);
        assert!(error < 1.0e-5, "{path}: {error:e}");
    }
}

/// Where a leaning, steering start has come to after `seconds` in steps of `step_s`, as ridden.
fn ridden(speed_m_s: f64, seconds: f64, step_s: f64) -> State {
    let parameters = Parameters::bulsink2017(BulsinkBicycle::One, Case::Full, &Reading::default());
    let mut ride = Ride::new(&parameters, None, speed_m_s).unwrap();
    let mut x = *ride.state();
    x.set_attitude_rad(0.0, 0.1, x.yaw_roll_pitch_rad().2);
    x[STEER_RATE] = 0.3;
    ride.set_state(&x);
    let input = Input {
        front_brake_nm: 20.0,
        rear_traction_nm: ride.input().rear_traction_nm + 20.0,
        ..Input::default()
    };
    for _ in 0..(seconds / step_s).round() as usize {
        ride.advance(&input, step_s);
    }
    *ride.state()
}

fn difference(a: &State, b: &State) -> f64 {
    (0..STATES).map(|k| (a[k] - b[k]).abs()).fold(0.0, f64::max)
}

#[test]
fn riding_keeps_the_fourth_order() {
    let fine = ridden(6.0, 0.2, 2.0e-5);
    let error = |step_s: f64| difference(&ridden(6.0, 0.2, step_s), &fine);
    let order = libm::log2(error(4.0e-4) / error(2.0e-4));
    println!("order {order}");
    assert!((order - 4.0).abs() < 0.4, "order {order}");
}

#[test]
fn a_step_of_a_millisecond_is_exact_enough_at_any_speed() {
    for speed in [0.3, 0.6, 1.0, 2.0, 3.0, 5.0, 8.0, 12.0] {
        let (rough, fine) = (ridden(speed, 0.1, 1.0e-3), ridden(speed, 0.1, 2.0e-5));
        let worst = difference(&rough, &fine);
        println!("{speed} m/s: {worst:e}");
        assert!(worst < 1.0e-3, "{speed} m/s: {worst:e}");
    }
}
