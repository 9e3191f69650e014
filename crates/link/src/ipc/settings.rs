//! How to join a ride.

use crate::LinkError;
use crate::hello::{Identity, Role};
use crate::pacing::Pacing;
use crate::ride::{RideName, RunDir};
use crate::wait::{Notice, Waiter, Waiting};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// How to join a ride.
#[derive(Clone)]
pub struct Settings {
    /// Name of the ride.
    pub ride: RideName,
    /// What says when a tick begins; the plant's counts, and its hello tells the controller.
    pub pacing: Pacing,
    /// How this side waits for the other.
    pub waiting: Waiting,
    /// How long to wait for the other side to turn up; `None` waits without limit.
    pub patience: Option<Duration>,
    /// Raised from outside (Ctrl-C), ends every wait with [`LinkError::Interrupted`].
    pub stop: Arc<AtomicBool>,
    /// Where messages to the user go; standard error unless changed.
    pub notice: Notice,
    /// The directory of the rides.
    pub run_dir: RunDir,
    /// What this side says about itself.
    pub identity: Identity,
}

impl Settings {
    /// Joins `ride`: in lockstep, spinning, waiting 10 s for the other side, messages to standard error.
    pub fn new(ride: RideName) -> Self {
        Self {
            ride,
            pacing: Pacing::Lockstep,
            waiting: Waiting::Spin,
            patience: Some(Duration::from_secs(10)),
            stop: Arc::new(AtomicBool::new(false)),
            notice: Arc::new(|text| eprintln!("{text}")),
            run_dir: RunDir::from_env(),
            identity: Identity::default(),
        }
    }

    pub(super) fn socket(&self) -> PathBuf {
        self.run_dir.socket(&self.ride)
    }

    pub(super) fn waiter(&self, other: Role) -> Waiter {
        Waiter::new(self.waiting, self.stop.clone(), self.notice.clone(), other)
    }
}

/// Time until the other side has to be there.
pub(super) struct Patience<'a> {
    settings: &'a Settings,
    wanted: Role,
    start: Instant,
    report: Instant,
}

impl<'a> Patience<'a> {
    const REPORT: Duration = Duration::from_secs(5);

    pub(super) fn new(settings: &'a Settings, wanted: Role) -> Self {
        let start = Instant::now();
        Self {
            settings,
            wanted,
            start,
            report: start + Self::REPORT,
        }
    }

    /// Fails when the time is up or the stop flag is raised.
    pub(super) fn check(&mut self) -> Result<(), LinkError> {
        let settings = self.settings;
        if settings.stop.load(Ordering::Relaxed) {
            return Err(LinkError::Interrupted);
        }
        let waited = self.start.elapsed();
        if settings.patience.is_some_and(|limit| waited >= limit) {
            return Err(LinkError::NobodyThere {
                ride: settings.ride.to_string(),
                wanted: self.wanted.name(),
                waited_s: waited.as_secs_f64(),
                path: settings.socket(),
            });
        }
        if Instant::now() >= self.report {
            let (ride, wanted) = (&settings.ride, self.wanted.name());
            (settings.notice)(&format!("ride `{ride}`: waiting for the {wanted}"));
            self.report = Instant::now() + Self::REPORT;
        }
        Ok(())
    }
}
