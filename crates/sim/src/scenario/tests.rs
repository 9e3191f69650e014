//! Every scenario that ships runs, runs are deterministic and balanced, and what is wrong is told.

use super::*;
use crate::shipped;

fn load(name: &str, set: &[&str]) -> Result<Scenario, SetupError> {
    let set: Vec<String> = set.iter().map(|s| (*s).to_owned()).collect();
    Scenario::load(name, &set)
}

fn recorded(name: &str, set: &[&str]) -> Recording {
    record(&load(name, set).unwrap(), &mut |_| true).unwrap()
}

#[test]
fn every_scenario_that_ships_runs_and_survives_toml() {
    for file in shipped::SCENARIOS {
        let scenario = load(file.name, &["duration_s=0.2"]).unwrap();
        let text = scenario.to_toml();
        assert_eq!(
            toml::from_str::<Scenario>(&text).unwrap(),
            scenario,
            "{text}"
        );
        let recording = record(&scenario, &mut |_| true).unwrap();
        assert_eq!(recording.rows() as u64, recording.summary.rows);
        for name in recording.names() {
            let column = recording.column(name).unwrap();
            assert!(
                column.iter().all(|v| v.is_finite()),
                "{}: {name}",
                file.name
            );
            let plain = name.ends_with("_ratio") || name == "winding_celsius";
            assert!(plain || unit(name) != "-" || name.ends_with("_j"), "{name}");
        }
    }
}

#[test]
fn the_same_scenario_gives_the_same_bytes() {
    let set = [
        "duration_s=1.0",
        "start.roll_rad=0.02",
        "motors=\"direct_drive_250w\"",
        "sensors=\"as_bought\"",
    ];
    let with_keys = |text: &str| {
        let mut scenario: Scenario = toml::from_str(text).unwrap();
        scenario.duration_s = 1.0;
        scenario.start.roll_rad = 0.02;
        scenario.motors = Some("direct_drive_250w".to_owned());
        scenario.sensors = Some("as_bought".to_owned());
        scenario
    };
    assert!(
        load("push_7ms_pair", &set).is_ok(),
        "a key that the file leaves out can be set"
    );
    assert!(
        load("push_7ms_pair", &["start.rol_rad=0.02"]).is_err(),
        "a key that there is not cannot"
    );
    let text = shipped::SCENARIOS
        .iter()
        .find(|s| s.name == "push_7ms_pair")
        .unwrap()
        .text;
    let scenario = with_keys(text);
    let csv = || {
        let mut bytes = Vec::new();
        write_csv(&scenario, &mut bytes, &mut |_| true)
            .unwrap()
            .unwrap();
        bytes
    };
    let (a, b) = (csv(), csv());
    assert!(a.len() > 10_000);
    assert_eq!(a, b);
    let head = String::from_utf8_lossy(&a);
    let head = head.lines().next().unwrap();
    for name in [
        "t_s",
        "roll_rad",
        "front_load_n",
        "rider_force_z_n",
        "battery_w",
        "measured_speed_m_s",
    ] {
        assert!(
            head.split(',').any(|n| n == name),
            "{name} is missing in {head}"
        );
    }
}

/// Largest magnitude of a column between two times.
fn swing(recording: &Recording, column: &str, from_s: f64, to_s: f64) -> f64 {
    let t = recording.column("t_s").unwrap();
    let values = recording.column(column).unwrap();
    t.iter()
        .zip(values)
        .filter(|(t, _)| **t >= from_s && **t <= to_s)
        .map(|(_, v)| v.abs())
        .fold(0.0, f64::max)
}

#[test]
fn the_pair_calms_the_push_and_without_it_the_swing_grows() {
    let growth = |name: &str| {
        let r = recorded(name, &["duration_s=8.0", "disturbance.0.start_s=1.0"]);
        assert!(!r.summary.fell);
        swing(&r, "roll_rad", 6.0, 8.0) / swing(&r, "roll_rad", 2.0, 4.0)
    };
    let (off, pair) = (growth("push_7ms_off"), growth("push_7ms_pair"));
    println!("growth of the swing in 4 s: off {off:.3}, pair {pair:.3}");
    assert!(off > 1.2 && pair < 0.9, "{off} {pair}");
}

#[test]
fn a_mirrored_push_gives_the_mirrored_motion() {
    let set = ["duration_s=3.0", "disturbance.0.start_s=0.5"];
    let right = recorded("push_7ms_off", &set);
    let mut scenario = load("push_7ms_off", &set).unwrap();
    scenario.start.trunk_rad = [0.0; 3];
    if let twinhub_plant::disturbance::Disturbance::Push(push) = &mut scenario.disturbance[0].what {
        push.force_n = -push.force_n;
    }
    let left = record(&scenario, &mut |_| true).unwrap();
    for (name, sign) in [
        ("roll_rad", -1.0),
        ("steer_rad", -1.0),
        ("front_load_n", 1.0),
    ] {
        let (a, b) = (right.column(name).unwrap(), left.column(name).unwrap());
        for (a, b) in a.iter().zip(b) {
            assert!(
                (a - sign * b).abs() < 1e-9 * (1.0 + a.abs()),
                "{name}: {a} {b}"
            );
        }
    }
    assert!(swing(&right, "roll_rad", 0.5, 3.0) > 1e-4);
}

#[test]
fn work_and_energy_balance() {
    // No slip, rigid rider, nothing that dissipates: what the push and the motors bring stays.
    let mut scenario = load(
        "push_7ms_off",
        &["duration_s=2.0", "disturbance.0.start_s=0.5"],
    )
    .unwrap();
    scenario.bicycle = "bulsink2017_bicycle1_case1".to_owned();
    scenario.drive = Drive::Coast {};
    scenario.input.push(Input {
        channel: Channel::RearTractionNm,
        shape: Shape::Pulse {
            from_s: 0.2,
            to_s: 1.0,
            value: 10.0,
            ramp_s: 0.1,
        },
    });
    scenario.input.push(Input {
        channel: Channel::SteerTorqueNm,
        shape: Shape::Sine {
            from_s: 0.2,
            to_s: 1.7,
            value: 0.3,
            frequency_hz: 1.0,
        },
    });
    let s = record(&scenario, &mut |_| true).unwrap().summary;
    let e = s.energy;
    println!("{e:?}");
    assert!(e.wheels_j > 100.0 && e.disturbances_j.abs() > 1e-4 && e.rider_j.abs() > 1e-4);
    assert!(e.lost_j.abs() < 1e-3, "{e:?}");
    // On tyres with rolling resistance a coasting bicycle loses speed and energy.
    let mut coasting = load(
        "push_7ms_off",
        &["duration_s=2.0", "disturbance.0.start_s=0.5"],
    )
    .unwrap();
    coasting.drive = Drive::Coast {};
    let s = record(&coasting, &mut |_| true).unwrap().summary;
    // 0.008 of the weight over 14 m, and what wheels and push take or give.
    assert!((80.0..160.0).contains(&s.energy.lost_j), "{:?}", s.energy);
    assert!(s.end_speed_m_s < 6.9, "{}", s.end_speed_m_s);
}

#[test]
fn past_the_friction_limit_the_front_wheel_locks_and_the_bicycle_falls() {
    let r = recorded("past_friction", &[]);
    let s = &r.summary;
    println!(
        "locked {:?}, fell {:?}",
        s.front_wheel_locked_s, s.fall_time_s
    );
    assert!(s.fell && s.front_wheel_locked_s.is_some());
    assert!(s.front_wheel_locked_s < s.fall_time_s);
    assert!(s.duration_s > s.fall_time_s.unwrap() + 0.49);
}

#[test]
fn drives_ramp_to_zero_when_commands_end() {
    let mut scenario = load(
        "push_7ms_pair",
        &["duration_s=3.0", "input.0.shape.pulse.value=20"],
    )
    .unwrap();
    scenario.motors = Some("fixed_85_percent".to_owned());
    scenario.commands_end_s = Some(2.0);
    let r = record(&scenario, &mut |_| true).unwrap();
    assert!((swing(&r, "front_brake_nm", 1.5, 1.9) - 20.0).abs() < 1e-3);
    assert_eq!(swing(&r, "front_brake_nm", 2.5, 3.0), 0.0);
    assert!(swing(&r, "battery_w", 1.5, 1.9) > 10.0);
}

#[test]
fn the_rig_moves_the_bicycle_and_pedals_sway_it() {
    let rig = recorded("rig", &["duration_s=3.0"]);
    assert!(swing(&rig, "rear_road_y_m", 1.0, 3.0) > 1e-3);
    assert!(swing(&rig, "roll_rad", 0.0, 0.9) < 1e-9);
    assert!(swing(&rig, "roll_rad", 1.5, 3.0) > 1e-3);
    let pedals = recorded("pedalling", &["duration_s=3.0"]);
    assert!(swing(&pedals, "roll_rad", 0.5, 3.0) > 1e-5);
    // Crank torque times cadence is the power of the driving force.
    let torque = pedals.column("crank_torque_nm").unwrap();
    // Two whole turns of the crank at one a second, from the first second on.
    let mean = torque[100..300].iter().sum::<f64>() / 200.0;
    let power = mean * core::f64::consts::TAU;
    let spin = pedals.column("rear_spin_rad_s").unwrap();
    let rim = spin[100..300].iter().sum::<f64>() / 200.0 * 0.35;
    assert!((power - 8.0 * rim).abs() < 1e-3 * power, "{power} {rim}");
}

#[test]
fn what_is_wrong_names_its_place() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("mine.toml");
    let text = shipped::SCENARIOS[0].text;
    let said = |text: String| {
        std::fs::write(&file, text).unwrap();
        load(file.to_str().unwrap(), &[]).unwrap_err().to_string()
    };
    let wind = "wind = { along_m_s = 0.0, across_m_s = 5.0 }\nduration_s";
    for (message, parts) in [
        (
            said(text.replace("duration_s = 30.0", "duration_ms = 30.0")),
            &["mine.toml", "line", "duration_ms"][..],
        ),
        (
            said(text.replace("speed_m_s = 7.0", "speed_m_s = 70.0")),
            &["mine.toml", "start.speed_m_s", "70", "0.3 to 15"],
        ),
        (
            said(text.replace("step_s = 0.001", "step_s = nan")),
            &["mine.toml", "step_s", "NaN"],
        ),
        (
            said(text.replace("sample_s = 0.01", "sample_s = 0.0105")),
            &["mine.toml", "sample_s", "whole number"],
        ),
        (
            said(text.replace("bulsink2017_bicycle1_full:tyre=bulsink2017_600n", "nobody")),
            &["nobody", "bulsink2017_bicycle1_full"],
        ),
        (
            said(text.replacen("duration_s", wind, 1)),
            &["wind", "air.drag_area_m2"],
        ),
        (
            said(text.replacen("duration_s =", "motors = \"steam\"\nduration_s =", 1)),
            &["steam", "direct_drive_250w"],
        ),
        (
            said(text.replacen("duration_s =", "commands_end_s = 1.0\nduration_s =", 1)),
            &["commands_end_s", "motors"],
        ),
        (
            load("push_7ms_off", &["start.sped_m_s=3"])
                .unwrap_err()
                .to_string(),
            &["sped_m_s", "speed_m_s"],
        ),
        (
            load("nowhere", &[]).unwrap_err().to_string(),
            &["scenario", "nowhere", "push_7ms_off"],
        ),
    ] {
        for part in parts {
            assert!(message.contains(part), "`{part}` is missing in: {message}");
        }
    }
}
