//! What every ride needs, tried out.

use super::Finding;
use crate::pacing::{PERIOD, monotonic_ns};
use crate::ride::{RideName, RunDir, SHM_DIR};
use crate::timing::{histogram_ns, quantiles_ns};
use crate::{ControllerEnd, ControllerPort, LinkError, PlantOffer, Settings, Waiting};
use std::fs::OpenOptions;
use std::os::unix::fs::{MetadataExt, OpenOptionsExt};
use std::time::{Duration, Instant};
use twinhub_types::messages::PROTOCOL_HASH;
use twinhub_types::{ControllerFrame, PlantFrame, RideState};

/// Ticks of the trial ride.
const TICKS: u64 = 1000;
/// A ride takes less than a tenth of this.
const SHM_WANTED_BYTES: u64 = 16 << 20;

pub(super) fn findings(run_dir: &RunDir) -> Vec<Finding> {
    vec![
        Finding::needed(
            "shared memory",
            shared_memory(),
            "/dev/shm can be written and has 16 MB free",
            "mount it: mount -t tmpfs -o mode=1777,size=64m tmpfs /dev/shm; in a container --shm-size=64m",
        ),
        Finding::needed(
            "run directory",
            run_dir
                .ensure()
                .map(|()| format!("{}, private", run_dir.path().display()))
                .map_err(|e| e.to_string()),
            "a directory of this user alone",
            "remove it or close it (chmod 700), or set TWINHUB_RUN_DIR to another place",
        ),
        Finding::needed(
            "watching another process",
            pidfd(),
            "pidfd, Linux 5.3 or newer",
            "a newer kernel; in a container, a seccomp profile that allows pidfd_open",
        ),
        Finding::needed(
            "a ride over shared memory",
            ride(run_dir, Waiting::Block).map_err(|e| e.to_string()),
            "1000 ticks",
            "see what failed above",
        ),
        Finding::advised(
            "the same, spinning",
            ride(run_dir, Waiting::Spin).map_err(|e| e.to_string()),
            "1000 ticks",
            "see what failed above",
        ),
        Finding::advised(
            "sleeping to the millisecond",
            sleeping(),
            "99 of 100 wake-ups within 0.1 ms",
            "an idle core, SCHED_FIFO (see there), a performance governor, bare metal in place of a virtual machine",
        ),
    ]
}

fn shared_memory() -> Result<String, String> {
    let path = format!("{SHM_DIR}/twinhub.doctor.{}", std::process::id());
    OpenOptions::new()
        .write(true)
        .create_new(true)
        .mode(0o600)
        .open(&path)
        .map_err(|e| format!("{SHM_DIR} cannot be written: {e}"))?;
    let _ = std::fs::remove_file(&path);
    let mode = std::fs::metadata(SHM_DIR).map_or(0, |meta| meta.mode() & 0o7777);
    let stat = rustix::fs::statvfs(SHM_DIR).map_err(|e| format!("{SHM_DIR}: {e}"))?;
    let free = stat.f_bavail * stat.f_frsize;
    let found = format!(
        "{SHM_DIR} writable, permissions {mode:04o}, {} MB free of {} MB",
        free >> 20,
        (stat.f_blocks * stat.f_frsize) >> 20
    );
    if free >= SHM_WANTED_BYTES {
        Ok(found)
    } else {
        Err(found)
    }
}

fn pidfd() -> Result<String, String> {
    rustix::process::pidfd_open(
        rustix::process::getpid(),
        rustix::process::PidfdFlags::empty(),
    )
    .map(|_fd| "works".to_owned())
    .map_err(|e| format!("pidfd_open: {e}"))
}

/// A ride of two threads, as between two processes.
fn ride(run_dir: &RunDir, waiting: Waiting) -> Result<String, LinkError> {
    let name = RideName::new(&format!("doctor-{}", std::process::id()))?;
    let settings = || Settings {
        waiting,
        patience: Some(Duration::from_secs(5)),
        run_dir: run_dir.clone(),
        ..Settings::new(name.clone())
    };
    let offer = PlantOffer::open(settings())?;
    std::thread::scope(|scope| {
        let controller = settings();
        scope.spawn(move || -> Result<(), LinkError> {
            let mut end = ControllerEnd::connect(controller)?;
            loop {
                let frame = end.receive()?;
                end.send(&ControllerFrame {
                    header: frame.header,
                    ..ControllerFrame::default()
                })?;
                if RideState::from_u32(frame.header.state) != RideState::Running {
                    return end.finish();
                }
            }
        });
        let mut plant = offer.accept()?;
        let mut frame = PlantFrame::default();
        frame.header.protocol_hash = PROTOCOL_HASH;
        let mut times = histogram_ns();
        for tick in 0..TICKS {
            frame.header.sequence = tick;
            frame.header.tick = tick;
            if tick + 1 == TICKS {
                frame.header.state = RideState::Finished as u32;
            }
            let start = Instant::now();
            plant.exchange(&frame)?;
            times.saturating_record(start.elapsed().as_nanos() as u64);
        }
        let [p50, p99, ..] = quantiles_ns(&times).map(|ns| ns as f64 * 1e-3);
        Ok(format!(
            "{TICKS} ticks, {} waiting: round trip {p50:.1} us p50, {p99:.1} us p99",
            waiting.name()
        ))
    })
}

fn sleeping() -> Result<String, String> {
    let mut clock = crate::pacing::Metronome::new(false);
    let mut times = histogram_ns();
    let start_ns = monotonic_ns();
    for _ in 0..300 {
        times.saturating_record(clock.wait().late_ns);
    }
    let took_ns = monotonic_ns() - start_ns;
    let [p50, p99, _, max] = quantiles_ns(&times).map(|ns| ns as f64 * 1e-3);
    let found = format!(
        "{p50:.0} us late p50, {p99:.0} us p99, {max:.0} us at most in {} ms, as an ordinary thread",
        took_ns / PERIOD.as_nanos() as u64
    );
    if p99 <= 100.0 { Ok(found) } else { Err(found) }
}
