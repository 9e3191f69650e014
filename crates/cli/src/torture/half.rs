//! One process of a tortured ride: what it tells, and how it ends.

use crate::processes::{Report, reports, spawn};
use std::process::{Child, ChildStdin, ExitStatus, Stdio};
use std::sync::mpsc::Receiver;
use std::time::{Duration, Instant};

/// A process that has not ended by then never will.
pub const HANGS: Duration = Duration::from_secs(20);

/// A process of the ride.
pub struct Half {
    /// The process.
    pub child: Child,
    _input: ChildStdin,
    reports: Receiver<Report>,
}

impl Half {
    /// Starts this program again as `role`.
    ///
    /// # Errors
    /// If it cannot be started.
    pub fn start(role: &str, job: &str) -> anyhow::Result<Self> {
        let (mut child, input) = spawn(role, job, Stdio::null())?;
        let reports = reports(&mut child);
        Ok(Self {
            child,
            _input: input,
            reports,
        })
    }

    /// Waits for the first report that `wanted` takes; `None` if there is none in time.
    pub fn told<T>(
        &self,
        limit: Duration,
        mut wanted: impl FnMut(Report) -> Option<T>,
    ) -> Option<T> {
        let end = Instant::now() + limit;
        loop {
            let left = end.saturating_duration_since(Instant::now());
            if let Some(found) = wanted(self.reports.recv_timeout(left).ok()?) {
                return Some(found);
            }
        }
    }

    /// Waits for the end; a process that hangs is killed and gives `None`.
    pub fn end(&mut self) -> Option<ExitStatus> {
        let end = Instant::now() + HANGS;
        while Instant::now() < end {
            if let Ok(Some(status)) = self.child.try_wait() {
                return Some(status);
            }
            std::thread::sleep(Duration::from_millis(2));
        }
        let _ = self.child.kill();
        let _ = self.child.wait();
        None
    }
}

/// When a loss was noticed that began at `since_ns`.
pub fn lost_after(report: Report, since_ns: u64) -> Option<u64> {
    match report {
        Report::Lost { at_ns, .. } if at_ns >= since_ns => Some(at_ns),
        _ => None,
    }
}
