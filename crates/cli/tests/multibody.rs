//! The multibody bicycle from the command line: modes, its file, open-loop runs.

use std::path::Path;
use std::process::Command;

/// Standard output and exit code of `twinhub`.
fn told(dir: &Path, arguments: &[&str]) -> (String, i32) {
    let output = Command::new(env!("CARGO_BIN_EXE_twinhub"))
        .args(arguments)
        .current_dir(dir)
        .output()
        .expect("starts");
    let code = output.status.code().expect("an exit code");
    assert!(
        code <= 1,
        "{arguments:?}: {}",
        String::from_utf8_lossy(&output.stderr)
    );
    (String::from_utf8_lossy(&output.stdout).into_owned(), code)
}

fn json(dir: &Path, arguments: &[&str]) -> serde_json::Value {
    let (text, _) = told(dir, arguments);
    serde_json::from_str(&text).unwrap_or_else(|e| panic!("{arguments:?}: {e}: {text}"))
}

const FULL: &str = "bulsink2017_bicycle1_full";

#[test]
fn modes_of_the_full_model() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let dir = dir.path();
    let modes = |more: &[&str]| {
        let mut arguments = vec![
            "modes",
            "--bicycle",
            FULL,
            "--json",
            "--speeds-m-s",
            "1:12:1",
        ];
        arguments.extend(more);
        json(dir, &arguments)
    };
    let plain = modes(&["--shapes"]);
    assert_eq!(plain["schema_version"], 1);
    let weave = plain["weave_speed_m_s"].as_f64().expect("crosses");
    assert!((7.0..11.0).contains(&weave), "{weave}");
    let points = plain["points"].as_array().expect("points");
    assert_eq!(points.len(), 12);
    for point in points {
        let count = |key: &str| point[key].as_array().map_or(0, Vec::len);
        assert!(count("eigenvalues") > 10);
        for key in ["modes", "dominant_states", "shapes"] {
            assert_eq!(count("eigenvalues"), count(key), "{key}");
        }
        let states = plain["states"].as_array().map_or(0, Vec::len);
        assert_eq!(point["shapes"][0].as_array().map_or(0, Vec::len), states);
    }
    // The pair lowers the weave speed, and with a tenth of the twisting torque it does not.
    let speed = |answer: &serde_json::Value| answer["weave_speed_m_s"].as_f64();
    let pair = modes(&["--torque-nm", "80"]);
    assert!(speed(&pair).expect("crosses") < weave - 0.5, "{pair}");
    // A rear motor alone accelerates the bicycle.
    let rear = modes(&["--rear-torque-nm", "40"]);
    let acceleration = rear["points"][5]["longitudinal_accel_m_s2"].as_f64();
    assert!(acceleration.is_some_and(|a| a > 0.5), "{acceleration:?}");
    // In a steady turn the handlebar stands into the turn.
    let turn = modes(&["--roll-deg", "5"]);
    let steer = turn["points"][5]["steer_rad"].as_f64();
    assert!(steer.is_some_and(|s| s > 0.005), "{steer:?}");
}

#[test]
fn a_bicycle_is_written_edited_and_loaded() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let dir = dir.path();
    let (text, _) = told(dir, &["bicycle", "bulsink2017_bicycle1_case6"]);
    std::fs::write(dir.join("mine.toml"), text).expect("written");
    let modes = |bicycle: &str, set: &str| {
        json(
            dir,
            &[
                "modes",
                "--bicycle",
                bicycle,
                "--set",
                set,
                "--json",
                "--speeds-m-s",
                "6:11:1",
            ],
        )["weave_speed_m_s"]
            .as_f64()
            .expect("crosses")
    };
    let set = "tyre.front.twisting_gain=0.5";
    let (a, b) = (
        modes("mine.toml", set),
        modes("bulsink2017_bicycle1_case6", set),
    );
    assert_eq!(a, b);
    assert!((a - modes("mine.toml", "tyre.front.twisting_gain=1")).abs() > 0.1);
    let (listed, _) = told(dir, &["list", "parameters", "--bicycle", "mine.toml"]);
    assert!(
        listed.contains("tyre.front.magic_formula.twisting_gain"),
        "{listed}"
    );
}

#[test]
fn sensitivities_predict_the_weave_speed() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let dir = dir.path();
    let case6 = |more: &[&str]| {
        let mut arguments = vec!["modes", "--bicycle", "bulsink2017_bicycle1_case6", "--json"];
        arguments.extend(["--speeds-m-s", "7:11:1"]);
        arguments.extend(more);
        json(dir, &arguments)
    };
    let answer = case6(&["--sensitivities"]);
    let all = answer["sensitivities"]["parameters"]
        .as_array()
        .expect("rows");
    assert!(all.len() > 40);
    let path = "geometry.trail_m";
    let row = all.iter().find(|r| r["path"] == path).expect("trail");
    let slope = row["weave_speed_m_s_per_unit"].as_f64().expect("slope");
    let value = row["value"].as_f64().expect("value");
    let at = |trail_m: f64| {
        let set = format!("{path}={trail_m}");
        case6(&["--set", &set])["weave_speed_m_s"]
            .as_f64()
            .expect("crosses")
    };
    let difference = (at(value + 1e-4) - at(value - 1e-4)) / 2e-4;
    assert!(
        (slope - difference).abs() < 1e-3 * difference.abs(),
        "{slope} {difference}"
    );
}

#[test]
fn a_scenario_is_simulated() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let dir = dir.path();
    let run = |csv: &str| {
        json(
            dir,
            &[
                "simulate",
                "past_friction",
                "--csv",
                csv,
                "--set",
                "duration_s=3",
                "--json",
            ],
        )
    };
    let (a, b) = (run("a.csv"), run("b.csv"));
    assert_eq!(a["fell"], true);
    for key in ["fall_time_s", "max_roll_rad", "rows", "energy"] {
        assert_eq!(a[key], b[key], "{key}");
        assert!(!a[key].is_null(), "{key}");
    }
    let read = |name: &str| std::fs::read_to_string(dir.join(name)).expect("rows");
    assert_eq!(read("a.csv"), read("b.csv"));
    let rows = read("a.csv").lines().count() as u64;
    assert_eq!(Some(rows - 1), a["rows"].as_u64());
    let (_, code) = told(dir, &["simulate", "past_friction", "--set", "duration_s=3"]);
    assert_eq!(code, 1, "a fall is exit code 1");
}

const LEAGUE: [&str; 9] = [
    "league",
    "--riders",
    "2",
    "--classes",
    "older",
    "--duration-s",
    "10",
    "--controllers",
    "constant,steering_spring",
];

#[test]
fn shards_of_a_league_put_together_are_the_league() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let dir = dir.path();
    let with = |more: &[&'static str]| -> Vec<&'static str> {
        LEAGUE.iter().copied().chain(more.iter().copied()).collect()
    };
    let whole = json(dir, &with(&["--out", "whole.jsonl", "--json"]));
    told(dir, &with(&["--shard", "1/2", "--out", "one.jsonl"]));
    told(dir, &with(&["--shard", "2/2", "--out", "two.jsonl"]));
    let merged = json(
        dir,
        &[
            "merge",
            "two.jsonl",
            "one.jsonl",
            "--out",
            "both.jsonl",
            "--report",
            "league.html",
            "--json",
        ],
    );
    assert_eq!(merged, whole);
    let sorted = |name: &str| {
        let text = std::fs::read_to_string(dir.join(name)).expect("written");
        let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
        lines.sort();
        lines
    };
    assert_eq!(sorted("both.jsonl"), sorted("whole.jsonl"));
    let page = std::fs::read_to_string(dir.join("league.html")).expect("written");
    assert!(page.contains("<svg") && page.contains("steering_spring"));

    let rows = whole["rows"].as_array().expect("rows");
    let energy = |name: &str| {
        let row = rows
            .iter()
            .find(|r| r["controller"] == name && r["class"] == "older");
        row.expect("a row")["energy_wh_per_km"]["value"]
            .as_f64()
            .expect("a number")
    };
    assert!(energy("constant") > 1.0 && energy("steering_spring").abs() < 1e-6);
    assert_eq!(rows.len(), 3, "off, and the two");
    assert!(rows.iter().all(|r| r["front_locked_ticks"] == 0));

    // Broken off in the middle of a line: the rest is ridden again, the same.
    let text = std::fs::read_to_string(dir.join("whole.jsonl")).expect("written");
    std::fs::write(dir.join("cut.jsonl"), &text[..text.len() - 100]).expect("written");
    let again = json(dir, &with(&["--out", "cut.jsonl", "--json"]));
    assert_eq!(again, whole);
    assert_eq!(sorted("cut.jsonl"), sorted("whole.jsonl"));
}

#[test]
fn a_league_refuses_what_it_cannot_use() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let dir = dir.path();
    std::fs::write(dir.join("no_league.jsonl"), "{\"spec\": 1}\n").expect("written");
    let refused = |arguments: &[&str], parts: &[&str]| {
        let output = Command::new(env!("CARGO_BIN_EXE_twinhub"))
            .args(arguments)
            .current_dir(dir)
            .output()
            .expect("starts");
        let words = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {words}");
        for part in parts {
            assert!(words.contains(part), "`{part}` is missing in: {words}");
        }
    };
    refused(&["league", "--classes", "old"], &["old", "young_firm"]);
    refused(
        &["league", "--controllers", "no_such"],
        &["no_such", "scheduled"],
    );
    refused(
        &["league", "--controllers", "constant,constant"],
        &["constant", "twice"],
    );
    refused(&["league", "--riders", "0"], &["riders", "0", "1 to"]);
    refused(&["league", "--profile", "racing"], &["racing", "en15194"]);
    refused(
        &["league", "--shard", "3/2", "--out", "x.jsonl"],
        &["3/2", "from 1 to N"],
    );
    refused(
        &["merge", "no_league.jsonl"],
        &["no_league.jsonl", "line 1"],
    );
    refused(
        &["faults", "--only", "no such fault"],
        &["no such fault", "steer_angle"],
    );
}

#[test]
fn a_gone_steer_sensor_is_noticed_in_time_and_breaks_no_limit() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let found = json(
        dir.path(),
        &["faults", "--riders", "1", "--only", "steer gone", "--json"],
    );
    let fault = &found["faults"][0];
    assert_eq!(fault["verdict"], "detected", "{fault}");
    assert_eq!(fault["flags"], serde_json::json!(["steer_missing"]));
    assert_eq!(fault["limits_broken"], 0);
}
