//! The published schema and the reader accept the same keys and words.

use super::Study;
use serde_json::Value;
use std::collections::BTreeSet;
use std::path::Path;

const SCHEMA: &str = include_str!("../../schema/study.schema.json");

const FULL: &str = r#"
schema_version = 1
name = "all keys"
[bicycle]
model = "benchmark"
parameters = "meijaard2007_benchmark"
[bicycle.tolerances]
IBxx = { ratio = 0.1 }
[[ride]]
file = "a.csv"
use = "fit"
time = { column = "t" }
windows = [{ s = [0.0, 1.0], use = "held_out" }]
hands = "on"
ground = "road"
[[ride.channel]]
column = "v"
quantity = "speed_m_s"
role = "input"
hold = "zero"
[[ride.channel]]
column = "p"
quantity = "roll_rad"
role = "output"
[[ride.law]]
quantity = "steer_torque_nm"
kind = "linear"
of = "roll_rad"
gain = 1.0
[[modes]]
file = "m.csv"
use = "fit"
columns = { speed_m_s = "v", sigma_1_s = "s", omega_rad_s = "o" }
sd = { sigma_1_s = 0.1, omega_rad_s = 0.1 }
"#;

/// The words between back quotes in the parser's complaint about `changed`, after the first.
fn accepted(from: &str, to: &str) -> BTreeSet<String> {
    assert!(FULL.contains(from), "{from}");
    let text = FULL.replacen(from, to, 1);
    let message = Study::parse(&text, Path::new("full.toml"), &[])
        .unwrap_err()
        .to_string();
    assert!(message.contains("zzz"), "{message}");
    message
        .split('`')
        .skip(1)
        .step_by(2)
        .skip(1)
        .map(str::to_owned)
        .collect()
}

fn properties(schema: &Value, pointer: &str) -> BTreeSet<String> {
    schema
        .pointer(pointer)
        .and_then(Value::as_object)
        .unwrap_or_else(|| panic!("{pointer}"))
        .keys()
        .cloned()
        .collect()
}

fn words(schema: &Value, pointer: &str) -> BTreeSet<String> {
    let list = schema
        .pointer(pointer)
        .and_then(Value::as_array)
        .unwrap_or_else(|| panic!("{pointer}"));
    list.iter()
        .filter_map(Value::as_str)
        .map(str::to_owned)
        .collect()
}

#[test]
fn full_study_parses() {
    let study = Study::parse(FULL, Path::new("full.toml"), &[]).unwrap();
    assert_eq!((study.rides.len(), study.modes.len()), (1, 1));
}

#[test]
fn keys_agree() {
    let schema: Value = serde_json::from_str(SCHEMA).unwrap();
    for (from, to, pointer) in [
        ("name =", "zzz = 1\nname =", "/properties"),
        ("model =", "zzz = 1\nmodel =", "/$defs/bicycle/properties"),
        ("ratio = 0.1", "zzz = 0.1", "/$defs/tolerance/properties"),
        ("file = \"a.csv\"", "zzz = 1", "/$defs/ride/properties"),
        (
            "{ column = \"t\"",
            "{ zzz = \"t\"",
            "/$defs/time/properties",
        ),
        (
            "{ s = [0.0",
            "{ zzz = 1, s = [0.0",
            "/$defs/window/properties",
        ),
        ("column = \"v\"", "zzz = 1", "/$defs/channel/properties"),
        ("kind = \"linear\"", "zzz = 1", "/$defs/law/properties"),
        ("file = \"m.csv\"", "zzz = 1", "/$defs/modes/properties"),
        (
            "{ speed_m_s = \"v\"",
            "{ zzz = \"v\"",
            "/$defs/modes/properties/columns/properties",
        ),
        (
            "{ sigma_1_s = 0.1",
            "{ zzz = 0.1",
            "/$defs/modes/properties/sd/properties",
        ),
    ] {
        assert_eq!(
            accepted(from, to),
            properties(&schema, pointer),
            "{pointer}"
        );
    }
}

#[test]
fn words_agree() {
    let schema: Value = serde_json::from_str(SCHEMA).unwrap();
    for (from, to, pointer) in [
        (
            "\"benchmark\"",
            "\"zzz\"",
            "/$defs/bicycle/properties/model/enum",
        ),
        ("use = \"fit\"", "use = \"zzz\"", "/$defs/use/enum"),
        (
            "hands = \"on\"",
            "hands = \"zzz\"",
            "/$defs/ride/properties/hands/enum",
        ),
        (
            "ground = \"road\"",
            "ground = \"zzz\"",
            "/$defs/ride/properties/ground/enum",
        ),
        ("\"speed_m_s\"", "\"zzz\"", "/$defs/quantity/enum"),
        (
            "role = \"input\"",
            "role = \"zzz\"",
            "/$defs/channel/properties/role/enum",
        ),
        (
            "hold = \"zero\"",
            "hold = \"zzz\"",
            "/$defs/channel/properties/hold/enum",
        ),
        (
            "kind = \"linear\"",
            "kind = \"zzz\"",
            "/$defs/law/properties/kind/enum",
        ),
    ] {
        assert_eq!(accepted(from, to), words(&schema, pointer), "{pointer}");
    }
}
