//! How long a ride's exchanges took, and the wrapper that measures and paces them.

use crate::account::ControllerTiming;
use crate::pacing::{Metronome, PERIOD, Pacing};
use crate::rights::Rights;
use crate::{ControllerPort, LinkError, LinkEvent};
use hdrhistogram::Histogram;
use serde::{Deserialize, Serialize};
use std::collections::VecDeque;
use std::time::Instant;
use twinhub_types::{ControllerFrame, PlantFrame};

/// Late ticks that are told one by one; later ones are only counted.
const TOLD_MAX: u64 = 100;

/// Quantiles of a time, µs; all 0 when nothing was measured.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Quantiles {
    /// Number of measurements.
    pub count: u64,
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
    /// Of times in ns: p50, p99, p99.9 and the longest.
    pub fn from_ns(count: u64, ns: [u64; 4]) -> Self {
        let us = |i: usize| ns[i] as f64 * 1e-3;
        Self {
            count,
            p50: us(0),
            p99: us(1),
            p999: us(2),
            max: us(3),
        }
    }

    /// Of a histogram of times in ns.
    pub fn of(times: &Histogram<u64>) -> Self {
        Self::from_ns(times.len(), quantiles_ns(times))
    }
}

/// p50, p99, p99.9 and the longest of a histogram of times in ns.
pub fn quantiles_ns(times: &Histogram<u64>) -> [u64; 4] {
    if times.is_empty() {
        return [0; 4];
    }
    [
        times.value_at_quantile(0.5),
        times.value_at_quantile(0.99),
        times.value_at_quantile(0.999),
        times.max(),
    ]
}

/// An empty histogram of times in ns: 1 ns to one minute, to 1 %; longer counts as a minute. Its
/// memory does not grow.
pub fn histogram_ns() -> Histogram<u64> {
    Histogram::new_with_bounds(1, 60_000_000_000, 2).expect("bounds and digits are in range")
}

/// Instructions of the controller's target per tick.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Instructions {
    /// Mean over all ticks.
    pub mean: f64,
    /// Most in one tick.
    pub max: u64,
}

/// How long the exchanges of a ride took.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Timing {
    /// `lockstep` or `realtime`.
    pub pacing: String,
    /// From handing over a frame to having its answer, µs: what the plant does meanwhile, for the
    /// same tick, is shorter than an exchange between processes, but counts in one process.
    pub round_trip_us: Quantiles,
    /// How late ticks began, µs; nothing is measured in lockstep, where no tick is ever late.
    pub lateness_us: Quantiles,
    /// Time ridden per time passed.
    pub real_time_factor: f64,
    /// Time that passed, s.
    pub elapsed_s: f64,
    /// Instructions per tick, where the target counts them.
    pub instructions_per_tick: Option<Instructions>,
    /// Ticks without an answer that could be applied.
    pub missed_answers: u64,
    /// Ticks that were ridden on the answer to an earlier frame.
    pub late_answers: u64,
    /// Ticks that began a whole tick late or more.
    pub overruns: u64,
    /// Ticks by which the clock was moved.
    pub slipped_ticks: u64,
    /// What the operating system allowed a real-time plant.
    pub rights: Option<Rights>,
    /// What the controller's process says about itself.
    pub controller: Option<ControllerTiming>,
}

/// Any port, paced and measured.
pub struct Timed<P> {
    port: P,
    metronome: Option<Metronome>,
    rights: Option<Rights>,
    round_trip_ns: Histogram<u64>,
    lateness_ns: Histogram<u64>,
    span: Option<(Instant, Instant)>,
    ticks: u64,
    missed: u64,
    late: u64,
    overruns: u64,
    slipped: u64,
    instructions: Option<(u64, u64)>,
    events: VecDeque<LinkEvent>,
}

impl<P: ControllerPort> Timed<P> {
    /// Measures `port`; in real time also waits for the beginning of each tick, until shortly
    /// before it if `spin`.
    pub fn new(port: P, pacing: Pacing, spin: bool) -> Self {
        let real_time = pacing == Pacing::RealTime;
        Self {
            port,
            metronome: real_time.then(|| Metronome::new(spin)),
            rights: None,
            round_trip_ns: histogram_ns(),
            lateness_ns: histogram_ns(),
            span: None,
            ticks: 0,
            missed: 0,
            late: 0,
            overruns: 0,
            slipped: 0,
            instructions: None,
            events: VecDeque::new(),
        }
    }

    /// Puts what the operating system allowed into the report.
    pub fn with_rights(mut self, rights: Option<Rights>) -> Self {
        self.rights = rights;
        self
    }

    fn wait_for_the_tick(&mut self) {
        let Some(metronome) = &mut self.metronome else {
            return;
        };
        let beat = metronome.wait();
        self.lateness_ns.saturating_record(beat.late_ns);
        if beat.late_ns >= PERIOD.as_nanos() as u64 {
            self.overruns += 1;
            self.slipped += beat.slipped;
            let late_ms = beat.late_ns as f64 * 1e-6;
            if beat.slipped > 0 {
                let text = format!(
                    "the tick began {late_ms:.1} ms late; the clock was moved by {} ticks",
                    beat.slipped
                );
                self.events
                    .push_back(LinkEvent::warning("link.slipped", text));
            } else if self.overruns <= TOLD_MAX {
                let text = format!("the tick began {late_ms:.1} ms late");
                self.events
                    .push_back(LinkEvent::warning("link.late_tick", text));
            }
        }
    }
}

impl<P: ControllerPort> ControllerPort for Timed<P> {
    #[inline]
    fn exchange_during(
        &mut self,
        frame: &PlantFrame,
        meanwhile: &mut dyn FnMut(),
    ) -> Result<Option<ControllerFrame>, LinkError> {
        self.wait_for_the_tick();
        let start = Instant::now();
        let answer = self.port.exchange_during(frame, meanwhile)?;
        let end = Instant::now();
        let took = end - start;
        self.span = Some((self.span.map_or(start, |span| span.0), end));
        self.ticks += 1;
        match &answer {
            Some(answer) => {
                self.round_trip_ns.saturating_record(took.as_nanos() as u64);
                self.late += u64::from(answer.header.sequence != frame.header.sequence);
            }
            None => self.missed += 1,
        }
        if let Some(now) = self.port.instructions() {
            let (sum, most) = self.instructions.unwrap_or_default();
            self.instructions = Some((sum + now, most.max(now)));
        }
        Ok(answer)
    }

    fn next_event(&mut self) -> Option<LinkEvent> {
        self.events.pop_front().or_else(|| self.port.next_event())
    }

    fn controller_timing(&self) -> Option<ControllerTiming> {
        self.port.controller_timing()
    }

    fn instructions(&self) -> Option<u64> {
        self.port.instructions()
    }

    fn timing(&self) -> Option<Timing> {
        let elapsed_s = self
            .span
            .map_or(0.0, |(first, last)| (last - first).as_secs_f64());
        let ridden_s = self.ticks as f64 * PERIOD.as_secs_f64();
        let pacing = if self.metronome.is_some() {
            Pacing::RealTime
        } else {
            Pacing::Lockstep
        };
        Some(Timing {
            pacing: pacing.name().to_owned(),
            round_trip_us: Quantiles::of(&self.round_trip_ns),
            lateness_us: Quantiles::of(&self.lateness_ns),
            real_time_factor: if elapsed_s > 0.0 {
                ridden_s / elapsed_s
            } else {
                0.0
            },
            elapsed_s,
            instructions_per_tick: self.instructions.map(|(sum, max)| Instructions {
                mean: sum as f64 / self.ticks.max(1) as f64,
                max,
            }),
            missed_answers: self.missed,
            late_answers: self.late,
            overruns: self.overruns,
            slipped_ticks: self.slipped,
            rights: self.rights.clone(),
            controller: self.port.controller_timing(),
        })
    }
}
