//! What the controller process reports at the end.

use hdrhistogram::Histogram;
use serde::Serialize;
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

/// Quantiles of a time, µs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Quantiles {
    /// Median.
    pub p50: f64,
    /// 99 of 100 are shorter.
    pub p99: f64,
    /// 999 of 1000 are shorter.
    pub p999: f64,
    /// The longest.
    pub max: f64,
}

impl Quantiles {
    pub(crate) fn of_nanos(times: &Histogram<u64>) -> Self {
        let us = |q: f64| times.value_at_quantile(q) as f64 * 1e-3;
        Self {
            p50: us(0.5),
            p99: us(0.99),
            p999: us(0.999),
            max: times.max() as f64 * 1e-3,
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
    /// Frames answered.
    pub ticks: u64,
    /// From a frame's arrival to its answer, µs.
    pub compute_us: Quantiles,
    /// Waiting for a frame, µs; the time of the plant and both ways.
    pub wait_us: Quantiles,
    /// Mode in the last tick.
    pub mode: &'static str,
    /// Codes of all health flags that were raised during the ride.
    pub health: Vec<&'static str>,
}

/// Collects a [`Summary`] tick by tick.
pub(crate) struct Tally {
    pub(crate) ticks: u64,
    pub(crate) compute_ns: Histogram<u64>,
    pub(crate) wait_ns: Histogram<u64>,
    mode: Mode,
    health: Health,
}

impl Tally {
    pub(crate) fn new() -> Self {
        // Up to one hour at three digits; longer waits count as one hour.
        let hour_ns = 3_600_000_000_000;
        let times =
            || Histogram::new_with_bounds(1, hour_ns, 3).expect("bounds and digits are in range");
        Self {
            ticks: 0,
            compute_ns: times(),
            wait_ns: times(),
            mode: Mode::Off,
            health: Health::OK,
        }
    }

    pub(crate) fn see(&mut self, output: &twinhub_types::Output) {
        self.ticks += 1;
        self.mode = Mode::from_u32(output.mode);
        self.health = self.health.with(Health::from_bits(output.health));
    }

    pub(crate) fn summary(&self, ended: Ended) -> Summary {
        let raised = |entry: &&twinhub_types::HealthEntry| self.health.any(entry.flag);
        Summary {
            schema_version: 1,
            ended,
            ticks: self.ticks,
            compute_us: Quantiles::of_nanos(&self.compute_ns),
            wait_us: Quantiles::of_nanos(&self.wait_ns),
            mode: self.mode.name(),
            health: Health::TABLE
                .iter()
                .filter(raised)
                .map(|entry| entry.code)
                .collect(),
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
        let health = if self.health.is_empty() {
            "ok".to_owned()
        } else {
            self.health.join(", ")
        };
        writeln!(
            f,
            "{ended} after {} ticks; mode {}, health {health}",
            self.ticks, self.mode
        )?;
        writeln!(f, "us              p50      p99    p99.9      max")?;
        for (name, times) in [("compute", self.compute_us), ("wait", self.wait_us)] {
            let Quantiles {
                p50,
                p99,
                p999,
                max,
            } = times;
            writeln!(f, "{name:<10} {p50:8.2} {p99:8.2} {p999:8.2} {max:8.1}")?;
        }
        Ok(())
    }
}
