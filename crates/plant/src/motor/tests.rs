//! Conformance suite: what every motor, drive and power train must do.

use super::*;
use twinhub_types::{Command, Duration, Instant};

const STEP: Duration = Duration::from_millis(1);

fn at(ms: u64) -> Instant {
    Instant::from_nanos(ms * 1_000_000)
}

fn drive(motor: MotorDrive, dead_time_s: f64, lag_s: f64) -> Drive {
    let watchdog = Watchdog::STANDARD;
    Drive::new(DriveParameters {
        dead_time_s,
        lag_s,
        watchdog,
        motor,
    })
    .unwrap()
}

#[test]
fn every_entry_is_listed_explained_valid_and_survives_toml() {
    let examples = MotorDrive::examples();
    assert_eq!(MotorDrive::NAMES.len(), examples.len());
    for (name, motor) in MotorDrive::NAMES.iter().zip(examples) {
        assert_eq!(*name, motor.name());
        assert_eq!(*name, motor.explain().name);
        assert!(motor.explain().is_complete(), "{name}");
        motor.validate().unwrap();
    }
    for (name, about) in sets::SETS {
        assert!(!about.is_empty());
        let set = sets::named(name).unwrap();
        let text = toml::to_string(&set).unwrap();
        let back: PowerTrainParameters = toml::from_str(&text).unwrap();
        assert_eq!(back, set, "{name}");
        let typo = text.replacen("lag_s", "lags_s", 1);
        assert!(
            toml::from_str::<PowerTrainParameters>(&typo).is_err(),
            "{name}: a typo passes"
        );
        PowerTrain::new(&set).unwrap();
    }
    assert!(sets::named("no_such_set").is_none());
}

#[test]
fn a_wrong_parameter_is_refused_with_its_range() {
    let mut hub = sets::hub_28mm();
    hub.machine.resistance_ohm = -1.0;
    let error = MotorDrive::DirectDrive(hub).validate().unwrap_err();
    assert_eq!((error.field, error.found), ("resistance_ohm", -1.0));
    let error = Watchdog {
        silence_s: 0.0,
        ramp_s: 0.1,
    }
    .validate()
    .unwrap_err();
    assert_eq!(error.field, "silence_s");
}

#[test]
fn finite_input_gives_finite_output_and_no_motor_makes_energy() {
    for motor in MotorDrive::examples() {
        for rate in [-50.0, -1.0, 0.0, 0.01, 3.0, 14.0, 40.0, 200.0] {
            for torque in [-1e6, -80.0, -5.0, 0.0, 5.0, 80.0, 1e6] {
                for bus_v in [0.0, 20.0, 48.0, 60.0] {
                    let mut state = MotorState {
                        rotor_rad_s: rate,
                        ..MotorState::default()
                    };
                    let point = motor.point(torque, rate, &state, bus_v);
                    let shaft = motor.finish(&point, rate, &mut state, 1e-3);
                    let loss = point.copper_w + point.drive_w + shaft.friction_w;
                    let out = shaft.torque_nm * rate + shaft.stored_w + loss;
                    let scale = 1.0 + point.electrical_w.abs() + loss.abs();
                    assert!(out.is_finite() && state.winding_celsius.is_finite());
                    assert!(
                        (point.electrical_w - out).abs() < 1e-9 * scale,
                        "{} at {torque} Nm {rate} rad/s {bus_v} V: in {} out {out}",
                        motor.name(),
                        point.electrical_w
                    );
                    assert!(
                        loss >= -1e-9 * scale,
                        "{} at {torque} Nm {rate} rad/s {bus_v} V makes {loss} W",
                        motor.name()
                    );
                }
            }
        }
    }
}

#[test]
fn a_silent_controller_is_noticed_after_20_ms_and_the_torque_is_gone_after_200() {
    for motor in MotorDrive::examples() {
        let mut d = drive(motor, 0.003, 0.005);
        let rate = 8.0;
        for ms in 0..1000 {
            d.step(at(ms), Some(30.0), rate, 48.0, STEP);
        }
        // the last command came at 999 ms
        let mut previous = f64::INFINITY;
        for ms in 1000..1500 {
            // NaN is no command
            let command = if ms % 2 == 0 { None } else { Some(f64::NAN) };
            let out = d.step(at(ms), command, rate, 48.0, STEP);
            let silence = ms - 999;
            assert_eq!(
                out.watchdog_active,
                silence > 20,
                "{} {silence} ms",
                motor.name()
            );
            assert!(out.current_a <= previous + 1e-12, "never rises");
            previous = out.current_a;
            if silence >= 200 {
                assert_eq!(out.reported_nm, 0.0, "{} {silence} ms", motor.name());
                assert_eq!(out.electrical_w, 0.0);
            } else if silence < 190 {
                assert!(
                    out.reported_nm > 0.0,
                    "{} a ramp, not a step: {silence} ms",
                    motor.name()
                );
            }
        }
        let out = d.step(at(1500), Some(30.0), rate, 48.0, STEP);
        assert!(!out.watchdog_active, "a new command ends it");
    }
}

#[test]
fn before_the_first_command_a_drive_is_off() {
    let mut d = drive(MotorDrive::DirectDrive(sets::hub_28mm()), 0.0, 0.0);
    let out = d.step(at(0), None, 10.0, 48.0, STEP);
    assert_eq!((out.current_a, out.electrical_w), (0.0, 0.0));
    assert!(out.torque_nm < 0.0, "an open direct drive drags");
}

#[test]
fn dead_time_is_exact_in_ticks_and_the_lag_is_first_order() {
    let ideal = MotorDrive::Ideal(Ideal {});
    for dead in [0u32, 1, 3, 20, 63] {
        let mut d = drive(ideal, f64::from(dead) * 1e-3, 0.0);
        d.step(at(0), Some(0.0), 1.0, 48.0, STEP);
        for ms in 0..100 {
            let out = d.step(at(ms + 1), Some(10.0), 1.0, 48.0, STEP);
            let expected = if ms >= u64::from(dead) { 10.0 } else { 0.0 };
            assert_eq!(out.torque_nm, expected, "dead {dead} tick {ms}");
        }
    }
    let mut d = drive(ideal, 0.0, 0.01);
    for ms in 0..50u32 {
        let out = d.step(at(u64::from(ms)), Some(10.0), 1.0, 48.0, STEP);
        let expected = 10.0 * (1.0 - libm::exp(-f64::from(ms + 1) / 10.0));
        assert!((out.torque_nm - expected).abs() < 1e-12);
    }
}

#[test]
fn the_250_w_hub_has_the_torques_of_its_class() {
    let hub = sets::hub_28mm();
    let m = MotorDrive::DirectDrive(hub);
    let cold = MotorState {
        winding_celsius: 20.0,
        ..MotorState::default()
    };
    let peak = m.point(1e3, 5.0, &cold, 48.0).motor_nm;
    assert!((peak - 80.0).abs() < 1.0, "peak {peak}");
    // continuous: the torque whose copper loss the hub sheds at the start of derating
    let span = hub.machine.derate_start_celsius - hub.thermal.ambient_celsius;
    let hot_ohm = hub.machine.resistance_ohm * (1.0 + 0.00393 * (110.0 - 25.0));
    let continuous = hub.machine.torque_constant_nm_per_a
        * libm::sqrt(span / hub.thermal.resistance_k_per_w / hot_ohm);
    assert!(
        (20.0..40.0).contains(&continuous),
        "continuous {continuous}"
    );
    let good = m.efficiency_ratio(10.0, 25.0, 20.0, 48.0);
    let bad = m.efficiency_ratio(80.0, 5.0, 20.0, 48.0);
    assert!((0.75..0.92).contains(&good), "10 Nm at 25 rad/s: {good}");
    assert!(bad < 0.35, "80 Nm at 5 rad/s is mostly heat: {bad}");
}

#[test]
fn heat_derates_a_hub_held_at_peak() {
    let mut d = drive(MotorDrive::DirectDrive(sets::hub_28mm()), 0.0, 0.0);
    let mut first = 0.0;
    let mut last = DriveOutput::default();
    for ms in 0..400_000 {
        last = d.step(at(ms), Some(80.0), 8.0, 48.0, STEP);
        if ms == 0 {
            first = last.reported_nm;
        }
    }
    assert!((first - 80.0).abs() < 0.5);
    assert!(
        last.limited && last.reported_nm < 50.0,
        "{}",
        last.reported_nm
    );
    assert!(last.winding_celsius < 150.0);
}

/// A balanced pair for `ticks`, and what it cost.
fn pair(set: &PowerTrainParameters, nm: f32, rate: f64, ticks: u64) -> (PowerOutput, f64, f64) {
    let mut train = PowerTrain::new(set).unwrap();
    let command = Command {
        front_brake_nm: nm,
        rear_traction_nm: nm,
    };
    let (mut to_wheels_j, mut heat_j) = (0.0, 0.0);
    let mut out = PowerOutput::default();
    for ms in 0..ticks {
        out = train.step(at(ms), Some(command), rate, rate, STEP);
        to_wheels_j += (out.front.mechanical_w + out.rear.mechanical_w) * 1e-3;
        heat_j +=
            (out.front.heat_w + out.rear.heat_w + out.front.stored_w + out.rear.stored_w) * 1e-3;
    }
    (out, to_wheels_j, heat_j)
}

#[test]
fn energy_from_the_battery_is_work_plus_heat_plus_what_the_chopper_burnt() {
    for (name, _) in sets::SETS {
        let set = sets::named(name).unwrap();
        let (out, work_j, heat_j) = pair(&set, 30.0, 12.0, 5_000);
        let net = out.energy.net_j();
        let sum = work_j + heat_j + out.energy.burnt_j;
        assert!(
            (net - sum).abs() < 1e-6 * (1.0 + heat_j.abs()),
            "{name}: {net} J against {sum} J"
        );
    }
}

#[test]
fn the_ideal_pair_is_exact_and_free_and_85_percent_costs_what_it_says() {
    let (out, _, _) = pair(&sets::named("ideal").unwrap(), 80.0, 14.5, 1_000);
    assert_eq!((out.front_brake_nm, out.rear_traction_nm), (80.0, 80.0));
    assert_eq!(out.energy.net_j(), 0.0);
    // 40 Nm at 5 m/s: the published figure for 85 % each way is about 190 W
    let rate = 5.0 / 0.3515;
    let (out, _, _) = pair(&sets::named("fixed_85_percent").unwrap(), 40.0, rate, 1_000);
    let expected = 40.0 * rate * (1.0 / 0.85 - 0.85);
    assert!((out.energy.net_j() - expected).abs() < 1e-6 * expected);
    assert!((expected - 190.0).abs() < 5.0, "{expected} W");
}

#[test]
fn the_supply_is_never_overdrawn_and_a_full_battery_weakens_the_brake() {
    let set = sets::named("direct_drive_250w").unwrap();
    let (out, _, _) = pair(&set, 80.0, 20.0, 200);
    let Battery::LithiumIon(cells) = set.battery else {
        unreachable!()
    };
    assert!(
        out.bus_a <= cells.discharge_limit_a * (1.0 + 1e-6),
        "{} A",
        out.bus_a
    );
    assert!(
        out.rear.limited && out.rear_traction_nm < 75.0,
        "{}",
        out.rear_traction_nm
    );
    assert!(
        out.front_brake_nm > 75.0,
        "the front motor regenerates and is not to blame"
    );

    let brake = |battery| {
        let set = PowerTrainParameters {
            battery: Battery::LithiumIon(battery),
            ..set
        };
        let mut train = PowerTrain::new(&set).unwrap();
        let command = Command {
            front_brake_nm: 30.0,
            rear_traction_nm: 0.0,
        };
        let mut out = PowerOutput::default();
        for ms in 0..200 {
            out = train.step(at(ms), Some(command), 20.0, 20.0, STEP);
            assert!(out.bus_a >= -cells.charge_limit_a * (1.0 + 1e-6));
        }
        out
    };
    let half = brake(LithiumIon {
        start_charge_ratio: 0.5,
        ..cells
    });
    let full = brake(LithiumIon {
        start_charge_ratio: 1.0,
        ..cells
    });
    let chopper = brake(LithiumIon {
        start_charge_ratio: 1.0,
        chopper_w: 1000.0,
        ..cells
    });
    assert!(half.front_reported_nm > 29.9 && half.bus_a < 0.0);
    assert!(
        full.front_reported_nm < 5.0 && full.front.limited,
        "{}",
        full.front_reported_nm
    );
    assert!(full.bus_a >= -1e-9);
    assert!(chopper.front_reported_nm > 29.9 && chopper.energy.burnt_j > 0.0);
}

#[test]
fn hostile_commands_do_no_harm() {
    let mut train = PowerTrain::new(&sets::named("direct_drive_250w").unwrap()).unwrap();
    let values = [
        f32::NAN,
        f32::INFINITY,
        f32::NEG_INFINITY,
        f32::MAX,
        f32::MIN,
        -50.0,
        0.0,
    ];
    for ms in 0..2_000u64 {
        let pick = |k: u64| values[((ms * k) % 7) as usize];
        let command = Command {
            front_brake_nm: pick(3),
            rear_traction_nm: pick(5),
        };
        let out = train.step(at(ms), Some(command), 10.0, 10.0, STEP);
        assert!(out.front_brake_nm.is_finite() && out.bus_v.is_finite());
        assert!(out.front_brake_nm > -5.0, "the front motor never drives");
        assert!(out.front_brake_nm < 85.0 && out.rear_traction_nm.abs() < 85.0);
    }
}
