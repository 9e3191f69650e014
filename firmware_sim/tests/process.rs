//! The real binary against a plant that plays back one scripted ride.

use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::Duration;
use twinhub_link::{ControllerPort, InProcess, PlantEnd, PlantOffer, RideName, RunDir, Settings};
use twinhub_types::messages::PROTOCOL_HASH;
use twinhub_types::{ControllerFrame, PlantFrame, RideState};

fn law() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../crates/control/laws/scheduled.toml")
}

fn run_dir() -> tempfile::TempDir {
    tempfile::Builder::new()
        .permissions(std::fs::Permissions::from_mode(0o700))
        .tempdir()
        .expect("a temporary directory")
}

/// A bicycle that weaves a little at 5 m/s, its stabilizer switched on.
fn frame(tick: u64, state: RideState) -> PlantFrame {
    let time_ns = tick * 1_000_000;
    let sway = libm::sinf(tick as f32 * 0.006);
    let mut frame = PlantFrame::default();
    frame.header.protocol_hash = PROTOCOL_HASH;
    frame.header.sequence = tick;
    frame.header.tick = tick;
    frame.header.time_ns = time_ns;
    frame.header.state = state as u32;
    let m = &mut frame.measurement;
    m.imu.stamp_ns = time_ns;
    m.imu.gyro_rad_s = [0.1 * sway, 0.0, 0.05 * sway];
    m.imu.accel_m_s2 = [0.0, 0.2 * sway, -9.81];
    m.roll.stamp_ns = time_ns;
    m.roll.roll_rad = 0.02 * sway;
    m.steer.stamp_ns = time_ns;
    m.steer.steer_rad = 0.03 * sway;
    m.steer.steer_rate_rad_s = 0.01;
    m.wheels.stamp_ns = time_ns;
    m.wheels.speed_m_s = 5.0;
    m.wheels.front_rad_s = 5.0 / 0.343;
    m.wheels.rear_rad_s = 5.0 / 0.343;
    m.motors.stamp_ns = time_ns;
    m.motors.bus_v = 36.0;
    frame.intent.stamp_ns = time_ns;
    frame.intent.assist_on = 1;
    frame.intent.pedalling = 1;
    frame
}

fn ride(port: &mut impl ControllerPort, ticks: u64, last: RideState) -> Vec<ControllerFrame> {
    (0..ticks)
        .map(|tick| {
            let state = if tick + 1 == ticks {
                last
            } else {
                RideState::Running
            };
            port.exchange(&frame(tick, state))
                .expect("a living controller")
                .expect("lockstep knows no silence")
        })
        .collect()
}

fn offer(dir: &Path) -> PlantOffer {
    let mut settings = Settings::new(RideName::new("scripted").expect("a name"));
    settings.run_dir = RunDir::at(dir);
    settings.patience = Some(Duration::from_secs(20));
    PlantOffer::open(settings).expect("shared memory")
}

fn firmware(dir: &Path, more: &[&str]) -> Child {
    Command::new(env!("CARGO_BIN_EXE_firmware_sim"))
        .args(["--ride", "scripted", "--wait-s", "20", "--law"])
        .arg(law())
        .arg("--run-dir")
        .arg(dir)
        .args(more)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("firmware_sim")
}

fn end(child: Child) -> (Option<i32>, String, String) {
    let Output {
        status,
        stdout,
        stderr,
    } = child.wait_with_output().expect("it ends");
    let text = |bytes| String::from_utf8(bytes).expect("text");
    (status.code(), text(stdout), text(stderr))
}

/// Bits, because a NaN would not equal itself.
fn bits(frames: &[ControllerFrame]) -> Vec<Vec<u8>> {
    use twinhub_types::Wire;
    let bytes = |frame: &ControllerFrame| {
        let mut bytes = vec![0; ControllerFrame::SIZE];
        assert!(frame.put(&mut bytes).is_some());
        bytes
    };
    frames.iter().map(bytes).collect()
}

#[test]
fn two_processes_answer_with_the_same_bits_as_one() {
    let config = firmware_sim::read_law(&law()).expect("a law");
    let alone = ride(
        &mut InProcess::new({
            let mut controller = twinhub_control::Controller::new(&config);
            move |frame: &PlantFrame| controller.answer(frame)
        }),
        4000,
        RideState::Fell,
    );
    let torque = alone
        .iter()
        .map(|f| f.output.command.front_brake_nm)
        .fold(0.0, f32::max);
    assert!(
        torque > 1.0,
        "the script must make the pair act, got {torque} Nm"
    );
    for waiting in ["spin", "block"] {
        let dir = run_dir();
        let offer = offer(dir.path());
        let child = firmware(dir.path(), &["--json", "--waiting", waiting]);
        let mut plant: PlantEnd = offer.accept().expect("firmware_sim joins");
        let both = ride(&mut plant, 4000, RideState::Fell);
        drop(plant);
        assert_eq!(bits(&both), bits(&alone));
        let (code, out, err) = end(child);
        assert_eq!(code, Some(1), "the bicycle fell: {err}");
        let summary: serde_json::Value = serde_json::from_str(&out).expect("JSON alone on stdout");
        assert_eq!(summary["ticks"], 4000);
        assert_eq!(summary["ended"], "fell");
        assert!(summary["compute_us"]["p50"].as_f64().expect("a number") > 0.0);
    }
}

#[test]
fn a_finished_ride_ends_with_0_and_words_on_standard_error() {
    let dir = run_dir();
    let offer = offer(dir.path());
    let child = firmware(dir.path(), &[]);
    let mut plant = offer.accept().expect("firmware_sim joins");
    ride(&mut plant, 50, RideState::Finished);
    drop(plant);
    let (code, out, err) = end(child);
    assert_eq!((code, out.as_str()), (Some(0), ""), "{err}");
    assert!(err.contains("finished after 50 ticks"), "{err}");
}

#[test]
fn a_plant_that_leaves_ends_in_a_ramp_to_zero_and_exit_code_3() {
    let dir = run_dir();
    let offer = offer(dir.path());
    let child = firmware(dir.path(), &[]);
    let mut plant = offer.accept().expect("firmware_sim joins");
    for tick in 0..4000 {
        plant
            .exchange(&frame(tick, RideState::Running))
            .expect("an answer");
    }
    drop(plant);
    let (code, _, err) = end(child);
    assert_eq!(code, Some(3), "{err}");
    assert!(err.contains("closed the link at tick 4000"), "{err}");
    assert!(
        err.contains("ramped from") && err.contains("to zero in"),
        "{err}"
    );
}

#[test]
fn bad_law_files_end_in_2_and_name_the_place() {
    let dir = run_dir();
    let good = std::fs::read_to_string(law()).expect("the law");
    let cases = [
        (good.replace("wheelbase_m", "wheelbase_mm"), "wheelbase_mm"),
        (
            good.replace("ramp_up_nm_s = 20.0", "ramp_up_nm_s = nan"),
            "ramp_up_nm_s",
        ),
        (
            good.replace("speed_max_m_s = 12.0", "speed_max_m_s = \"fast\""),
            "fast",
        ),
    ];
    for (text, place) in cases {
        let path = dir.path().join("law.toml");
        std::fs::write(&path, &text).expect("a file");
        let output = Command::new(env!("CARGO_BIN_EXE_firmware_sim"))
            .args(["--ride", "x", "--law"])
            .arg(&path)
            .output()
            .expect("firmware_sim");
        let err = String::from_utf8(output.stderr).expect("text");
        assert_eq!(output.status.code(), Some(2), "{err}");
        assert!(err.contains("law.toml") && err.contains(place), "{err}");
    }
    let missing = Command::new(env!("CARGO_BIN_EXE_firmware_sim"))
        .args(["--ride", "x", "--law", "no_such_law.toml"])
        .output()
        .expect("firmware_sim");
    assert_eq!(missing.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&missing.stderr).contains("no_such_law.toml"));
}

#[test]
fn nobody_there_ends_in_3_and_says_where_it_looked() {
    let dir = run_dir();
    let output = Command::new(env!("CARGO_BIN_EXE_firmware_sim"))
        .args(["--ride", "lonely", "--wait-s", "0.1", "--law"])
        .arg(law())
        .arg("--run-dir")
        .arg(dir.path())
        .output()
        .expect("firmware_sim");
    let err = String::from_utf8(output.stderr).expect("text");
    assert_eq!(output.status.code(), Some(3), "{err}");
    assert!(err.contains("lonely") && err.contains("no plant"), "{err}");
}
