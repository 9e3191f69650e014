//! What the controller process reports at the end.

use hdrhistogram::Histogram;
use serde::Serialize;
use std::time::Duration;
use twinhub_link::timing::{Quantiles, histogram_ns, quantiles_ns};
use twinhub_link::{Account, ControllerTiming, Rights};
use twinhub_types::{Health, Mode};

/// How the ride ended, as the controller saw it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Ended {
    /// The course is finished.
    Finished,
    /// The bicycle fell.
    Fell,
    /// The plant was asked to stop.
    Stopped,
}

impl Ended {
    /// Exit code of a process that ends with this: 0 done, 1 fell, 130 stopped by the user.
    pub fn exit_code(self) -> u8 {
        match self {
            Self::Finished => 0,
            Self::Fell => 1,
            Self::Stopped => 130,
        }
    }
}

/// Ticks, times and health of one ride.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Summary {
    /// Version of this record.
    pub schema_version: u32,
    /// How it ended.
    pub ended: Ended,
    /// What the operating system allowed; only a real-time ride asks.
    pub rights: Option<Rights>,
    /// Ticks, times and health.
    #[serde(flatten)]
    pub timing: ControllerTiming,
    /// Mode in the last tick.
    pub mode: &'static str,
}

/// Collects a [`Summary`] tick by tick.
pub(crate) struct Tally {
    pub(crate) ticks: u64,
    pub(crate) silent_ticks: u64,
    pub(crate) wake_up_ns: Histogram<u64>,
    pub(crate) compute_ns: Histogram<u64>,
    pub(crate) wait_ns: Histogram<u64>,
    overruns: u64,
    mode: Mode,
    health: Health,
}

impl Tally {
    pub(crate) fn new() -> Self {
        Self {
            ticks: 0,
            silent_ticks: 0,
            wake_up_ns: histogram_ns(),
            compute_ns: histogram_ns(),
            wait_ns: histogram_ns(),
            overruns: 0,
            mode: Mode::Off,
            health: Health::OK,
        }
    }

    pub(crate) fn computed(&mut self, time: Duration) {
        self.compute_ns.saturating_record(time.as_nanos() as u64);
        self.overruns += u64::from(time > twinhub_link::pacing::PERIOD);
    }

    pub(crate) fn see(&mut self, output: &twinhub_types::Output) {
        self.ticks += 1;
        self.mode = Mode::from_u32(output.mode);
        self.health = self.health.with(Health::from_bits(output.health));
    }

    /// The account so far; `frames_lost` is the link's to know.
    pub(crate) fn account(&self, frames_lost: u64) -> Account {
        Account {
            ticks: self.ticks,
            frames_lost,
            silent_ticks: self.silent_ticks,
            overruns: self.overruns,
            health: self.health.bits().into(),
            wake_up_ns: quantiles_ns(&self.wake_up_ns),
            compute_ns: quantiles_ns(&self.compute_ns),
            wait_ns: quantiles_ns(&self.wait_ns),
            wake_ups: self.wake_up_ns.len(),
        }
    }

    pub(crate) fn summary(
        &self,
        ended: Ended,
        frames_lost: u64,
        rights: Option<Rights>,
    ) -> Summary {
        Summary {
            schema_version: 1,
            ended,
            rights,
            timing: ControllerTiming::from(&self.account(frames_lost)),
            mode: self.mode.name(),
        }
    }
}

impl std::fmt::Display for Summary {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let ended = match self.ended {
            Ended::Finished => "the course is finished",
            Ended::Fell => "the bicycle fell",
            Ended::Stopped => "the plant was stopped",
        };
        let t = &self.timing;
        let health = if t.health.is_empty() {
            "ok".to_owned()
        } else {
            t.health.join(", ")
        };
        writeln!(
            f,
            "{ended} after {} ticks; mode {}, health {health}",
            t.ticks, self.mode
        )?;
        if let Some(rights) = &self.rights {
            writeln!(f, "real time with {rights}")?;
        }
        writeln!(
            f,
            "frames lost {}, ticks without a frame {}, overruns {}",
            t.frames_lost, t.silent_ticks, t.overruns
        )?;
        writeln!(f, "us              p50      p99    p99.9      max")?;
        for (name, times) in [
            ("wake-up", t.wake_up_us),
            ("compute", t.compute_us),
            ("wait", t.wait_us),
        ] {
            let Quantiles {
                p50,
                p99,
                p999,
                max,
                ..
            } = times;
            writeln!(f, "{name:<10} {p50:8.2} {p99:8.2} {p999:8.2} {max:8.1}")?;
        }
        Ok(())
    }
}
