//! What makes real time better, as the kernel tells it.

use super::Finding;
use crate::rights::{PRIORITY, ask_fifo};
use rustix::process::{Resource, getrlimit};
use rustix::thread::ClockId;
use rustix::time::clock_getres;
use std::path::Path;
use std::time::Instant;

/// More than a ride of hours takes.
const LOCK_WANTED_BYTES: u64 = 256 << 20;

pub(super) fn findings() -> Vec<Finding> {
    vec![
        Finding::advised(
            "cores",
            cores(),
            "2 or more for this process",
            "a bigger machine, or a wider affinity (taskset, container --cpus); on one core spinning falls back to sleeping",
        ),
        Finding::advised(
            "SCHED_FIFO",
            fifo(),
            "allowed, priority 40",
            "/etc/security/limits.d/twinhub.conf: `USER - rtprio 40`, then log in again; in a container --cap-add SYS_NICE --ulimit rtprio=40",
        ),
        Finding::advised(
            "real-time throttle",
            throttle(),
            "-1 (off), or less than all of a core used",
            "sysctl kernel.sched_rt_runtime_us=-1; only a real-time thread that never sleeps notices it",
        ),
        Finding::advised(
            "locked memory",
            memory_lock(),
            "mlockall allowed, 256 MB or more",
            "/etc/security/limits.d/twinhub.conf: `USER - memlock unlimited`, then log in again; in a container --ulimit memlock=-1",
        ),
        Finding::advised(
            "clock",
            clock(),
            "resolution 1 ns, read in less than 0.2 us",
            "clock source tsc (or kvm-clock in a virtual machine): kernel parameter clocksource=tsc",
        ),
        Finding::advised(
            "timer slack",
            slack(),
            "50 us or less; a real-time ride sets its own to 1 ns",
            "prctl(PR_SET_TIMERSLACK), or the systemd unit's TimerSlackNSec=",
        ),
        Finding::advised(
            "frequency governor",
            governor(),
            "performance",
            "cpupower frequency-set -g performance",
        ),
        Finding::advised(
            "transparent huge pages",
            huge_pages(),
            "madvise or never",
            "echo madvise > /sys/kernel/mm/transparent_hugepage/enabled",
        ),
        Finding::advised(
            "kernel",
            kernel(),
            "PREEMPT_RT",
            "a real-time kernel (Debian: linux-image-rt-amd64); without it expect milliseconds at p99.9 under load",
        ),
        Finding::advised(
            "container, virtual machine",
            boxes(),
            "none",
            "bare metal; a virtual machine's core can be taken away for milliseconds",
        ),
    ]
}

fn read(path: &str) -> Option<String> {
    Some(std::fs::read_to_string(path).ok()?.trim().to_owned())
}

/// `Ok` if `good`.
fn judge(good: bool, found: String) -> Result<String, String> {
    if good { Ok(found) } else { Err(found) }
}

fn cores() -> Result<String, String> {
    let ours = std::thread::available_parallelism().map_or(1, usize::from);
    let online = read("/sys/devices/system/cpu/online").unwrap_or_else(|| "unknown".into());
    judge(
        ours >= 2,
        format!("{ours} for this process; online: {online}"),
    )
}

fn fifo() -> Result<String, String> {
    // On a thread of its own, so that this one stays what it is.
    let tried = std::thread::spawn(ask_fifo).join();
    match tried {
        Ok(Ok(())) => Ok(format!("allowed, priority {PRIORITY}")),
        Ok(Err(e)) => {
            let limit = getrlimit(Resource::Rtprio).current;
            Err(format!("{e}; rtprio limit {}", shown(limit)))
        }
        Err(_) => Err("could not be tried".into()),
    }
}

fn shown(limit: Option<u64>) -> String {
    limit.map_or("unlimited".into(), |n| n.to_string())
}

fn throttle() -> Result<String, String> {
    let Some(runtime) = read("/proc/sys/kernel/sched_rt_runtime_us") else {
        return Ok("not shown".into());
    };
    let period = read("/proc/sys/kernel/sched_rt_period_us").unwrap_or_default();
    let number = |text: &str| text.parse::<i64>().unwrap_or(0);
    let share = number(&runtime) as f64 / number(&period).max(1) as f64;
    judge(
        number(&runtime) < 0 || share >= 0.9,
        format!("{runtime} of {period} us"),
    )
}

fn memory_lock() -> Result<String, String> {
    let limit = getrlimit(Resource::Memlock).current;
    let enough = limit.is_none_or(|bytes| bytes >= LOCK_WANTED_BYTES);
    let shown = limit.map_or("unlimited".into(), |bytes| format!("{} kB", bytes >> 10));
    // SAFETY: only changes how this process' pages are kept, and takes it back.
    let locked = unsafe { libc::mlockall(libc::MCL_CURRENT) } == 0;
    if locked {
        // SAFETY: as above.
        unsafe { libc::munlockall() };
    }
    let privileged = !enough && rustix::process::geteuid().is_root() && locked;
    judge(
        locked && (enough || privileged),
        format!(
            "mlockall {}, limit {shown}{}",
            if locked { "works" } else { "refused" },
            if privileged {
                ", which does not bind root"
            } else {
                ""
            }
        ),
    )
}

fn clock() -> Result<String, String> {
    let source = read("/sys/devices/system/clocksource/clocksource0/current_clocksource")
        .unwrap_or_else(|| "not shown".into());
    let resolution_ns = clock_getres(ClockId::Monotonic).tv_nsec;
    // The best of some batches: other work on the core only makes it slower.
    let batch = || {
        let start = Instant::now();
        for _ in 0..1000 {
            std::hint::black_box(Instant::now());
        }
        start.elapsed().as_nanos() as f64 / 1e3
    };
    let read_ns = (0..20).map(|_| batch()).fold(f64::INFINITY, f64::min);
    judge(
        resolution_ns == 1 && read_ns < 200.0,
        format!("source {source}, resolution {resolution_ns} ns, read in {read_ns:.0} ns"),
    )
}

fn slack() -> Result<String, String> {
    // SAFETY: reads one number of this thread.
    let ns = unsafe { libc::prctl(libc::PR_GET_TIMERSLACK) };
    judge((0..=50_000).contains(&ns), format!("{ns} ns"))
}

fn governor() -> Result<String, String> {
    match read("/sys/devices/system/cpu/cpu0/cpufreq/scaling_governor") {
        Some(name) => judge(name == "performance", name),
        None => Ok("not shown: the host decides, or the frequency is fixed".into()),
    }
}

fn huge_pages() -> Result<String, String> {
    let Some(text) = read("/sys/kernel/mm/transparent_hugepage/enabled") else {
        return Ok("not shown".into());
    };
    let chosen = text
        .split_once('[')
        .and_then(|(_, rest)| rest.split_once(']'))
        .map_or(text.as_str(), |(name, _)| name);
    judge(chosen != "always", chosen.to_owned())
}

fn kernel() -> Result<String, String> {
    let version = read("/proc/version").unwrap_or_else(|| "not shown".into());
    let real_time =
        version.contains("PREEMPT_RT") || read("/sys/kernel/realtime").as_deref() == Some("1");
    judge(real_time, version)
}

fn boxes() -> Result<String, String> {
    let container = Path::new("/.dockerenv").exists()
        || Path::new("/run/.containerenv").exists()
        || read("/proc/1/cgroup").is_some_and(|text| {
            ["docker", "kubepods", "containerd", "lxc"]
                .iter()
                .any(|word| text.contains(word))
        });
    let machine = read("/proc/cpuinfo").is_some_and(|text| text.contains("hypervisor"));
    let found = match (container, machine) {
        (false, false) => return Ok("none seen".into()),
        (true, false) => "a container",
        (false, true) => "a virtual machine",
        (true, true) => "a container in a virtual machine",
    };
    Err(found.into())
}
