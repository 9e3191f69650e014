//! Every command that the README shows does what it says.

use std::path::{Path, PathBuf};
use std::process::Command;

/// Where measured rides are, if they are anywhere.
fn data() -> Option<PathBuf> {
    let beside = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data");
    std::env::var_os("TWINHUB_DATA")
        .map(PathBuf::from)
        .or(Some(beside))
        .filter(|p| p.is_dir())
}

#[test]
fn its_commands_run() {
    let readme = include_str!("../../../README.md");
    let commands: Vec<&str> = readme
        .lines()
        .filter_map(|line| line.strip_prefix("twinhub "))
        .collect();
    assert!(
        commands.len() >= 6,
        "the README shows commands: {commands:?}"
    );
    let dir = tempfile::tempdir().expect("temporary directory");
    for command in commands {
        let data = data();
        if command.contains("--data DIR") && data.is_none() {
            println!("SKIPPED, no measured data (set TWINHUB_DATA): twinhub {command}");
            continue;
        }
        let data = data.map_or(String::new(), |p| p.display().to_string());
        let words = command
            .split_whitespace()
            .map(|word| if word == "DIR" { data.as_str() } else { word });
        let output = Command::new(env!("CARGO_BIN_EXE_twinhub"))
            .args(words)
            .current_dir(dir.path())
            .output()
            .expect("starts");
        let error = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(0), "twinhub {command}: {error}");
        assert!(!output.stdout.is_empty(), "twinhub {command} says nothing");
    }
}
