//! A ride whose controller speaks the byte stream: the emulated microcontroller, a command, or
//! whoever joins on a socket. The plant rides in this process.

use crate::exit;
use crate::link_args::LinkArgs;
use crate::ride::{coded, with_port};
use firmware_sim::cortex_m::{Carrier, CortexM, CortexMError, Cost, Options, law_bytes};
use indicatif::ProgressBar;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;
use twinhub_control::Config;
use twinhub_link::stream::{StreamEnd, StreamSettings};
use twinhub_link::timing::Instructions;
use twinhub_link::wires::{Started, StreamListener};
use twinhub_link::{Notice, Timing};
use twinhub_sim::{Outcome, Ride, RideError};

/// How long a command or a visitor may take to say hello.
const HELLO: Duration = Duration::from_secs(10);
/// How long a command may take to end after its last answer.
const LAST_WORDS: Duration = Duration::from_secs(2);

/// The target of `--target cortex-m`.
#[derive(clap::Args)]
pub struct CortexMArgs {
    /// Firmware image for `--target cortex-m`; the one that `firmware_sim/cortex_m/build` made
    /// unless given.
    #[arg(long, value_name = "FILE")]
    image: Option<PathBuf>,
    /// What carries the bytes of `--target cortex-m`: `semihosting` (files, fast) or `uart`.
    #[arg(long, default_value = "semihosting")]
    carrier: Carrier,
}

impl CortexMArgs {
    /// The image, and QEMU for it.
    ///
    /// # Errors
    /// If either is missing.
    pub fn find(&self) -> anyhow::Result<Firmware> {
        let image = firmware_sim::cortex_m::find(self.image.as_deref()).map_err(of_target)?;
        Ok(Firmware {
            image,
            carrier: self.carrier,
        })
    }
}

/// An image that can be started.
pub struct Firmware {
    image: PathBuf,
    carrier: Carrier,
}

impl Firmware {
    /// Starts it in QEMU.
    ///
    /// # Errors
    /// If it does not answer.
    pub fn start(&self, config: &Config, stop: &Arc<AtomicBool>) -> anyhow::Result<CortexM> {
        let options = Options {
            image: &self.image,
            carrier: self.carrier,
            config,
            stop: Arc::clone(stop),
            notice: notice(),
        };
        CortexM::start(options).map_err(of_target)
    }
}

/// A controller that speaks the byte stream.
pub enum Controller {
    /// The image in QEMU.
    CortexM(Firmware),
    /// A command of the user's.
    Command(String),
    /// A socket that the user's program joins.
    Socket(StreamListener),
}

impl Controller {
    /// Listens on `path`, and says so.
    ///
    /// # Errors
    /// If it cannot.
    pub fn listen(path: &Path) -> anyhow::Result<Self> {
        let listener = StreamListener::bind(path).map_err(exit::environment)?;
        eprintln!("waiting for a controller on {}", path.display());
        Ok(Self::Socket(listener))
    }
}

/// Rides `ride`; with it, what the controller cost the target, if it counted.
///
/// # Errors
/// If there is no controller, it dies or breaks the protocol, or the ride fails.
pub fn ride(
    controller: &Controller,
    ride: &Ride,
    log: Option<&Path>,
    link: &LinkArgs,
    stop: &Arc<AtomicBool>,
    bar: &ProgressBar,
) -> anyhow::Result<(Outcome, Timing, Option<Cost>)> {
    let settings = |who: &str| -> anyhow::Result<StreamSettings> {
        Ok(StreamSettings {
            law: law_bytes(&ride.law)?,
            patience: Some(HELLO),
            stop: Arc::clone(stop),
            notice: notice(),
            who: who.to_owned(),
        })
    };
    match controller {
        Controller::CortexM(firmware) => {
            let mut target = firmware.start(&ride.law, stop)?;
            let (outcome, mut timing) = with_port(ride, log, link, stop, bar, &mut target)?;
            let cost = target.finish();
            timing.instructions_per_tick = cost.as_ref().map(|cost| Instructions {
                mean: cost.instructions_per_tick_mean,
                max: cost.instructions_per_tick,
            });
            Ok((outcome, timing, cost))
        }
        Controller::Command(command) => {
            let settings = settings(command)?;
            let (mut started, wires) =
                Started::piped(Command::new("sh").args(["-c", command])).map_err(of_link)?;
            let mut end = StreamEnd::meet(wires, settings).map_err(of_link)?;
            let (outcome, timing) = with_port(ride, log, link, stop, bar, &mut end)?;
            // Hanging up is how the command learns that the ride is over.
            drop(end);
            match started.wait(LAST_WORDS) {
                Some(status) if status.success() => {}
                Some(status) => eprintln!("after the ride `{command}` ended with {status}"),
                None => eprintln!("`{command}` did not end when its input did; it is killed"),
            }
            Ok((outcome, timing, None))
        }
        Controller::Socket(listener) => {
            let wires = listener.accept(None, stop).map_err(of_link)?;
            let settings = settings(&format!("process {}", wires.pid))?;
            let mut end = StreamEnd::meet(wires, settings).map_err(of_link)?;
            let (outcome, timing) = with_port(ride, log, link, stop, bar, &mut end)?;
            Ok((outcome, timing, None))
        }
    }
}

fn notice() -> Notice {
    Arc::new(|text| eprintln!("{text}"))
}

fn of_link(error: twinhub_link::LinkError) -> anyhow::Error {
    coded(RideError::Link(error))
}

fn of_target(error: CortexMError) -> anyhow::Error {
    match error {
        CortexMError::Link(error) => of_link(error),
        other => exit::environment(other),
    }
}
