//! Riders alone: one suite for every channel; and on bicycles: closed loops against theory,
//! simulation, published windows.

use super::closed_loop::{ClosedLoop, stability};
use super::published::{Group, Table};
use super::windows::{least_growth, windows};
use super::*;
use crate::multibody::{BulsinkBicycle, Case, Multibody, Parameters, Reading, Ride, StateAccess};
use crate::truth::{PlantInput, PlantModel};
use nalgebra::Complex;

const STEP_S: f64 = 1e-3;

fn torque(delay_s: f64) -> SteerTorqueParameters {
    SteerTorqueParameters {
        delay_s,
        neuromuscular_rad_s: 30.0,
        neuromuscular_damping_ratio: 0.707,
        remnant_sd_nm: 0.0,
        remnant_bandwidth_rad_s: 10.0,
        torque_limit_nm: 20.0,
        gains: vec![TorqueGains {
            speed_m_s: 5.0,
            roll_nm_rad: 10.0,
            roll_rate_nms_rad: 2.0,
            heading_nm_rad: 1.0,
            steer_nm_rad: 3.0,
            steer_rate_nms_rad: 0.5,
        }],
    }
}

fn angle(delay_s: f64) -> AngleParameters {
    AngleParameters {
        delay_s,
        neuromuscular_rad_s: 30.0,
        neuromuscular_damping_ratio: 0.707,
        remnant_sd_rad: 0.0,
        remnant_bandwidth_rad_s: 10.0,
        stiffness_nm_rad: 50.0,
        damping_nm_s_rad: 3.0,
        angle_limit_rad: 0.5,
        torque_limit_nm: 30.0,
        gains: vec![AngleGains {
            speed_m_s: 5.0,
            roll_ratio: -1.0,
            roll_rate_s: -0.2,
            heading_ratio: 0.1,
        }],
    }
}

/// A rider with one channel of each kind, by its name.
fn one(name: &str, delay_s: f64) -> RiderFile {
    let mut rider = Channels::default();
    match name {
        "steer_torque" => rider.steer_torque = Some(torque(delay_s)),
        "steer_angle" => rider.steer_angle = Some(SteerAngleParameters(angle(delay_s))),
        "trunk_lean" => rider.trunk_lean = Some(TrunkLeanParameters(angle(delay_s))),
        "knees" => rider.knees = Some(KneesParameters(angle(delay_s))),
        other => panic!("the suite does not know `{other}`"),
    }
    RiderFile {
        schema_version: 1,
        about: "test".into(),
        source: "test".into(),
        rider,
        pedals: PedalsParameters {
            speed_gain_ns_m: 0.0,
            force_limit_n: 0.0,
        },
    }
}

/// What a rider sees while it wobbles, at tick `i`.
fn wobble(i: u32) -> Perception {
    let t = f64::from(i) * STEP_S;
    let (s, c) = libm::sincos(5.0 * t);
    Perception {
        roll_rad: 0.05 * s,
        roll_rate_rad_s: 0.25 * c,
        steer_rad: -0.03 * c,
        steer_rate_rad_s: 0.15 * s,
        trunk_lean_rad: 0.02 * s,
        trunk_lean_rate_rad_s: 0.1 * c,
        legs_rad: [0.01 * s, -0.02 * c],
        leg_rates_rad_s: [0.05 * c, 0.1 * s],
        yaw_rad: 0.02 * c,
        speed_m_s: 5.0,
        wanted_speed_m_s: 5.0,
    }
}

fn mirrored(p: &Perception) -> Perception {
    Perception {
        roll_rad: -p.roll_rad,
        roll_rate_rad_s: -p.roll_rate_rad_s,
        steer_rad: -p.steer_rad,
        steer_rate_rad_s: -p.steer_rate_rad_s,
        trunk_lean_rad: -p.trunk_lean_rad,
        trunk_lean_rate_rad_s: -p.trunk_lean_rate_rad_s,
        legs_rad: [p.legs_rad[1], p.legs_rad[0]],
        leg_rates_rad_s: [p.leg_rates_rad_s[1], p.leg_rates_rad_s[0]],
        yaw_rad: -p.yaw_rad,
        ..*p
    }
}

fn torques(a: &Action) -> [f64; 4] {
    [
        a.steer_torque_nm,
        a.trunk_lean_torque_nm,
        a.leg_torque_nm[0],
        a.leg_torque_nm[1],
    ]
}

#[test]
fn every_channel_is_quiet_in_the_middle_antisymmetric_finite_and_late() {
    for name in Channel::NAMES {
        let file = one(name, 0.1);
        let start = || file.start(1, STEP_S).expect(name);
        let still = Perception {
            speed_m_s: 5.0,
            ..Perception::default()
        };
        let mut rider = start();
        for _ in 0..500 {
            assert_eq!(torques(&rider.act(&still, STEP_S)), [0.0; 4], "{name}");
        }
        let (mut rider, mut mirror) = (start(), start());
        for i in 0..1000 {
            let seen = wobble(i);
            let [bar, trunk, left, right] = torques(&rider.act(&seen, STEP_S));
            let other = torques(&mirror.act(&mirrored(&seen), STEP_S));
            let close = [-bar, -trunk, right, left]
                .iter()
                .zip(other)
                .all(|(a, b)| (a - b).abs() < 1e-12);
            assert!(close, "{name}: {bar} {trunk} {left} {right} {other:?}");
        }
        // Only roll is seen: nothing before the delay, something after it.
        let mut rider = start();
        let lean = Perception {
            roll_rad: 0.1,
            ..still
        };
        let acted: Vec<f64> = (0..300)
            .map(|_| {
                torques(&rider.act(&lean, STEP_S))
                    .iter()
                    .map(|t| t.abs())
                    .sum()
            })
            .collect();
        assert!(acted[..100].iter().all(|&t| t == 0.0), "{name}");
        assert!(acted[299] > 0.1, "{name}: {}", acted[299]);
        // Absurd perceptions stay within the limits.
        let mut rider = start();
        let absurd = Perception {
            roll_rad: 1e9,
            roll_rate_rad_s: -1e12,
            trunk_lean_rad: 1e6,
            ..still
        };
        for _ in 0..500 {
            let t = torques(&rider.act(&absurd, STEP_S));
            assert!(t.iter().all(|t| t.abs() <= 60.0), "{name}: {t:?}");
        }
    }
}

#[test]
fn every_channel_survives_toml_and_explains_itself() {
    for name in Channel::NAMES {
        let file = one(name, 0.1);
        let text = toml::to_string(&file).expect("TOML");
        assert_eq!(toml::from_str::<RiderFile>(&text).expect("reads"), file);
        assert_eq!(file.rider.names(), [*name]);
        let explain = Channels::explain(name).expect("explains itself");
        assert!(explain.name == *name && explain.is_complete());
        let typo = text.replace("delay_s", "dealy_s");
        let error = toml::from_str::<RiderFile>(&typo).expect_err("a typo");
        assert!(error.to_string().contains("dealy_s"), "{error}");
    }
}

#[test]
fn signs_out_of_the_lean_and_into_it() {
    let lean_right = Perception {
        roll_rad: 0.1,
        speed_m_s: 5.0,
        ..Perception::default()
    };
    let settled = |file: &RiderFile| {
        let mut rider = file.start(1, STEP_S).expect("valid");
        (0..2000).fold(Action::default(), |_, _| rider.act(&lean_right, STEP_S))
    };
    // k_p = 10 Nm/rad out of the lean.
    let action = settled(&one("steer_torque", 0.2));
    assert!((action.steer_torque_nm + 1.0).abs() < 1e-6);
    // -1 rad/rad: into the lean, 0.1 rad to the right, held by 50 Nm/rad.
    let action = settled(&one("steer_angle", 0.2));
    assert!((action.steer_torque_nm - 5.0).abs() < 1e-6);
    let action = settled(&one("trunk_lean", 0.2));
    assert!((action.trunk_lean_torque_nm - 5.0).abs() < 1e-6);
    // Both knees to the right: the right one outward, the left one inward.
    let action = settled(&one("knees", 0.2));
    assert!((action.leg_torque_nm[1] - 5.0).abs() < 1e-6);
    assert!((action.leg_torque_nm[0] + 5.0).abs() < 1e-6);
}

#[test]
fn channels_add_up() {
    let mut file = one("steer_torque", 0.1);
    file.rider.trunk_lean = one("trunk_lean", 0.1).rider.trunk_lean;
    file.rider.knees = one("knees", 0.1).rider.knees;
    let mut all = file.start(1, STEP_S).expect("valid");
    let mut parts: Vec<Rider> = ["steer_torque", "trunk_lean", "knees"]
        .map(|name| one(name, 0.1).start(1, STEP_S).expect("valid"))
        .into();
    for i in 0..500 {
        let sum = parts.iter_mut().fold(Action::default(), |sum, part| {
            sum.plus(part.act(&wobble(i), STEP_S))
        });
        assert_eq!(all.act(&wobble(i), STEP_S), sum);
    }
}

#[test]
fn what_no_rider_has_is_refused_with_its_key() {
    let refused = |change: &dyn Fn(&mut RiderFile), name: &str| {
        let mut file = one(name, 0.2);
        change(&mut file);
        file.start(1, STEP_S).expect_err(name).to_string()
    };
    let bar = |f: &mut RiderFile, change: &dyn Fn(&mut SteerTorqueParameters)| {
        change(f.rider.steer_torque.as_mut().expect("there"));
    };
    let message = refused(&|f| bar(f, &|p| p.delay_s = f64::NAN), "steer_torque");
    assert!(
        message.contains("delay_s") && message.contains("0 to 1 s"),
        "{message}"
    );
    let message = refused(&|f| bar(f, &|p| p.gains.clear()), "steer_torque");
    assert!(message.contains("gains"), "{message}");
    let message = refused(&|f| bar(f, &|p| p.torque_limit_nm = -1.0), "steer_torque");
    assert!(message.contains("torque_limit_nm"), "{message}");
    let message = refused(&|f| f.rider.hands_off = Some(HandsOff {}), "steer_torque");
    assert!(message.contains("hands_off"), "{message}");
    let both = |f: &mut RiderFile| f.rider.steer_torque = Some(torque(0.1));
    assert!(refused(&both, "steer_angle").contains("one of the two"));
    assert!(refused(&|f| f.schema_version = 2, "knees").contains("accepted is 1"));
    let message = one("knees", 0.1)
        .fits(Limbs::default())
        .expect_err("a rigid rider")
        .to_string();
    assert!(message.contains("joints.legs.free"), "{message}");
}

fn bicycle(case: Case) -> Multibody {
    let p = Parameters::bulsink2017(BulsinkBicycle::One, case, &Reading::default());
    Multibody::new(&p).expect("valid")
}

/// The rigid rider with arms of the window table: their mass, stiffness and damping, on tyres.
fn rigid_with_arms() -> Multibody {
    let reading = Reading::default();
    let set = |case| Parameters::bulsink2017(BulsinkBicycle::One, case, &reading);
    let mut p = set(Case::TyresRigid);
    p.rider = set(Case::NoSlipArmMass).rider;
    p.arms = set(Case::Full).arms;
    Multibody::new(&p).expect("valid")
}

/// Roots in the right half plane by the argument principle: n/2 less the turns of the determinant
/// (times the lags' denominators) from 0 to infinity on the imaginary axis, over π.
fn unstable_roots(closed: &ClosedLoop, order: usize) -> f64 {
    let mut turned = 0.0;
    let mut last: Option<f64> = None;
    for i in 0..=40_000 {
        // Geometric from 1e-4 to 1e4 rad/s.
        let omega = 1e-4 * libm::pow(1e8, f64::from(i) / 40_000.0);
        let f = closed.characteristic(Complex::new(0.0, omega));
        let phase = libm::atan2(f.im, f.re);
        if let Some(last) = last {
            let mut step = phase - last;
            step -= 2.0 * core::f64::consts::PI * libm::round(step / (2.0 * core::f64::consts::PI));
            turned += step;
        }
        last = Some(phase);
    }
    0.5 * order as f64 - turned / core::f64::consts::PI
}

#[test]
fn unstable_eigenvalues_are_as_many_as_the_argument_principle_counts() {
    let model = bicycle(Case::TyresRigid);
    for (file, speed) in [
        (one("steer_torque", 0.21), 4.0),
        (one("steer_torque", 0.12), 7.0),
        (one("steer_angle", 0.25), 3.0),
        (one("steer_angle", 0.1), 6.0),
    ] {
        let at = LateralBicycle::new(&model, speed, 20.0).expect("steady");
        // Heading aside: its slow root would need a longer axis.
        let mut channels = file.rider.linear(speed);
        channels[0].delayed.heading = 0.0;
        let closed = ClosedLoop::new(&at, &channels);
        let roots = closed.eigenvalues().expect("found");
        let counted: f64 = roots
            .iter()
            .filter(|r| r.re > 0.0)
            .map(|r| if r.im > 0.0 { 2.0 } else { 1.0 })
            .sum();
        let turned = unstable_roots(&closed, at.order());
        assert!(
            (turned - counted).abs() < 0.05,
            "{turned} against {counted} {roots:?}"
        );
        for root in roots.iter().take(3) {
            let f = closed.characteristic(*root);
            let beside = closed.characteristic(root + Complex::new(1e-3, 0.0));
            assert!(f.norm_sqr() < 1e-12 * beside.norm_sqr(), "{root} is a root");
        }
    }
}

#[test]
fn growth_of_the_closed_loop_is_that_of_a_ride() {
    let model = bicycle(Case::Full);
    // Trunk and knees beside the bar, so that every path counts.
    let mut file = one("steer_angle", 0.2);
    file.rider.trunk_lean = one("trunk_lean", 0.06).rider.trunk_lean;
    file.rider.knees = one("knees", 0.1).rider.knees;
    for limb in [
        &mut file.rider.trunk_lean.as_mut().expect("there").0,
        &mut file.rider.knees.as_mut().expect("there").0,
    ] {
        limb.gains[0].heading_ratio = 0.0;
    }
    file.rider.steer_angle.as_mut().expect("there").0.gains[0].heading_ratio = 0.0;
    let speed = 4.0;
    let expected = stability(&model, &file, 0.0, &[speed]).expect("steady")[0];
    let p = model.parameters();
    let mut plant = Ride::new(p, None, speed).expect("settles");
    let mut state = *plant.state();
    let pitch = state.yaw_roll_pitch_rad().2;
    state.set_attitude_rad(0.0, 1e-7, pitch);
    plant.set_state(&state);
    let mut rider = file.start(1, STEP_S).expect("valid");
    let hold = plant.input().rear_traction_nm;
    // Size of the swing, with the phase taken out by its rate.
    let mut sizes = Vec::new();
    for tick in 0..9_000 {
        let t = plant.truth();
        let seen = Perception {
            roll_rad: t.roll_rad,
            roll_rate_rad_s: t.roll_rate_rad_s,
            steer_rad: t.steer_rad,
            steer_rate_rad_s: t.steer_rate_rad_s,
            trunk_lean_rad: t.trunk_lean_rad,
            trunk_lean_rate_rad_s: t.trunk_lean_rate_rad_s,
            legs_rad: t.legs_rad,
            leg_rates_rad_s: t.leg_rates_rad_s,
            yaw_rad: 0.0,
            speed_m_s: speed,
            wanted_speed_m_s: speed,
        };
        let action = rider.act(&seen, STEP_S);
        let input = PlantInput {
            rear_traction_nm: hold,
            steer_torque_nm: action.steer_torque_nm,
            trunk_lean_torque_nm: action.trunk_lean_torque_nm,
            leg_torque_nm: action.leg_torque_nm,
            ..PlantInput::default()
        };
        plant.step(&input, STEP_S);
        // x(t) x''(t) - x'(t)² of e^(st) swings is -ω² times the squared size: three samples do.
        if tick >= 3_000 && tick % 100 == 0 {
            sizes.push((t.roll_rad, t.roll_rate_rad_s));
        }
    }
    let w = expected.frequency_rad_s;
    let g = expected.growth_per_s;
    let size = |(roll, rate): (f64, f64)| libm::hypot(roll, (rate - g * roll) / w);
    let (first, last) = (size(sizes[0]), size(sizes[sizes.len() - 1]));
    let growth = libm::log(last / first) / (0.1 * (sizes.len() - 1) as f64);
    assert!(w > 0.5, "a swing: {expected:?}");
    assert!(
        (growth - g).abs() < 0.01 * (1.0 + g.abs()),
        "ride {growth}, closed loop {g} 1/s at {w} rad/s"
    );
}

#[test]
fn windows_of_a_torque_rider_are_those_of_the_prototype() {
    // Speed, delay, pair; smallest and largest k_p of an independent prototype, about ±1 Nm/rad.
    let cells = [
        (3.0, 0.21, 0.0, None),
        (4.0, 0.21, 80.0, Some((7.0, 14.0))),
        (5.0, 0.21, 0.0, Some((17.0, 21.0))),
        (5.0, 0.21, 40.0, Some((12.0, 18.0))),
        (6.0, 0.21, 20.0, Some((10.0, 19.0))),
    ];
    let model = rigid_with_arms();
    for (speed, delay, pair, expected) in cells {
        let at = LateralBicycle::new(&model, speed, pair).expect("steady");
        let found = windows(&at, delay, 5.0, 25.0);
        match expected {
            None => assert!(found.is_empty(), "{speed} m/s: {found:?}"),
            Some((from, to)) => {
                assert_eq!(found.len(), 1, "{speed} m/s, {pair} Nm: {found:?}");
                let w = found[0];
                // The lower border hangs on the arms' reading and on the delay's: within 2.
                assert!(
                    (w.from_nm_rad - from).abs() < 2.0 && (w.to_nm_rad - to).abs() < 1.0,
                    "{speed} m/s, {pair} Nm: {w:?} against {from} to {to}"
                );
            }
        }
    }
    // No derivative gain helps at walking pace.
    let at = LateralBicycle::new(&model, 3.0, 0.0).expect("steady");
    assert!(least_growth(&at, 0.21, 20.0).0 > 0.3);
}

#[test]
fn published_riders_stay_up_or_do_not() {
    let full = bicycle(Case::Full);
    let grows = |table: Table, group: Group, speed: f64| {
        let row = published::rows(table)
            .into_iter()
            .find(|r| r.group == group && r.speed_m_s == speed)
            .expect("printed");
        stability(&full, &row.rider(), 0.0, &[speed]).expect("steady")[0].growth_per_s
    };
    for row in published::rows(Table::SteerTorque) {
        assert!(
            grows(Table::SteerTorque, row.group, row.speed_m_s) > 1.0,
            "{row:?}"
        );
    }
    for row in published::rows(Table::SteerAngle) {
        let growth = grows(Table::SteerAngle, row.group, row.speed_m_s);
        let stays = row.group == Group::Young && row.speed_m_s == 2.0;
        assert!(
            (growth < 0.0) == stays && growth.abs() < 1.1,
            "{row:?}: {growth}"
        );
    }
    // Leaning alone keeps nobody up.
    assert!(grows(Table::TrunkLean, Group::Young, 3.0) > 1.0);
    assert_eq!(Table::ALL.map(|t| published::rows(t).len()), [6, 6, 6]);
}
