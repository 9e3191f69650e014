//! `twinhub` as its users start it: two processes, kills, Ctrl-C, two rides at once.

use serde_json::Value;
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

fn twinhub(dir: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_twinhub"));
    command
        .args(arguments)
        .current_dir(dir)
        .env("TWINHUB_RUN_DIR", dir.join("run"));
    command
}

fn json(output: &Output) -> Value {
    let error = String::from_utf8_lossy(&output.stderr);
    serde_json::from_slice(&output.stdout).unwrap_or_else(|e| panic!("no JSON ({e}): {error}"))
}

fn digests(output: &Output) -> Vec<String> {
    let value = json(output);
    let runs = value["runs"].as_array().expect("runs");
    runs.iter()
        .map(|r| r["digest"].as_str().expect("digest").to_owned())
        .collect()
}

/// A ride so long that a test has time to disturb it.
const LONG: [&str; 5] = ["ride", "first_ride", "--json", "--set", "duration_s=36000"];

/// Started with its own standard error, which is returned when it ends.
fn start(dir: &Path, arguments: &[&str]) -> Child {
    twinhub(dir, arguments)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("starts")
}

/// Pids of the children of `parent` that run the hidden command `role`.
fn children(parent: u32, role: &str) -> Vec<u32> {
    let Ok(entries) = std::fs::read_dir("/proc") else {
        return Vec::new();
    };
    entries
        .filter_map(|e| e.ok()?.file_name().to_str()?.parse::<u32>().ok())
        .filter(|pid| {
            let stat = std::fs::read_to_string(format!("/proc/{pid}/stat")).unwrap_or_default();
            let after = stat.rsplit(')').next().unwrap_or("");
            let command = std::fs::read(format!("/proc/{pid}/cmdline")).unwrap_or_default();
            after.split_whitespace().nth(1) == Some(parent.to_string().as_str())
                && String::from_utf8_lossy(&command).contains(role)
        })
        .collect()
}

/// Waits until the ride has come some way, and gives the pid of the child.
fn riding(ride: &Child, dir: &Path, role: &str) -> u32 {
    let deadline = Instant::now() + Duration::from_secs(60);
    let log = dir.join("rides/first_ride/off.mcap");
    while Instant::now() < deadline {
        let far = std::fs::metadata(&log).is_ok_and(|m| m.len() > 1_000_000);
        if let (true, Some(pid)) = (far, children(ride.id(), role).first()) {
            return *pid;
        }
        std::thread::sleep(Duration::from_millis(10));
    }
    panic!("no {role} after a minute");
}

fn signal(pid: u32, name: &str) {
    let done = Command::new("kill")
        .args([&format!("-{name}"), &pid.to_string()])
        .status()
        .expect("kill runs");
    assert!(done.success(), "kill -{name} {pid}");
}

/// Waits for the end; nothing here may hang.
fn end(mut ride: Child) -> Output {
    let deadline = Instant::now() + Duration::from_secs(60);
    while ride.try_wait().expect("can be waited for").is_none() {
        if Instant::now() > deadline {
            let _ = ride.kill();
            panic!("the ride hangs");
        }
        std::thread::sleep(Duration::from_millis(10));
    }
    ride.wait_with_output().expect("output")
}

/// The log that is left opens, and a next ride in the same place is clean.
fn left_in_order(dir: &Path) {
    let log = twinhub_log::read(dir.join("rides/first_ride/off.mcap")).expect("the log opens");
    let ticks = log
        .column(twinhub_log::PLANT_TRUTH, "roll_rad")
        .expect("has ticks")
        .len();
    assert!(ticks > 1000, "{ticks} ticks");
    let next = twinhub(dir, &["ride", "--json", "--set", "duration_s=1"])
        .output()
        .expect("starts");
    assert_eq!(
        next.status.code(),
        Some(0),
        "{}",
        String::from_utf8_lossy(&next.stderr)
    );
    // Shared memory is one place for all rides of a user: that of a ride which another test has just
    // killed is seen here too, until that ride's survivor has cleared up.
    let run = twinhub_link::RunDir::at(dir.join("run"));
    let deadline = Instant::now() + Duration::from_secs(20);
    let mut left = twinhub_link::leftovers(&run);
    while !left.is_empty() && Instant::now() < deadline {
        std::thread::sleep(Duration::from_millis(50));
        left = twinhub_link::leftovers(&run);
    }
    assert_eq!(left, Vec::<std::path::PathBuf>::new());
}

#[test]
fn two_processes_and_one_give_the_same_digests() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let two = twinhub(dir.path(), &["ride", "--json", "--set", "duration_s=5"])
        .output()
        .expect("starts");
    let one = twinhub(
        dir.path(),
        &["ride", "--json", "--set", "duration_s=5", "--in-process"],
    )
    .output();
    let (two, one) = (digests(&two), digests(&one.expect("starts")));
    assert_eq!(two.len(), 2);
    assert_eq!(two, one);
    assert_ne!(two[0], two[1]);
    assert!(dir.path().join("rides/three_to_eight/report.html").exists());
    assert!(dir.path().join("rides/three_to_eight-2/on.mcap").exists());
}

#[test]
fn killing_the_controller_ends_the_ride_with_words_and_a_log() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let ride = start(dir.path(), &LONG);
    signal(riding(&ride, dir.path(), "controller-process"), "KILL");
    let output = end(ride);
    let words = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(3), "{words}");
    assert!(
        words.contains("the controller's process was killed by signal 9"),
        "{words}"
    );
    left_in_order(dir.path());
}

#[test]
fn killing_the_plant_ends_the_ride_with_words_and_a_log() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let ride = start(dir.path(), &LONG);
    signal(riding(&ride, dir.path(), "plant-process"), "KILL");
    let output = end(ride);
    let words = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(3), "{words}");
    assert!(
        words.contains("the plant's process was killed by signal 9"),
        "{words}"
    );
    assert!(
        words.contains("to zero") || words.contains("no torque"),
        "{words}"
    );
    left_in_order(dir.path());
}

#[test]
fn killing_the_command_itself_leaves_no_process_behind() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let ride = start(dir.path(), &LONG);
    let plant = riding(&ride, dir.path(), "plant-process");
    let controller = children(ride.id(), "controller-process");
    signal(ride.id(), "KILL");
    end(ride);
    let deadline = Instant::now() + Duration::from_secs(30);
    for pid in controller.into_iter().chain([plant]) {
        // A zombie has no memory map of its own; whoever adopts it will reap it.
        let alive = || std::fs::read(format!("/proc/{pid}/cmdline")).is_ok_and(|c| !c.is_empty());
        while alive() {
            assert!(Instant::now() < deadline, "process {pid} lives on");
            std::thread::sleep(Duration::from_millis(10));
        }
    }
    left_in_order(dir.path());
}

#[test]
fn ctrl_c_stops_in_order() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let ride = start(dir.path(), &LONG);
    riding(&ride, dir.path(), "plant-process");
    signal(ride.id(), "INT");
    let output = end(ride);
    let words = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(130), "{words}");
    assert!(words.contains("stopped after"), "{words}");
    let log = twinhub_log::read(dir.path().join("rides/first_ride/off.mcap")).expect("opens");
    log.verify().expect("a stopped ride's log is complete");
    left_in_order(dir.path());
}

#[test]
fn two_rides_at_once_do_not_disturb_each_other() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let arguments = ["ride", "--json", "--set", "duration_s=5"];
    let rides = [start(dir.path(), &arguments), start(dir.path(), &arguments)];
    let [a, b] = rides.map(end);
    assert_eq!(digests(&a), digests(&b));
    assert_ne!(
        json(&a)["report"],
        json(&b)["report"],
        "each has a directory of its own"
    );
}

#[test]
fn timing_tells_how_long_exchanges_took_in_every_pacing_and_waiting() {
    let dir = tempfile::tempdir().expect("temporary directory");
    for more in [
        ["--pacing=lockstep", "--waiting=spin", "--target=process"],
        ["--pacing=lockstep", "--waiting=block", "--target=process"],
        ["--pacing=realtime", "--waiting=block", "--target=process"],
        ["--pacing=realtime", "--waiting=spin", "--target=in-process"],
    ] {
        let mut arguments = vec!["ride", "--json", "--set", "duration_s=0.5"];
        arguments.extend(more);
        let output = twinhub(dir.path(), &arguments).output().expect("starts");
        let value = json(&output);
        for run in value["runs"].as_array().expect("runs") {
            let timing = &run["timing"];
            let number = |path: &str| timing.pointer(path).and_then(Value::as_f64);
            for quantile in ["p50", "p99", "p999", "max"] {
                let round_trip = number(&format!("/round_trip_us/{quantile}"));
                assert!(round_trip.expect("a number") > 0.0, "{more:?}: {timing}");
                assert!(number(&format!("/lateness_us/{quantile}")).is_some());
            }
            assert!(timing["instructions_per_tick"].is_null(), "{timing}");
            let factor = number("/real_time_factor").expect("a number");
            let real_time = more[0].ends_with("realtime");
            assert!(factor > 0.0 && (!real_time || factor < 1.01), "{factor}");
            let late = number("/lateness_us/count").expect("a number");
            assert_eq!(late > 0.0, real_time);
            if more[2].ends_with("=process") {
                assert!(number("/controller/compute_us/p50").expect("a number") > 0.0);
            }
        }
    }
}

#[test]
fn faults_of_the_link_have_one_digest_in_one_process_and_two() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let ride = |more: &[&str]| {
        let mut arguments = vec!["ride", "--json", "--set", "duration_s=3"];
        arguments.extend(more);
        twinhub(dir.path(), &arguments).output().expect("starts")
    };
    let fault = "--fault=late,to_plant,start_s=1,delay_s=0.01,jitter_s=0.01";
    let two = digests(&ride(&[fault]));
    assert_eq!(two, digests(&ride(&[fault, "--in-process"])));
    assert_ne!(two[1], digests(&ride(&["--in-process"]))[1]);
    for (wrong, word) in [
        ("--fault=late,to_plant", "delay_s"),
        ("--fault=late,to_moon,delay_s=0.1", "to_moon"),
        ("--fault=dropout,to_plant,share_ratio=2", "share_ratio"),
        ("--fault=dropout", "channel"),
    ] {
        let output = ride(&[wrong]);
        let words = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{words}");
        assert!(words.contains(word), "{words}");
    }
}

#[test]
fn the_doctor_says_what_was_found_what_is_wanted_and_how_to_get_it() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let output = twinhub(dir.path(), &["doctor", "--json"])
        .output()
        .expect("starts");
    assert_eq!(output.status.code(), Some(0));
    let value = json(&output);
    assert_eq!(value["rides"], true);
    let findings = value["findings"].as_array().expect("findings");
    for finding in findings {
        assert!(finding["found"].is_string() && finding["wanted"].is_string());
        let how = finding["how"].as_str().expect("how");
        assert_eq!(how.is_empty(), finding["ok"] == true, "{finding}");
    }
    // Where the run directory is open to others, no ride works.
    let open = dir.path().join("run");
    use std::os::unix::fs::PermissionsExt;
    std::fs::set_permissions(&open, std::fs::Permissions::from_mode(0o755)).expect("ours");
    let output = twinhub(dir.path(), &["doctor"]).output().expect("starts");
    assert_eq!(output.status.code(), Some(3));
    let words = String::from_utf8_lossy(&output.stdout);
    assert!(
        words.contains("missing") && words.contains("chmod 700"),
        "{words}"
    );
}

#[test]
fn a_little_torture_leaves_nothing_behind() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let arguments = [
        "torture", "--kills", "6", "--seed", "7", "--jobs", "2", "--json",
    ];
    let output = twinhub(dir.path(), &arguments).output().expect("starts");
    let value = json(&output);
    assert_eq!(output.status.code(), Some(0), "{value}");
    assert_eq!(value["passed"], true);
    assert_eq!(value["kills"], 6);
    assert_eq!(
        (&value["deadlocks"], &value["leaks"]),
        (&0.into(), &0.into())
    );
    assert!(value["loss_noticed_us"]["count"].as_u64() > Some(0));
}
