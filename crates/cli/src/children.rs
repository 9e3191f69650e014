//! The two processes of a ride, as [`processes`](crate::processes) starts them.

use crate::exit;
use crate::processes::{Job, Report};
use crate::ride::{coded, program};
use anyhow::{Context, anyhow};
use firmware_sim::LossEvent;
use std::io::{Read, Write};
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;
use twinhub_link::pacing::monotonic_ns;
use twinhub_link::{
    ControllerPort, ControllerTiming, LinkError, LinkEvent, Pacing, PlantOffer, RideName, Rights,
    RunDir, Timed, Timing, Waiting,
};
use twinhub_sim::{Ending, Progress, Ride, Settings};
use twinhub_types::{ControllerFrame, PlantFrame};

/// Ticks of silence that are told, as they are in the log.
const SILENCE_TICKS: u64 = twinhub_sim::closed_loop::SILENCE_TICKS;

/// A port that tells when the controller falls silent or is gone.
struct Listening<P> {
    port: P,
    heard: Instant,
    silent: u64,
}

impl<P> Listening<P> {
    fn new(port: P) -> Self {
        Self {
            port,
            heard: Instant::now(),
            silent: 0,
        }
    }

    #[cold]
    fn lost(&self) {
        tell(&Report::Lost {
            at_ns: monotonic_ns(),
            silence_ms: self.heard.elapsed().as_secs_f64() * 1e3,
        });
    }
}

impl<P: ControllerPort> ControllerPort for Listening<P> {
    #[inline]
    fn exchange_during(
        &mut self,
        frame: &PlantFrame,
        meanwhile: &mut dyn FnMut(),
    ) -> Result<Option<ControllerFrame>, LinkError> {
        let answer = self.port.exchange_during(frame, meanwhile);
        match &answer {
            Ok(Some(_)) => self.silent = 0,
            Ok(None) => {
                if self.silent == 0 {
                    self.heard = Instant::now();
                }
                self.silent += 1;
                if self.silent == SILENCE_TICKS {
                    self.lost();
                }
            }
            Err(_) => self.lost(),
        }
        answer
    }

    fn next_event(&mut self) -> Option<LinkEvent> {
        self.port.next_event()
    }

    fn controller_timing(&self) -> Option<ControllerTiming> {
        self.port.controller_timing()
    }

    fn instructions(&self) -> Option<u64> {
        self.port.instructions()
    }

    fn timing(&self) -> Option<Timing> {
        self.port.timing()
    }
}

/// Reads the job; from then on, the end of standard input raises the stop flag.
fn take_job() -> anyhow::Result<(Job, Ride, Arc<AtomicBool>)> {
    let mut line = String::new();
    std::io::stdin().read_line(&mut line)?;
    let job: Job = serde_json::from_str(&line)
        .context("this command is for `twinhub ride`, which tells it what to do on standard input")
        .map_err(exit::bad_input)?;
    let ride: Ride = toml::from_str(&job.ride_toml).map_err(exit::bad_input)?;
    let stop = Arc::new(AtomicBool::new(false));
    let flag = Arc::clone(&stop);
    std::thread::spawn(move || {
        let _ = std::io::stdin().read_to_end(&mut Vec::new());
        flag.store(true, Ordering::Relaxed);
    });
    Ok((job, ride, stop))
}

fn link_settings(job: &Job, stop: &Arc<AtomicBool>) -> anyhow::Result<twinhub_link::Settings> {
    let mut settings =
        twinhub_link::Settings::new(RideName::new(&job.link).map_err(exit::environment)?);
    let wrong = |text: String| exit::bad_input(anyhow!(text));
    settings.pacing = job.pacing.parse().map_err(wrong)?;
    settings.waiting = job.waiting.parse().map_err(wrong)?;
    settings.stop = Arc::clone(stop);
    if let Some(dir) = &job.run_dir {
        settings.run_dir = RunDir::at(dir);
    }
    settings.identity.tool = concat!("twinhub ", env!("CARGO_PKG_VERSION")).to_owned();
    Ok(settings)
}

fn tell(report: &Report) {
    // A parent that no longer listens has closed our standard input too.
    if let Ok(text) = serde_json::to_string(report) {
        let _ = writeln!(std::io::stdout().lock(), "{text}");
    }
}

/// The plant's process.
///
/// # Errors
/// As [`twinhub_sim::ride`].
pub fn plant() -> anyhow::Result<ExitCode> {
    let (job, ride, stop) = take_job()?;
    let settings = link_settings(&job, &stop)?;
    let real_time = settings.pacing == Pacing::RealTime;
    let (pacing, spin) = (settings.pacing, settings.waiting == Waiting::Spin);
    let end = PlantOffer::open(settings)
        .and_then(PlantOffer::accept)
        .map_err(exit::environment)?;
    let rights = real_time.then(Rights::acquire);
    let mut port = Listening::new(Timed::new(end, pacing, spin).with_rights(rights));
    let (version, git_hash) = program();
    let settings = Settings {
        log: job.log.clone(),
        version,
        git_hash,
    };
    let mut watch = |p: Progress| {
        if p.tick.is_multiple_of(job.report_every) {
            tell(&Report::Tick(p.tick));
        }
        !stop.load(Ordering::Relaxed)
    };
    let outcome = twinhub_sim::ride(&ride, &settings, &mut port, &mut watch).map_err(coded)?;
    let stopped = outcome.ending == Ending::Stopped;
    tell(&Report::Done {
        stopped,
        metrics: outcome.metrics,
        digest: outcome.digest,
        timing: Box::new(port.timing().unwrap_or_default()),
    });
    Ok(ExitCode::SUCCESS)
}

/// The controller's process.
///
/// # Errors
/// As [`firmware_sim::run`].
pub fn controller() -> anyhow::Result<ExitCode> {
    let (job, ride, stop) = take_job()?;
    let settings = link_settings(&job, &stop)?;
    let options = firmware_sim::Options {
        settings,
        config: ride.law,
        on_loss: Box::new(|event| {
            tell(&match event {
                LossEvent::Lost(loss) => Report::Lost {
                    at_ns: loss.at_ns,
                    silence_ms: loss.silence.as_secs_f64() * 1e3,
                },
                LossEvent::Quiet { at_ns, ticks } => Report::Quiet {
                    at_ns: *at_ns,
                    ticks: *ticks,
                },
            });
        }),
    };
    firmware_sim::run(options).map_err(|e| match e {
        LinkError::Interrupted => exit::interrupted(e),
        other => exit::environment(other),
    })?;
    Ok(ExitCode::SUCCESS)
}
