//! A small design from plan to law file, and what a check makes of a proof that has been tampered with.

use std::sync::OnceLock;
use twinhub_control::{Bicycle, Config, Law};
use twinhub_design::certificate::{Certificate, Entry, Plan};
use twinhub_design::check::check;
use twinhub_design::family::FactorBox;
use twinhub_design::loops::Rider;
use twinhub_design::plan::run;
use twinhub_design::program::Cones;
use twinhub_design::{DesignError, law};
use twinhub_plant::bicycles::load_multibody;
use twinhub_plant::multibody::Parameters;

const BICYCLE: &str = "bulsink2017_bicycle1_full";

/// The bicycle as a bench might tell the controller.
const TOLD: Bicycle = Bicycle {
    front_wheel_radius_m: 0.35,
    rear_wheel_radius_m: 0.35,
    wheelbase_m: 1.15,
    steer_tilt_rad: 0.360_796_33,
    front_load_n: 345.678_9,
    rear_load_n: 616.1,
    com_height_m: 0.962_3,
};

fn bicycle(changes: &[&str]) -> Parameters {
    load_multibody(BICYCLE, changes).expect("ships")
}

fn plan() -> Plan {
    Plan {
        bicycle: BICYCLE.to_owned(),
        joints_free: false,
        riders: vec![Entry {
            rider: Rider {
                name: "young".to_owned(),
                delay_s: 0.12,
                lag_rad_s: 30.0,
                lag_damping_ratio: 0.707,
            },
            parts: [1, 1, 1],
        }],
        uncertainty: FactorBox {
            mass: [0.98, 1.02],
            load: [0.98, 1.02],
            twisting: [0.95, 1.05],
        },
        speeds_m_s: (0..7).map(|k| 6.5 + 0.25 * f64::from(k)).collect(),
        torque_max_nm: 20.0,
        half_width_nm: 5.0,
        rate_m_s2: 0.2,
        slope_nm_per_m_s: 30.0,
        loss_growth_per_s: 0.7,
        friction_ratio: 0.6,
        cones: Cones::Dominant,
    }
}

fn certificate() -> &'static Certificate {
    static MADE: OnceLock<Certificate> = OnceLock::new();
    MADE.get_or_init(|| run(&plan(), &bicycle(&[]), &|_| true).expect("a plan that can be proved"))
}

fn wrong(certificate: &Certificate, parameters: &Parameters) -> Vec<String> {
    let checked = check(certificate, parameters, &|_, _| true).expect("has a model");
    assert_eq!(checked.holds, checked.wrong.is_empty());
    checked.wrong
}

#[test]
fn a_narrow_plan_is_proved_with_a_pair_and_the_proof_holds() {
    let certificate = certificate();
    assert!(
        certificate.cells.iter().all(|proved| *proved),
        "{:?}",
        certificate.stops
    );
    assert!(certificate.schedule.iter().any(|p| p.torque_nm >= 15.0));
    let checked = check(certificate, &bicycle(&[]), &|_, _| true).expect("has a model");
    assert!(checked.holds, "{:?}", checked.wrong);
    assert_eq!(checked.proved_m_s, [[6.5, 8.0]]);
    assert!(
        checked.inequalities >= 6 * 8 * 18,
        "{}",
        checked.inequalities
    );
    assert!(
        checked.interpolation_ratio < 1e-3,
        "{}",
        checked.interpolation_ratio
    );
}

#[test]
fn another_bicycle_fails_with_the_line_that_differs() {
    let changed = bicycle(&["rider.trunk.mass_kg=45.6"]);
    let wrong = wrong(certificate(), &changed);
    assert!(
        wrong
            .iter()
            .any(|w| w.contains("[rider.trunk]") && w.contains("mass_kg = 45.6")),
        "{wrong:?}"
    );
}

#[test]
fn a_proof_that_was_tampered_with_fails() {
    let bicycle = bicycle(&[]);
    let mut gains = certificate().clone();
    gains.pieces[0].nodes[2].gains[0] += 40.0;
    assert!(
        wrong(&gains, &bicycle)
            .iter()
            .any(|w| w.contains("inequality"))
    );

    let mut matrix = certificate().clone();
    for entry in &mut matrix.pieces[0].nodes[3].lyapunov {
        *entry *= 3.0;
    }
    assert!(
        wrong(&matrix, &bicycle)
            .iter()
            .any(|w| w.contains("inequality"))
    );

    let mut missing = certificate().clone();
    missing.pieces[0].nodes[1].lyapunov.clear();
    assert!(
        wrong(&missing, &bicycle)
            .iter()
            .any(|w| w.contains("missing"))
    );

    let mut wider = certificate().clone();
    wider.plan.uncertainty.twisting = [0.5, 2.0];
    assert!(
        wrong(&wider, &bicycle)
            .iter()
            .any(|w| w.contains("uncertainty"))
    );

    let mut higher = certificate().clone();
    higher.schedule[3].torque_nm += 20.0;
    assert!(wrong(&higher, &bicycle).iter().any(|w| w.contains("tube")));

    let mut steep = certificate().clone();
    steep.plan.loss_growth_per_s = -3.0;
    assert!(wrong(&steep, &bicycle).iter().any(|w| w.contains("loss")));
}

#[test]
fn the_law_file_is_read_back_and_refuses_another_bicycle_or_schedule() {
    let text = law::file(certificate(), &TOLD).expect("fits the controller");
    let config: Config = toml::from_str(&text).expect("reads back");
    assert_eq!(config.check(), Ok(()));
    assert_eq!(config.bicycle, TOLD);
    let Law::Scheduled(scheduled) = &config.law else {
        panic!("a schedule: {text}");
    };
    for point in &certificate().schedule {
        let pair_nm = f64::from(scheduled.points.pair_nm(point.speed_m_s as f32));
        assert!(
            (pair_nm - point.torque_nm).abs() < 0.06,
            "{point:?} {pair_nm}"
        );
    }
    let mut other = toml::from_str::<Config>(&text).expect("reads");
    other.bicycle.wheelbase_m += 0.01;
    assert!(other.check().is_err());
}

#[test]
fn where_nothing_can_be_proved_the_schedule_is_zero_and_the_reason_is_said() {
    // One rider, used to one bicycle, on any from half to twice the twisting torque, at walking pace.
    let mut wide = plan();
    wide.uncertainty.twisting = [0.5, 2.0];
    wide.speeds_m_s = vec![2.0, 2.25, 2.5];
    let certificate = run(&wide, &bicycle(&[]), &|_| true).expect("ends");
    assert!(certificate.schedule.iter().all(|p| p.torque_nm == 0.0));
    assert!(certificate.cells.iter().all(|proved| !proved));
    assert_eq!(certificate.stops.len(), 1);
    let config = law::config(&certificate, &TOLD).expect("a law");
    assert!(matches!(config.law, Law::Off(_)));
}

#[test]
fn a_plan_that_makes_no_sense_is_refused_and_a_wish_to_stop_is_heard() {
    let mut plan = plan();
    plan.half_width_nm = f64::NAN;
    let error = run(&plan, &bicycle(&[]), &|_| true).expect_err("no number");
    assert!(error.to_string().contains("tube"), "{error}");
    plan.half_width_nm = 5.0;
    assert_eq!(
        run(&plan, &bicycle(&[]), &|_| false),
        Err(DesignError::Stopped)
    );
}
