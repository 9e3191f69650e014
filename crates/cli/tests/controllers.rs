//! Controllers that are not ours: the examples in Python and C, commands that break the protocol,
//! a target that is missing.

use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

fn examples() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../link/controllers")
}

fn ride(dir: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_twinhub"));
    command
        .args(["ride", "--json", "--set", "duration_s=4"])
        .args(arguments)
        .current_dir(dir);
    command
}

fn runs(output: &Output) -> Vec<Value> {
    let error = String::from_utf8_lossy(&output.stderr);
    let value: Value =
        serde_json::from_slice(&output.stdout).unwrap_or_else(|e| panic!("no JSON ({e}): {error}"));
    value["runs"].as_array().expect("runs").clone()
}

fn digests(runs: &[Value]) -> Vec<&str> {
    runs.iter()
        .filter_map(|run| run["digest"].as_str())
        .collect()
}

#[test]
fn the_examples_in_python_and_c_ride_the_same_over_pipes_and_a_socket() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let python = examples().join("controller.py");
    let command = format!("python3 {}", python.display());
    let output = ride(dir.path(), &["--controller", &command]).output();
    let piped = runs(&output.expect("starts"));
    assert_eq!(digests(&piped).len(), 2);
    assert_eq!(piped[0]["energy_j"], 0.0, "switched off in the first ride");
    let energy_j = piped[1]["energy_j"].as_f64().expect("a number");
    assert!(energy_j > 1.0, "its pair acts in the second: {energy_j} J");

    let waiting = ride(dir.path(), &["--listen", "ride.sock"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("starts");
    let socket = dir.path().join("ride.sock");
    let deadline = Instant::now() + Duration::from_secs(60);
    while !socket.exists() {
        assert!(Instant::now() < deadline, "no socket after a minute");
        std::thread::sleep(Duration::from_millis(10));
    }
    let joined = Command::new("python3").arg(&python).arg(&socket).status();
    let output = waiting.wait_with_output().expect("ends");
    assert!(joined.expect("starts").success());
    assert_eq!(digests(&runs(&output)), digests(&piped));
    assert!(!socket.exists(), "the socket goes with the command");

    let program = dir.path().join("controller");
    let built = Command::new("cc")
        .args(["-std=c11", "-O2", "-Wall", "-Wextra", "-Werror", "-o"])
        .arg(&program)
        .arg(examples().join("controller.c"))
        .status();
    match built {
        Ok(status) => {
            assert!(status.success(), "cc compiles the example");
            let command = program.display().to_string();
            let output = ride(dir.path(), &["--controller", &command]).output();
            assert_eq!(digests(&runs(&output.expect("starts"))), digests(&piped));
        }
        Err(e) => println!("SKIPPED, no C compiler ({e}): the example in C"),
    }
}

#[test]
fn controllers_that_break_the_protocol_end_the_ride_with_words_and_a_log() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let python = std::fs::read_to_string(examples().join("controller.py")).expect("the example");
    let mutant = |name: &str, from: &str, to: &str| {
        assert!(python.contains(from), "the example has `{from}`");
        let path = dir.path().join(name);
        std::fs::write(&path, python.replacen(from, to, 1)).expect("writes");
        format!("python3 {}", path.display())
    };
    let answer = "answer = frame[:6]";
    let cases = [
        ("exit 7".to_owned(), "died"),
        ("cat".to_owned(), "both have the same role"),
        ("echo no packet at all".to_owned(), "died"),
        (
            mutant(
                "layout.py",
                "LAYOUT, PLANT_FRAME.size",
                "LAYOUT ^ 1, PLANT_FRAME.size",
            ),
            "another message layout",
        ),
        (
            mutant(
                "late.py",
                answer,
                "answer = (frame[0], frame[1] + (frame[2] > 2000)) + frame[2:6]",
            ),
            "sequence is 0x7d2, expected 0x7d1",
        ),
        (
            mutant(
                "dies.py",
                answer,
                "frame[2] < 2000 or sys.exit(9)\n            answer = frame[:6]",
            ),
            "died at tick 2000",
        ),
        (
            mutant(
                "noise.py",
                answer,
                "frame[2] != 2000 or sink.write(b'noise')\n            answer = frame[:6]",
            ),
            "broke the byte stream at tick 2000",
        ),
    ];
    for (command, words) in cases {
        let output = ride(dir.path(), &["--controller", &command]).output();
        let output = output.expect("starts");
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(3), "{command}: {said}");
        assert!(said.contains(words), "{command}: {said}");
    }
    // The last of them had ridden for 2 s in the first of its rides.
    let newest = dir.path().join("rides/three_to_eight-7/off.mcap");
    let log = twinhub_log::read(newest).expect("the log opens");
    let rows = log
        .table(twinhub_log::PLANT_TRUTH)
        .expect("has ticks")
        .len();
    assert!(rows >= 2000, "{rows} ticks");
}

#[test]
fn torques_that_are_no_numbers_do_the_plant_no_harm() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let python = std::fs::read_to_string(examples().join("controller.py")).expect("the example");
    let path = dir.path().join("hostile.py");
    let torques = "(pair_nm, pair_nm, pair_nm, 2, 0, 0) + (0.0,) * 8";
    let hostile = "([float('nan'), 1e38, float('-inf'), -1e38][frame[2] % 4],) * 3 \
                   + (77, 2**32 - 1, 2**32 - 1) + (float('nan'),) * 8";
    assert!(python.contains(torques));
    std::fs::write(&path, python.replacen(torques, hostile, 1)).expect("writes");
    let command = format!("python3 {}", path.display());
    let output = ride(dir.path(), &["--controller", &command]).output();
    let output = output.expect("starts");
    // It may throw the rider off; it may not break the plant.
    assert!(matches!(output.status.code(), Some(0 | 1)), "{output:?}");
    for run in runs(&output) {
        assert!(run["roll_rms_rad"].as_f64().is_some_and(f64::is_finite));
    }
}

#[test]
fn a_missing_image_or_emulator_is_the_environments_fault_and_says_how_to_get_it() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let cortex_m = ["--target", "cortex-m", "--image"];
    let output = ride(dir.path(), &[&cortex_m[..], &["no_such_image"]].concat()).output();
    let output = output.expect("starts");
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(3), "{said}");
    assert!(said.contains("firmware_sim/cortex_m/build"), "{said}");
    std::fs::write(dir.path().join("image"), b"").expect("writes");
    let output = ride(dir.path(), &[&cortex_m[..], &["image"]].concat())
        .env("PATH", dir.path())
        .output()
        .expect("starts");
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(3), "{said}");
    assert!(said.contains("apt-get install qemu-system-arm"), "{said}");
}
