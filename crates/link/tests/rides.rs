//! Rides between real processes: handshake, stops, deaths, and what they leave behind.
//!
//! The other process is this test binary again, told by environment variables what to do.

use rustix::process::{Pid, Signal, kill_process};
use std::os::unix::fs::{MetadataExt, PermissionsExt};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};
use twinhub_link::{
    ControllerEnd, ControllerPort, LinkError, Pacing, PlantEnd, PlantOffer, RideName, RunDir,
    Settings, Timed, Waiting, leftovers,
};
use twinhub_types::messages::PROTOCOL_HASH;
use twinhub_types::{ControllerFrame, PlantFrame, RideState};

/// No assertion of this file is about speed; this only keeps a hang from lasting for ever.
const SOON: Duration = Duration::from_secs(20);

fn settings(run_dir: &Path, ride: &str) -> Settings {
    let mut settings = Settings::new(RideName::new(ride).expect("a legal name"));
    settings.run_dir = RunDir::at(run_dir);
    settings.patience = Some(SOON);
    settings
}

fn run_dir() -> tempfile::TempDir {
    tempfile::Builder::new()
        .prefix("twinhub-test-")
        .permissions(std::fs::Permissions::from_mode(0o700))
        .tempdir()
        .expect("a temporary directory")
}

fn frame(tick: u64, state: RideState) -> PlantFrame {
    let mut frame = PlantFrame::default();
    frame.header.protocol_hash = PROTOCOL_HASH;
    frame.header.sequence = tick;
    frame.header.tick = tick;
    frame.header.time_ns = tick * 1_000_000;
    frame.header.state = state as u32;
    frame.measurement.roll.roll_rad = tick as f32 * 0.5;
    frame
}

fn answer(frame: &PlantFrame) -> ControllerFrame {
    let mut answer = ControllerFrame {
        header: frame.header,
        ..Default::default()
    };
    answer.output.command.front_brake_nm = frame.measurement.roll.roll_rad + 1.0;
    answer
}

/// The other process: does nothing unless it was started by [`start`].
#[test]
fn other_process() {
    let Ok(role) = std::env::var("LINK_TEST_ROLE") else {
        return;
    };
    let text = |name: &str| std::env::var(name).unwrap_or_default();
    let mut settings = settings(Path::new(&text("LINK_TEST_DIR")), &text("LINK_TEST_RIDE"));
    if let Ok(ms) = text("LINK_TEST_PATIENCE_MS").parse() {
        settings.patience = Some(Duration::from_millis(ms));
    }
    if text("LINK_TEST_WAITING") == "block" {
        settings.waiting = Waiting::Block;
    }
    if let Ok(hash) = text("LINK_TEST_HASH").parse() {
        settings.identity.protocol_hash = hash;
        settings.identity.tool = "stranger 9.9.9".to_owned();
    }
    let result = match role.as_str() {
        "controller" => controller(settings),
        "plant" => plant(settings),
        "knock" => std::process::exit(knock(&settings)),
        _ => unreachable!("roles are written in this file"),
    };
    if let Err(error) = result {
        eprintln!("{error}");
        std::process::exit(error.exit_code().into());
    }
    std::process::exit(0);
}

fn controller(settings: Settings) -> Result<(), LinkError> {
    let mut end = ControllerEnd::connect(settings)?;
    loop {
        let frame = end.receive()?;
        end.send(&answer(&frame))?;
        if RideState::from_u32(frame.header.state) != RideState::Running {
            return end.finish();
        }
    }
}

/// Bytes that the plant says to somebody who only knocks; -1 if there is no way in.
fn knock(settings: &Settings) -> i32 {
    use std::io::{Read, Write};
    let socket = settings.run_dir.socket(&settings.ride);
    let Ok(mut stream) = std::os::unix::net::UnixStream::connect(socket) else {
        return -1;
    };
    let _ = stream.write_all(&[b'x'; 128]);
    stream.read(&mut [0; 128]).unwrap_or(0) as i32
}

fn plant(settings: Settings) -> Result<(), LinkError> {
    let mut end = PlantEnd::connect(settings)?;
    for tick in 0.. {
        end.exchange(&frame(tick, RideState::Running))?;
    }
    Ok(())
}

struct Other(Child);

impl Other {
    fn pid(&self) -> Pid {
        Pid::from_child(&self.0)
    }

    fn signal(&self, signal: Signal) {
        kill_process(self.pid(), signal).expect("the child is ours");
    }

    /// Its exit code and what it wrote to standard error.
    fn end(mut self) -> (Option<i32>, String) {
        let start = Instant::now();
        while start.elapsed() < SOON {
            if let Some(status) = self.0.try_wait().expect("our child") {
                let mut said = String::new();
                if let Some(mut pipe) = self.0.stderr.take() {
                    std::io::Read::read_to_string(&mut pipe, &mut said).expect("text");
                }
                return (status.code(), said);
            }
            std::thread::sleep(Duration::from_millis(2));
        }
        panic!("the other process hangs");
    }
}

impl Drop for Other {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

fn start(role: &str, dir: &Path, ride: &str, more: &[(&str, &str)]) -> Other {
    let exe = std::env::current_exe().expect("this test binary");
    let child = Command::new(exe)
        .args([
            "other_process",
            "--exact",
            "--nocapture",
            "--test-threads=1",
        ])
        .env("LINK_TEST_ROLE", role)
        .env("LINK_TEST_DIR", dir)
        .env("LINK_TEST_RIDE", ride)
        .envs(more.iter().copied())
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .expect("starting this binary again");
    Other(child)
}

/// Rides ticks `from..to`, the last one as the last frame if `last`.
fn ride(plant: &mut PlantEnd, from: u64, to: u64, last: bool) {
    for tick in from..to {
        let state = if last && tick + 1 == to {
            RideState::Finished
        } else {
            RideState::Running
        };
        let sent = frame(tick, state);
        let got = plant.exchange(&sent).expect("a living controller");
        assert_eq!(got, Some(answer(&sent)));
    }
}

/// All shared memory of the session that `ride` has at the moment.
fn session_files(dir: &Path, ride: &str) -> (String, Vec<PathBuf>) {
    let session = std::fs::read_dir(dir.join(ride))
        .expect("the ride's directory")
        .flatten()
        .find(|entry| entry.path().is_dir())
        .map(|entry| entry.file_name().into_string().expect("hexadecimal"))
        .expect("a session");
    let files = shared_memory_of(&session);
    (session, files)
}

fn shared_memory_of(session: &str) -> Vec<PathBuf> {
    std::fs::read_dir("/dev/shm")
        .expect("shared memory")
        .flatten()
        .map(|entry| entry.path())
        .filter(|path| path.to_string_lossy().contains(session))
        .collect()
}

fn left_over(dir: &Path, session: &str) -> Vec<PathBuf> {
    let mut found = leftovers(&RunDir::at(dir));
    found.retain(|path| path.starts_with(dir) || path.to_string_lossy().contains(session));
    found
}

#[test]
fn frames_go_both_ways_and_nothing_is_left() {
    let dir = run_dir();
    for waiting in ["spin", "block"] {
        let offer = PlantOffer::open(Settings {
            waiting: waiting.parse().expect("a way of waiting"),
            ..settings(dir.path(), "a_ride")
        })
        .expect("shared memory");
        let other = start(
            "controller",
            dir.path(),
            "a_ride",
            &[("LINK_TEST_WAITING", waiting)],
        );
        let mut plant = offer.accept().expect("the controller joins");
        let (session, files) = session_files(dir.path(), "a_ride");
        assert!(files.len() >= 4, "{files:?}");
        ride(&mut plant, 0, 3000, true);
        drop(plant);
        let (code, said) = other.end();
        assert_eq!(code, Some(0), "{said}");
        assert_eq!(shared_memory_of(&session), Vec::<PathBuf>::new());
        assert_eq!(std::fs::read_dir(dir.path()).expect("run dir").count(), 0);
        assert_eq!(left_over(dir.path(), &session), Vec::<PathBuf>::new());
    }
}

#[test]
fn another_layout_is_refused_on_both_sides_by_name() {
    let dir = run_dir();
    let offer = PlantOffer::open(settings(dir.path(), "strange")).expect("shared memory");
    let other = start(
        "controller",
        dir.path(),
        "strange",
        &[("LINK_TEST_HASH", "81985529216486895")],
    );
    let error = offer.accept().err().expect("refused").to_string();
    let (code, said) = other.end();
    assert_eq!(code, Some(3), "{said}");
    for text in [error, said] {
        assert!(text.contains("0123456789abcdef"), "{text}");
        assert!(text.contains(&format!("{PROTOCOL_HASH:016x}")), "{text}");
        assert!(
            text.contains("stranger 9.9.9") && text.contains("layout"),
            "{text}"
        );
    }
}

#[test]
fn a_visitor_that_speaks_something_else_is_turned_away_and_the_ride_goes_on() {
    let dir = run_dir();
    let notes = Arc::new(Mutex::new(String::new()));
    let heard = notes.clone();
    let mut settings = settings(dir.path(), "visited");
    settings.notice = Arc::new(move |text| heard.lock().expect("notes").push_str(text));
    let socket = settings.run_dir.socket(&settings.ride);
    let offer = PlantOffer::open(settings).expect("shared memory");
    let visitor = std::thread::spawn(move || {
        use std::io::Write;
        for words in [&b"GET / HTTP/1.1\r\n"[..], &[0xff; 4096]] {
            let mut stream = std::os::unix::net::UnixStream::connect(&socket).expect("a listener");
            let _ = stream.write_all(words);
        }
    });
    visitor.join().expect("the visitor");
    let other = start("controller", dir.path(), "visited", &[]);
    let mut plant = offer.accept().expect("the controller joins after all");
    ride(&mut plant, 0, 100, true);
    drop(plant);
    assert_eq!(other.end().0, Some(0));
    let notes = notes.lock().expect("notes");
    assert!(notes.contains("turned away"), "{notes}");
}

#[test]
fn a_stopped_controller_is_waited_for() {
    let dir = run_dir();
    let offer = PlantOffer::open(settings(dir.path(), "stopped")).expect("shared memory");
    let other = start("controller", dir.path(), "stopped", &[]);
    let mut plant = offer.accept().expect("the controller joins");
    ride(&mut plant, 0, 500, false);
    other.signal(Signal::STOP);
    let pid = other.pid();
    let waker = std::thread::spawn(move || {
        std::thread::sleep(Duration::from_secs(1));
        kill_process(pid, Signal::CONT).expect("the child lives");
    });
    ride(&mut plant, 500, 1000, true);
    waker.join().expect("the waker");
    drop(plant);
    assert_eq!(other.end().0, Some(0));
}

#[test]
fn a_killed_controller_ends_the_wait_and_the_next_ride_of_that_name_is_clean() {
    let dir = run_dir();
    for kill_after in [0, 1, 700] {
        let offer = PlantOffer::open(settings(dir.path(), "killed")).expect("shared memory");
        let other = start("controller", dir.path(), "killed", &[]);
        let mut plant = offer.accept().expect("the controller joins");
        ride(&mut plant, 0, kill_after, false);
        let (session, _) = session_files(dir.path(), "killed");
        other.signal(Signal::KILL);
        let mut tick = kill_after;
        let error = loop {
            // The frame may still cross the kill.
            match plant.exchange(&frame(tick, RideState::Running)) {
                Ok(_) => tick += 1,
                Err(error) => break error,
            }
        };
        assert!(
            matches!(error, LinkError::PeerDied { pid, tick: at } if pid == plant.peer_pid() && at == tick),
            "{error}"
        );
        drop(plant);
        assert_eq!(left_over(dir.path(), &session), Vec::<PathBuf>::new());
        assert_eq!(shared_memory_of(&session), Vec::<PathBuf>::new());
    }
}

#[test]
fn a_killed_plant_is_noticed_and_the_next_ride_of_that_name_is_clean() {
    let dir = run_dir();
    for _ in 0..3 {
        let other = start("plant", dir.path(), "orphan", &[]);
        let mut end = ControllerEnd::connect(settings(dir.path(), "orphan")).expect("a plant");
        for _ in 0..200 {
            let frame = end.receive().expect("frames");
            end.send(&answer(&frame)).expect("room");
        }
        let (session, files) = session_files(dir.path(), "orphan");
        assert!(files.len() >= 4, "{files:?}");
        other.signal(Signal::KILL);
        let error = loop {
            match end.receive() {
                Ok(frame) => end.send(&answer(&frame)).expect("room"),
                Err(error) => break error,
            }
        };
        assert!(matches!(error, LinkError::PeerDied { .. }), "{error}");
        drop(end);
        assert_eq!(shared_memory_of(&session), Vec::<PathBuf>::new());
        assert_eq!(left_over(dir.path(), &session), Vec::<PathBuf>::new());
    }
}

#[test]
fn both_killed_leave_nothing_after_the_next_start() {
    let dir = run_dir();
    let plant = start("plant", dir.path(), "both", &[]);
    let controller = start("controller", dir.path(), "both", &[]);
    let start_time = Instant::now();
    // Both have joined once the plant has taken its offer away.
    while std::fs::read_dir(dir.path().join("both")).map_or(0, Iterator::count) < 2
        || session_files(dir.path(), "both").1.len() < 8
    {
        assert!(start_time.elapsed() < SOON, "they never met");
        std::thread::sleep(Duration::from_millis(5));
    }
    let (session, files) = session_files(dir.path(), "both");
    assert!(!files.is_empty());
    plant.signal(Signal::KILL);
    controller.signal(Signal::KILL);
    drop((plant, controller));
    let offer = PlantOffer::open(settings(dir.path(), "both")).expect("the name is free again");
    assert_eq!(shared_memory_of(&session), Vec::<PathBuf>::new());
    assert_eq!(left_over(dir.path(), &session), Vec::<PathBuf>::new());
    let other = start("controller", dir.path(), "both", &[]);
    let mut plant = offer.accept().expect("the controller joins");
    ride(&mut plant, 0, 100, true);
    drop(plant);
    assert_eq!(other.end().0, Some(0));
}

#[test]
fn two_rides_at_once_stay_apart_and_a_name_is_taken_once() {
    let dir = run_dir();
    let open = |name: &str| PlantOffer::open(settings(dir.path(), name));
    let (first, second) = (open("a").expect("free"), open("a_b").expect("free"));
    let taken = open("a").err().expect("a living plant has it").to_string();
    assert!(taken.contains(&std::process::id().to_string()), "{taken}");
    let others = ["a", "a_b"].map(|name| start("controller", dir.path(), name, &[]));
    let mut first = first.accept().expect("joined");
    let mut second = second.accept().expect("joined");
    assert_ne!(first.peer_pid(), second.peer_pid());
    ride(&mut first, 0, 300, false);
    ride(&mut second, 0, 100, true);
    drop(second);
    ride(&mut first, 300, 600, true);
    drop(first);
    for other in others {
        assert_eq!(other.end().0, Some(0));
    }
}

#[test]
fn the_stop_flag_ends_every_wait() {
    let dir = run_dir();
    let stop = Arc::new(AtomicBool::new(false));
    let with_stop = |name: &str| Settings {
        stop: stop.clone(),
        ..settings(dir.path(), name)
    };
    let offer = PlantOffer::open(with_stop("waiting")).expect("shared memory");
    let other = start("controller", dir.path(), "waiting", &[]);
    let mut plant = offer.accept().expect("joined");
    ride(&mut plant, 0, 10, false);
    other.signal(Signal::STOP);
    let flag = stop.clone();
    let raiser = std::thread::spawn(move || {
        std::thread::sleep(Duration::from_millis(200));
        flag.store(true, Ordering::Relaxed);
    });
    let mut tick = 10;
    let error = loop {
        // Some frames may still be answered before the signal arrives.
        match plant.exchange(&frame(tick, RideState::Running)) {
            Ok(_) => tick += 1,
            Err(error) => break error,
        }
    };
    assert!(matches!(error, LinkError::Interrupted), "{error}");
    assert_eq!(error.exit_code(), 130);
    raiser.join().expect("the raiser");
    let error = PlantEnd::connect(with_stop("nobody"))
        .err()
        .expect("nobody joins");
    assert!(matches!(error, LinkError::Interrupted), "{error}");
    let error = ControllerEnd::connect(with_stop("no_plant"))
        .err()
        .expect("no plant");
    assert!(matches!(error, LinkError::Interrupted), "{error}");
}

#[test]
fn only_this_user_can_enter() {
    let dir = run_dir();
    let _offer = PlantOffer::open(settings(dir.path(), "private")).expect("shared memory");
    let (_, files) = session_files(dir.path(), "private");
    for file in &files {
        let mode = std::fs::metadata(file).expect("a file").mode() & 0o777;
        assert_eq!(
            mode & 0o077,
            0,
            "{} is open to others: {mode:o}",
            file.display()
        );
    }
    let meta = std::fs::metadata(dir.path().join("private")).expect("the ride's directory");
    assert_eq!(meta.mode() & 0o777, 0o700);

    let open = run_dir();
    std::fs::set_permissions(open.path(), std::fs::Permissions::from_mode(0o755)).expect("ours");
    let error = PlantOffer::open(settings(open.path(), "x"))
        .err()
        .expect("refused");
    assert!(matches!(error, LinkError::NotPrivate { .. }), "{error}");
    assert!(error.to_string().contains("0755"), "{error}");
    let error = ControllerEnd::connect(settings(open.path(), "x"))
        .err()
        .expect("refused");
    assert!(matches!(error, LinkError::NotPrivate { .. }), "{error}");
}

/// Runs `command` as another user, if this process may; `None` if not.
fn as_nobody(role: &str, dir: &Path, ride: &str) -> Option<std::process::Output> {
    if !rustix::process::geteuid().is_root() {
        println!("SKIPPED: only root can try to join as another user");
        return None;
    }
    // The other user has to reach this test binary, but not the ride.
    let copy = tempfile::Builder::new()
        .permissions(std::fs::Permissions::from_mode(0o755))
        .tempdir()
        .expect("a temporary directory");
    let exe = copy.path().join("rides");
    // Not by ourselves: a child that another test starts meanwhile would hold the copy open.
    let copied = Command::new("cp")
        .arg(std::env::current_exe().expect("this test binary"))
        .arg(&exe)
        .status();
    assert!(copied.expect("cp runs").success());
    let output = Command::new("setpriv")
        .args(["--reuid=65534", "--regid=65534", "--clear-groups", "--"])
        .arg(&exe)
        .args([
            "other_process",
            "--exact",
            "--nocapture",
            "--test-threads=1",
        ])
        .env("LINK_TEST_ROLE", role)
        .env("LINK_TEST_DIR", dir)
        .env("LINK_TEST_RIDE", ride)
        .env("LINK_TEST_PATIENCE_MS", "300")
        .output();
    match output {
        Ok(output) => Some(output),
        Err(e) => {
            println!("SKIPPED: setpriv cannot be run ({e})");
            None
        }
    }
}

#[test]
fn another_user_is_turned_away_by_the_directory_and_by_the_plant() {
    let dir = run_dir();
    let notes = Arc::new(Mutex::new(String::new()));
    let heard = notes.clone();
    let mut settings = settings(dir.path(), "foreign");
    settings.notice = Arc::new(move |text| heard.lock().expect("notes").push_str(text));
    let offer = PlantOffer::open(settings.clone()).expect("shared memory");
    let Some(output) = as_nobody("controller", dir.path(), "foreign") else {
        return;
    };
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(3), "{said}");
    assert!(said.contains("must be a directory of user 65534"), "{said}");

    // Even through an open directory the plant does not let them in: the kernel says who they are.
    for path in [dir.path().to_owned(), dir.path().join("foreign")] {
        std::fs::set_permissions(path, std::fs::Permissions::from_mode(0o711)).expect("ours");
    }
    let socket = settings.run_dir.socket(&settings.ride);
    std::fs::set_permissions(&socket, std::fs::Permissions::from_mode(0o777)).expect("ours");
    let place = dir.path().to_owned();
    let knocked = std::thread::spawn(move || {
        let answer = as_nobody("knock", &place, "foreign").expect("it worked before");
        for path in [place.join("foreign"), place.clone()] {
            std::fs::set_permissions(path, std::fs::Permissions::from_mode(0o700)).expect("ours");
        }
        (answer, start("controller", &place, "foreign", &[]))
    });
    let mut plant = offer.accept().expect("our own controller joins");
    ride(&mut plant, 0, 10, true);
    drop(plant);
    let (answer, other) = knocked.join().expect("knocking");
    assert_eq!(other.end().0, Some(0));
    assert_eq!(answer.status.code(), Some(0), "no hello for strangers");
    let notes = notes.lock().expect("notes");
    assert!(notes.contains("of user 65534 was turned away"), "{notes}");
}

#[test]
fn in_real_time_frames_are_paced_and_silence_is_no_end() {
    let dir = run_dir();
    let offer = PlantOffer::open(Settings {
        pacing: Pacing::RealTime,
        ..settings(dir.path(), "paced")
    })
    .expect("shared memory");
    let other = start("controller", dir.path(), "paced", &[]);
    let end = offer.accept().expect("the controller joins");
    let mut plant = Timed::new(end, Pacing::RealTime, false);
    let start_time = Instant::now();
    let mut answered = 0;
    for tick in 0..300 {
        if tick == 100 {
            other.signal(Signal::STOP);
        }
        if tick == 150 {
            other.signal(Signal::CONT);
        }
        let state = if tick == 299 {
            RideState::Finished
        } else {
            RideState::Running
        };
        let answer = plant.exchange(&frame(tick, state)).expect("it lives");
        answered += u64::from(answer.is_some());
    }
    assert!(start_time.elapsed() >= Duration::from_millis(299));
    let timing = plant.timing().expect("it measures");
    assert_eq!(timing.lateness_us.count, 300);
    assert_eq!(timing.missed_answers, 300 - answered);
    assert!(timing.missed_answers >= 20, "{timing:?}");
    assert!(timing.real_time_factor <= 1.01, "{timing:?}");
    drop(plant);
    other.signal(Signal::CONT);
    // The answer to the last frame may be missed, the frame itself is not.
    assert_eq!(other.end().0, Some(0));
}

#[test]
fn in_real_time_a_frame_that_comes_twice_is_answered_once() {
    let dir = run_dir();
    let offer = PlantOffer::open(Settings {
        pacing: Pacing::RealTime,
        ..settings(dir.path(), "twice")
    })
    .expect("shared memory");
    let other = start("controller", dir.path(), "twice", &[]);
    let mut plant = offer.accept().expect("the controller joins");
    let soon = || Some(Instant::now() + SOON);
    for tick in [0, 1, 5] {
        plant.send(&frame(tick, RideState::Running)).expect("room");
        let answer = plant.receive(tick, soon()).expect("it lives");
        assert_eq!(answer.map(|a| a.header.sequence), Some(tick));
        for old in [tick, 0] {
            plant.send(&frame(old, RideState::Running)).expect("room");
            let deadline = Some(Instant::now() + Duration::from_millis(30));
            assert_eq!(plant.receive(old, deadline).expect("it lives"), None);
        }
    }
    plant.send(&frame(6, RideState::Finished)).expect("room");
    assert!(plant.receive(6, soon()).expect("it lives").is_some());
    drop(plant);
    assert_eq!(other.end().0, Some(0));
}

#[test]
fn one_core_is_enough_for_spinning() {
    let dir = run_dir();
    let mut one = rustix::thread::CpuSet::new();
    let all = rustix::thread::sched_getaffinity(None).expect("our cores");
    let first = (0..rustix::thread::CpuSet::MAX_CPU).find(|cpu| all.is_set(*cpu));
    one.set(first.expect("a core"));
    // Threads of this test and the child that they start.
    rustix::thread::sched_setaffinity(None, &one).expect("one of our cores");
    let offer = PlantOffer::open(settings(dir.path(), "one_core")).expect("shared memory");
    let other = start("controller", dir.path(), "one_core", &[]);
    let mut plant = offer.accept().expect("the controller joins");
    ride(&mut plant, 0, 2000, true);
    drop(plant);
    assert_eq!(other.end().0, Some(0));
}

#[test]
fn names_that_could_leave_the_directory_are_refused() {
    for name in ["", "..", "a/b", "a b", "a.b", "ä", &"x".repeat(41)] {
        assert!(RideName::new(name).is_err(), "{name}");
    }
}
