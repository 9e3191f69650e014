//! The rules of the house: which crate may use which, how long a file may be, and that documents
//! speak of files that exist.

use closed_loop_tests::root;
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::process::Command;

/// What each crate may use, of ours (development dependencies aside).
const ARROWS: &[(&str, &[&str])] = &[
    ("twinhub-types", &[]),
    ("twinhub-control", &["twinhub-types"]),
    ("twinhub-linear", &["twinhub-types"]),
    ("twinhub-mechanism", &["twinhub-types", "twinhub-linear"]),
    (
        "twinhub-plant",
        &["twinhub-types", "twinhub-linear", "twinhub-mechanism"],
    ),
    ("twinhub-link", &["twinhub-types"]),
    ("twinhub-log", &["twinhub-types"]),
    (
        "twinhub-sim",
        &[
            "twinhub-types",
            "twinhub-linear",
            "twinhub-plant",
            "twinhub-control",
            "twinhub-link",
            "twinhub-log",
        ],
    ),
    ("twinhub-design", &["twinhub-control", "twinhub-plant"]),
    (
        "twinhub-league",
        &[
            "twinhub-types",
            "twinhub-control",
            "twinhub-plant",
            "twinhub-link",
            "twinhub-sim",
        ],
    ),
    ("twinhub-ident", &["twinhub-types", "twinhub-linear"]),
    (
        "twinhub-diagnose",
        &[
            "twinhub-types",
            "twinhub-linear",
            "twinhub-mechanism",
            "twinhub-plant",
            "twinhub-ident",
            "twinhub-log",
        ],
    ),
    ("twinhub-hidden", &["twinhub-types"]),
    ("twinhub-blind", &["twinhub-hidden", "twinhub-diagnose"]),
    (
        "twinhub-report",
        &["twinhub-types", "twinhub-linear", "twinhub-log"],
    ),
    (
        "twinhub-reproduce",
        &[
            "twinhub-linear",
            "twinhub-plant",
            "twinhub-ident",
            "twinhub-report",
        ],
    ),
    (
        "firmware-sim",
        &["twinhub-types", "twinhub-control", "twinhub-link"],
    ),
];

/// May use every crate but these.
const ALMOST_ALL: &[(&str, &[&str])] = &[
    ("twinhub", &["twinhub-python"]),
    ("twinhub-python", &["firmware-sim", "twinhub"]),
    ("closed-loop-tests", &[]),
];

#[test]
fn arrows_between_crates_point_one_way() {
    let output = Command::new(env!("CARGO"))
        .args([
            "metadata",
            "--format-version",
            "1",
            "--no-deps",
            "--offline",
        ])
        .current_dir(root())
        .output()
        .expect("cargo metadata runs");
    let metadata: Value = serde_json::from_slice(&output.stdout).expect("cargo metadata is JSON");
    let mut uses: BTreeMap<&str, BTreeSet<&str>> = BTreeMap::new();
    for package in metadata["packages"].as_array().expect("packages") {
        let name = package["name"].as_str().expect("name");
        let of_ours = package["dependencies"]
            .as_array()
            .expect("dependencies")
            .iter()
            .filter(|d| d["kind"].is_null());
        uses.insert(name, of_ours.filter_map(|d| d["name"].as_str()).collect());
    }
    let ours: BTreeSet<&str> = uses.keys().copied().collect();
    for (name, used) in &uses {
        for other in used.intersection(&ours) {
            let allowed = match ARROWS.iter().find(|(n, _)| n == name) {
                Some((_, may)) => may.contains(other),
                None => ALMOST_ALL
                    .iter()
                    .find(|(n, _)| n == name)
                    .is_some_and(|(_, may_not)| !may_not.contains(other)),
            };
            assert!(allowed, "{name} may not use {other}");
        }
    }
}

fn tracked(pattern: &str) -> Vec<String> {
    let output = Command::new("git")
        .args(["ls-files", "--", pattern])
        .current_dir(root())
        .output()
        .expect("git runs");
    String::from_utf8_lossy(&output.stdout)
        .lines()
        .map(str::to_owned)
        .collect()
}

#[test]
fn no_source_file_is_longer_than_700_lines() {
    let long: Vec<String> = ["*.rs", "*.py"]
        .iter()
        .flat_map(|pattern| tracked(pattern))
        .filter_map(|file| {
            let lines = std::fs::read_to_string(root().join(&file))
                .ok()?
                .lines()
                .count();
            (lines > 700).then(|| format!("{file}: {lines} lines"))
        })
        .collect();
    assert!(long.is_empty(), "split these: {long:?}");
}

#[test]
fn documents_speak_of_files_that_exist() {
    for document in ["README.md", "ARCHITECTURE.md"] {
        let text = std::fs::read_to_string(root().join(document)).expect("document");
        let words = text.split(|c: char| c.is_whitespace() || "`()[],;".contains(c));
        for word in words.map(|w| w.trim_end_matches(['.', ':'])) {
            let is_path = ["crates/", "tests/", "firmware_sim/", "python/"]
                .iter()
                .any(|p| word.starts_with(p));
            assert!(
                !is_path || Path::new(&root().join(word)).exists(),
                "{document} speaks of {word}"
            );
        }
    }
}
