//! The physics of the generator: published eigenvalues, energy, signs, limits.

use crate::bicycle::Bicycle;
use crate::motion::Motion;
use crate::state::*;
use crate::truth::Truth;
use nalgebra::DMatrix;

const LATERAL: [usize; 4] = [ROLL, STEER, ROLL_RATE, STEER_RATE];

fn at(speed_m_s: f64) -> State {
    let mut x = [0.0; STATES];
    x[SPEED] = speed_m_s;
    x
}

fn quiet() -> Drive {
    Drive {
        direction: 1.0,
        development_m: 5.0,
        ..Drive::default()
    }
}

fn clean() -> Truth {
    Truth::clean(Bicycle::benchmark())
}

/// Rate of change of the four lateral states per unit of the states `of`.
fn matrix(truth: &Truth, speed_m_s: f64, of: &[usize]) -> DMatrix<f64> {
    let motion = Motion::new(truth);
    let mut a = DMatrix::zeros(of.len(), of.len());
    for (j, index) in of.iter().enumerate() {
        let mut x = at(speed_m_s);
        x[*index] = 1.0;
        let change = motion.change(&x, &quiet());
        for (i, row) in of.iter().enumerate() {
            a[(i, j)] = change.rate[*row];
        }
    }
    a
}

fn assert_has(found: &[nalgebra::Complex<f64>], re: f64, im: f64, within: f64) {
    let near = found
        .iter()
        .map(|l| (l.re - re).hypot(l.im.abs() - im))
        .fold(f64::INFINITY, f64::min);
    assert!(near < within, "{re} + {im} i: nearest {near:e}");
}

/// Table 2 of Meijaard et al. (2007), from the file of published figures.
#[test]
fn eigenvalues_are_those_of_the_paper() {
    let file = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../tests/data/meijaard2007_eigenvalues.toml"
    );
    let text = std::fs::read_to_string(file).unwrap();
    let table: toml::Table = text.parse().unwrap();
    let rows = table["row"].as_array().unwrap();
    assert!(rows.len() >= 7);
    for row in rows {
        let number = |key: &str| row[key].as_float().unwrap();
        let a = matrix(&clean(), number("speed_m_s"), &LATERAL);
        let found: Vec<_> = a.complex_eigenvalues().iter().copied().collect();
        let weave = row["weave"].as_array().unwrap();
        assert_has(
            &found,
            weave[0].as_float().unwrap(),
            weave[1].as_float().unwrap(),
            1e-9,
        );
        assert_has(&found, number("capsize"), 0.0, 1e-9);
        assert_has(&found, number("caster"), 0.0, 1e-9);
    }
}

/// Slipping tyres, the stiffer the nearer, and a path that lags less and less end where knife edges are.
#[test]
fn slip_and_lag_vanish_towards_no_slip() {
    let exact = matrix(&clean(), 5.0, &LATERAL);
    let weave = exact
        .complex_eigenvalues()
        .iter()
        .copied()
        .max_by(|a, b| a.im.total_cmp(&b.im))
        .unwrap();
    let distance = |truth: &Truth, states: &[usize]| {
        let found = matrix(truth, 5.0, states).complex_eigenvalues();
        found
            .iter()
            .map(|l| (l - weave).norm())
            .fold(f64::INFINITY, f64::min)
    };
    let slipping = |k: f64| {
        let truth = Truth {
            compliance_rad_n: k,
            ..clean()
        };
        distance(
            &truth,
            &[ROLL, STEER, ROLL_RATE, STEER_RATE, SIDE, YAW_RATE],
        )
    };
    let lagging = |length: f64| {
        let truth = Truth {
            relaxation_m: length,
            ..clean()
        };
        distance(&truth, &[ROLL, STEER, ROLL_RATE, STEER_RATE, YAW_RATE])
    };
    for law in [&slipping as &dyn Fn(f64) -> f64, &lagging] {
        let (far, near) = (law(1e-5), law(1e-6));
        assert!(
            far > 1e-7 && (far / near - 10.0).abs() < 0.5,
            "{far:e} {near:e}"
        );
    }
}

/// Standing still, roll, steer and gravity keep their energy; with damping and friction it falls.
#[test]
fn energy_at_a_standstill() {
    let energy = |motion: &Motion, x: &State| {
        let s = &motion.sums;
        // Without speed the constraint ties yaw to steer.
        let k = s.c * s.cos / s.w;
        let (p, d) = (x[ROLL_RATE], x[STEER_RATE]);
        let m = [
            s.I_Txx,
            s.I_Ax + k * s.I_Txz,
            s.I_A + 2.0 * k * s.I_Az + k * k * s.I_Tzz,
        ];
        let sa = s.mu_A + k * s.mx_T;
        0.5 * (m[0] * p * p + 2.0 * m[1] * p * d + m[2] * d * d)
            + s.g
                * (0.5 * s.mz_T * x[ROLL].powi(2)
                    - sa * x[ROLL] * x[STEER]
                    - 0.5 * s.sin * sa * x[STEER].powi(2))
    };
    let run = |truth: &Truth| {
        let motion = Motion::new(truth);
        let mut x = at(0.0);
        (x[ROLL_RATE], x[STEER_RATE]) = (0.02, -0.3);
        let start = energy(&motion, &x);
        for _ in 0..300 {
            x = motion.step(&x, &quiet(), 0.001);
        }
        (start, energy(&motion, &x))
    };
    let (start, end) = run(&clean());
    assert!((end / start - 1.0).abs() < 1e-9, "{start} {end}");
    let (start, end) = run(&Truth {
        steer_damping_nms_rad: 0.3,
        ..clean()
    });
    assert!(end < start - 1e-3);
    let (start, end) = run(&Truth {
        coulomb_nm: 0.1,
        ..clean()
    });
    assert!(end < start - 1e-3);
}

/// The work of both motors is the change of kinetic energy.
#[test]
fn motors_do_the_work_that_the_speed_shows() {
    let motion = Motion::new(&clean());
    let drive = Drive {
        front_brake_nm: 5.0,
        rear_traction_nm: 21.0,
        ..quiet()
    };
    let mut x = at(4.0);
    let mut work = 0.0;
    for _ in 0..2000 {
        let before = x[SPEED];
        x = motion.step(&x, &drive, 0.001);
        work +=
            0.001 * 0.5 * (before + x[SPEED]) * (21.0 / motion.sums.r_R - 5.0 / motion.sums.r_F);
    }
    let s = &motion.sums;
    let kinetic = |v: f64| {
        0.5 * s.m_T * v * v + 0.5 * s.I_R * (v / s.r_R).powi(2) + 0.5 * s.I_F * (v / s.r_F).powi(2)
    };
    assert!((work / (kinetic(x[SPEED]) - kinetic(4.0)) - 1.0).abs() < 1e-9);
}

fn response(truth: &Truth, drive: Drive, start: State) -> State {
    Motion::new(truth).change(&start, &drive).rate
}

#[test]
fn signs_by_physics() {
    let mut leaning = at(0.0);
    leaning[ROLL] = 0.1;
    let falls = response(&clean(), quiet(), leaning);
    assert!(falls[ROLL_RATE] > 0.0, "leaning right it falls right");
    assert!(falls[STEER_RATE] > 0.0, "and the front turns into the fall");
    let mut turning = at(6.0);
    turning[STEER] = 0.05;
    assert!(
        response(&clean(), quiet(), turning)[ROLL_RATE] < 0.0,
        "steering right rolls left"
    );
    let pull = Drive {
        pull_n: 100.0,
        pull_at_m: [0.3, -0.9],
        ..quiet()
    };
    assert!(
        response(&clean(), pull, at(4.0))[ROLL_RATE] > 0.0,
        "pulled to the right"
    );
    let windy = Truth {
        wind_m_s: 5.0,
        ..clean()
    };
    assert!(
        response(&windy, quiet(), at(4.0))[ROLL_RATE] > 0.0,
        "wind from the left rolls right"
    );
    let sloping = Truth {
        cross_slope_rad: 0.02,
        ..clean()
    };
    assert!(
        response(&sloping, quiet(), at(4.0))[ROLL_RATE] > 0.0,
        "a road that falls to the right"
    );
    let back = Drive {
        direction: -1.0,
        ..quiet()
    };
    assert!(
        response(&sloping, back, at(4.0))[ROLL_RATE] < 0.0,
        "and to the left on the way back"
    );
    let heavy = Truth {
        offset_kg_m: 1.0,
        ..clean()
    };
    assert!(
        response(&heavy, back, at(4.0))[ROLL_RATE] > 0.0,
        "a load turns with the bicycle"
    );
    let twisted = Truth {
        twisting_nm_rad: 5.0,
        ..clean()
    };
    let more = response(&twisted, quiet(), leaning)[STEER_RATE] - falls[STEER_RATE];
    assert!(
        more > 0.0,
        "a positive twisting torque turns a leaning wheel inward"
    );
    let brake = Drive {
        front_brake_nm: 10.0,
        ..quiet()
    };
    assert!(response(&clean(), brake, at(4.0))[SPEED] < 0.0);
    let dragged = Truth {
        rolling_n: 3.0,
        ..clean()
    };
    assert!(response(&dragged, quiet(), at(4.0))[SPEED] < 0.0);
    let uphill = Truth {
        slope_rad: 0.01,
        ..clean()
    };
    let slow = response(&uphill, quiet(), at(4.0))[SPEED];
    // m g sin(slope) over mass and wheels.
    let s = Motion::new(&clean()).sums;
    assert!((slow + s.m_T * s.g * 0.01f64.sin() / s.rolling_mass_kg()).abs() < 1e-12);
}

/// Dry friction holds the bar until the torque exceeds it, and then opposes the motion.
#[test]
fn friction_sticks_and_slides() {
    let truth = Truth {
        coulomb_nm: 1.0,
        ..clean()
    };
    let motion = Motion::new(&truth);
    let turn = |torque: f64| {
        let mut x = at(4.0);
        x[TORQUE] = torque;
        let drive = Drive {
            asked_nm: torque,
            ..quiet()
        };
        for _ in 0..10 {
            x = motion.step(&x, &drive, 0.002);
        }
        x[STEER_RATE]
    };
    assert!(
        turn(0.9).abs() < 1e-3 * turn(2.0).abs(),
        "{} {}",
        turn(0.9),
        turn(2.0)
    );
    assert!(turn(2.0) > 0.0);
    let mut sliding = at(4.0);
    sliding[STEER_RATE] = 0.5;
    assert_eq!(motion.friction_nm(&sliding, &quiet(), 0.002), -1.0);
}

/// Within the gap the bar turns alone; beyond it the fork follows.
#[test]
fn backlash_leaves_the_fork_alone_within_the_gap() {
    let truth = Truth {
        backlash_rad: 0.04,
        ..clean()
    };
    let mut x = at(4.0);
    x[BAR] = 0.015;
    let inside = Motion::new(&truth).change(&x, &quiet()).rate[STEER_RATE];
    x[BAR] = 0.03;
    let beyond = Motion::new(&truth).change(&x, &quiet()).rate[STEER_RATE];
    assert!(inside.abs() < 1e-9 && beyond > 1.0, "{inside} {beyond}");
}

/// What swings freely at standstill has the frequency of its pendulum, against a heavy frame.
#[test]
fn a_sloshing_tank_hangs_and_an_upper_body_stands() {
    let mut tank = clean();
    tank.outside.slosh_kg = 10.0;
    let mut x = at(5.0);
    x[SWING] = 0.1;
    assert!(Motion::new(&tank).change(&x, &quiet()).rate[SWING_RATE] < 0.0);
    let body = Truth {
        upper_body_kg: 35.0,
        ..clean()
    };
    let change = Motion::new(&body).change(&x, &quiet());
    assert!(
        change.rate[SWING_RATE] < 0.0,
        "the hip's stiffness holds it"
    );
}
