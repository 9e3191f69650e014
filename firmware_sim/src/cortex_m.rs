//! The controller on an emulated Cortex-M4F: starts QEMU with the image of
//! `firmware_sim/cortex_m` and is a port like any other.
//!
//! QEMU's `-icount` gives every instruction the same virtual time, so the target can count its
//! own instructions. They are instructions, not processor cycles: QEMU knows no pipeline, no
//! flash wait states and no cache.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::str::FromStr;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;
use twinhub_control::Config;
use twinhub_link::stream::{StreamEnd, StreamSettings, Wires};
use twinhub_link::wires::{Started, StreamListener, named_pipes};
use twinhub_link::{ControllerPort, LinkError, Notice};
use twinhub_types::stream::{LOOP_INSTRUCTIONS, TargetReport};
use twinhub_types::{ControllerFrame, PlantFrame};

/// The emulator.
const QEMU: &str = "qemu-system-arm";
/// The image below a target directory, where `firmware_sim/cortex_m/build` leaves it.
const IMAGE: &str = "cortex_m/thumbv7em-none-eabihf/release/cortex_m";
/// Virtual time of one instruction, as a power of two of nanoseconds. SysTick counts 40 ns of it
/// in this machine, 6.4 counts for each instruction: none is lost to rounding.
const ICOUNT_SHIFT: &str = "shift=8";
/// How long the image may take to say hello.
const PATIENCE: Duration = Duration::from_secs(20);
/// How long QEMU may take to end after the last frame.
const LAST_WORDS: Duration = Duration::from_secs(2);

/// The clock of a small Cortex-M4F for which shares of the tick are given, Hz.
pub const REFERENCE_HZ: f64 = 168e6;
/// Length of a tick, s.
const TICK_S: f64 = 1e-3;

/// What carries the bytes between plant and target.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Carrier {
    /// Files of the host, through the semihosting of the debugger or emulator.
    #[default]
    Semihosting,
    /// The target's UART, byte by byte.
    Uart,
}

impl FromStr for Carrier {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "semihosting" => Ok(Self::Semihosting),
            "uart" => Ok(Self::Uart),
            _ => Err(format!("`{text}` carries no bytes: semihosting or uart")),
        }
    }
}

/// Why there is no target.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CortexMError {
    /// No emulator.
    #[error("{QEMU} is not in PATH; install it (Debian: apt-get install qemu-system-arm)")]
    NoQemu,
    /// No image.
    #[error(
        "no firmware image (looked at {}); build it with firmware_sim/cortex_m/build, or name one with --image FILE",
        .looked.iter().map(|p| p.display().to_string()).collect::<Vec<_>>().join(", ")
    )]
    NoImage {
        /// Where one could have been.
        looked: Vec<PathBuf>,
    },
    /// The law is longer than a packet.
    #[error("the law cannot be sent to the target: {0}")]
    Law(#[from] postcard::Error),
    /// No place for pipes and sockets.
    #[error("no temporary directory: {0}")]
    NoDirectory(std::io::Error),
    /// The stream.
    #[error(transparent)]
    Link(#[from] LinkError),
}

/// How to start the target.
pub struct Options<'a> {
    /// The image, as [`find`] found it.
    pub image: &'a Path,
    /// What carries the bytes.
    pub carrier: Carrier,
    /// The law that the target gets.
    pub config: &'a Config,
    /// Raised from outside, ends every wait.
    pub stop: Arc<AtomicBool>,
    /// Where messages to the user go.
    pub notice: Notice,
}

/// The target, riding.
pub struct CortexM {
    end: StreamEnd,
    // Before the directory that it runs in.
    qemu: Started,
    _dir: tempfile::TempDir,
}

/// The law as the target reads it.
///
/// # Errors
/// If it cannot be encoded.
pub fn law_bytes(config: &Config) -> Result<Vec<u8>, postcard::Error> {
    postcard::to_stdvec(config)
}

impl CortexM {
    /// Starts QEMU and meets the controller in it.
    ///
    /// # Errors
    /// Without QEMU, image or answer.
    pub fn start(options: Options) -> Result<Self, CortexMError> {
        let image = options.image;
        let dir = tempfile::Builder::new()
            .prefix("twinhub-")
            .tempdir()
            .map_err(CortexMError::NoDirectory)?;
        let settings = StreamSettings {
            law: law_bytes(options.config)?,
            patience: Some(PATIENCE),
            stop: options.stop,
            notice: options.notice,
            who: format!("{QEMU} with {}", image.display()),
        };
        let mut command = Command::new(QEMU);
        command
            .args(["-M", "mps2-an386", "-display", "none", "-monitor", "none"])
            .args(["-icount", ICOUNT_SHIFT, "-kernel"])
            .arg(image)
            .current_dir(dir.path())
            .stdin(Stdio::null())
            .stdout(Stdio::null());
        let semihosting = "enable=on,target=native,arg=twinhub";
        let (qemu, wires) = match options.carrier {
            Carrier::Semihosting => {
                let (input, output) = named_pipes(dir.path())?;
                command
                    .args(["-semihosting-config", semihosting])
                    .args(["-serial", "none"]);
                let qemu = Started::new(&mut command)?;
                let pid = qemu.pid();
                (qemu, Wires { input, output, pid })
            }
            Carrier::Uart => {
                let listener = StreamListener::bind(&dir.path().join("uart"))?;
                command
                    .arg("-semihosting-config")
                    .arg(format!("{semihosting},arg=uart"))
                    .args(["-chardev", "socket,id=uart,path=uart,server=off"])
                    .args(["-serial", "chardev:uart"]);
                let qemu = Started::new(&mut command)?;
                let wires = listener.accept(settings.patience, &settings.stop)?;
                (qemu, wires)
            }
        };
        Ok(Self {
            end: StreamEnd::meet(wires, settings)?,
            qemu,
            _dir: dir,
        })
    }

    /// After the last frame: what the target measured.
    pub fn finish(self) -> Option<Cost> {
        let Self {
            end,
            mut qemu,
            _dir,
        } = self;
        let report = end.finish();
        // It ends by itself; a debugger may hold it.
        let _ = qemu.wait(LAST_WORDS);
        report.and_then(|report| Cost::of(&report))
    }
}

impl ControllerPort for CortexM {
    fn exchange_during(
        &mut self,
        frame: &PlantFrame,
        meanwhile: &mut dyn FnMut(),
    ) -> Result<Option<ControllerFrame>, LinkError> {
        self.end.exchange_during(frame, meanwhile)
    }
}

/// What the controller costs the target.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Cost {
    /// Ticks answered.
    pub ticks: u32,
    /// Most instructions of one tick, from a frame's last byte to the bytes of its answer:
    /// checksums, decoding, step, encoding.
    pub instructions_per_tick: u64,
    /// Mean over the ride.
    pub instructions_per_tick_mean: f64,
    /// Most instructions of one controller step alone.
    pub step_instructions: u64,
    /// The tick that took them.
    pub step_worst_tick: u32,
    /// Mean over the ride.
    pub step_instructions_mean: f64,
    /// The most expensive tick as a share of the instructions that fit into 1 ms at 168 MHz with
    /// one instruction a cycle.
    pub budget_ratio: f64,
    /// Bytes of the stack.
    pub stack_bytes: u32,
    /// Most bytes of it that were in use.
    pub stack_used_bytes: u32,
    /// Bytes and packets that the target passed over because they were broken.
    pub broken_packets: u32,
}

impl Cost {
    /// From counts to instructions; `None` if the target counted nothing.
    fn of(report: &TargetReport) -> Option<Self> {
        if report.loop_counts == 0 || report.ticks == 0 {
            return None;
        }
        let per_count = f64::from(LOOP_INSTRUCTIONS) / f64::from(report.loop_counts);
        let most = |counts: u32| (f64::from(counts) * per_count).ceil() as u64;
        let mean = |sum: u64| sum as f64 * per_count / f64::from(report.ticks);
        let instructions_per_tick = most(report.tick_counts_max);
        Some(Self {
            ticks: report.ticks,
            instructions_per_tick,
            instructions_per_tick_mean: mean(report.tick_counts_sum),
            step_instructions: most(report.step_counts_max),
            step_worst_tick: report.step_max_tick,
            step_instructions_mean: mean(report.step_counts_sum),
            budget_ratio: instructions_per_tick as f64 / (REFERENCE_HZ * TICK_S),
            stack_bytes: report.stack_bytes,
            stack_used_bytes: report.stack_used_bytes,
            broken_packets: report.broken_packets,
        })
    }
}

/// QEMU has to be there; the image that is asked for, or the one that was built: below the target
/// directory of this program, or of the working directory.
///
/// # Errors
/// If either is missing, with the way to get it.
pub fn find(asked: Option<&Path>) -> Result<PathBuf, CortexMError> {
    let image = find_image(asked)?;
    if in_path(QEMU) {
        Ok(image)
    } else {
        Err(CortexMError::NoQemu)
    }
}

fn find_image(asked: Option<&Path>) -> Result<PathBuf, CortexMError> {
    let looked: Vec<PathBuf> = match asked {
        Some(path) => vec![path.to_owned()],
        None => {
            let program = std::env::current_exe().unwrap_or_default();
            let above = program.ancestors().skip(1).take(3);
            let mut places: Vec<PathBuf> = above.map(|dir| dir.join(IMAGE)).collect();
            places.push(Path::new("target").join(IMAGE));
            places
        }
    };
    match looked.iter().find(|path| path.is_file()) {
        // QEMU runs in a directory of its own.
        Some(path) => path.canonicalize().map_err(|_| CortexMError::NoImage {
            looked: vec![path.clone()],
        }),
        None => Err(CortexMError::NoImage { looked }),
    }
}

fn in_path(program: &str) -> bool {
    let path = std::env::var_os("PATH").unwrap_or_default();
    std::env::split_paths(&path).any(|dir| dir.join(program).is_file())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_law_survives_the_way_to_the_target() {
        use twinhub_types::stream::PAYLOAD_MAX;
        let laws = Path::new(env!("CARGO_MANIFEST_DIR")).join("../crates/control/laws");
        for name in twinhub_control::Law::NAMES {
            let config = crate::read_law(&laws.join(format!("{name}.toml"))).expect("a law");
            let mut without = config;
            without.limits.friction_assumed_ratio = None;
            for config in [config, without] {
                let bytes = law_bytes(&config).expect("fits");
                assert!(bytes.len() <= PAYLOAD_MAX, "{name}: {} bytes", bytes.len());
                assert_eq!(postcard::from_bytes::<Config>(&bytes), Ok(config), "{name}");
            }
        }
    }

    #[test]
    fn counts_become_instructions() {
        let report = TargetReport {
            ticks: 10,
            loop_counts: 12_800,
            step_counts_max: 6_400,
            tick_counts_max: 12_801,
            step_counts_sum: 64_000,
            tick_counts_sum: 128_000,
            ..TargetReport::default()
        };
        let cost = Cost::of(&report).expect("it counted");
        assert_eq!(cost.step_instructions, 1000);
        assert_eq!(cost.instructions_per_tick, 2001);
        assert_eq!(cost.step_instructions_mean, 1000.0);
        assert!((cost.budget_ratio - 2001.0 / 168_000.0).abs() < 1e-12);
        assert_eq!(Cost::of(&TargetReport::default()), None);
    }

    #[test]
    fn a_missing_image_is_named_with_the_way_to_get_one() {
        let error = find_image(Some(Path::new("/no/such/image"))).expect_err("not there");
        let text = error.to_string();
        assert!(text.contains("/no/such/image"), "{text}");
        assert!(text.contains("firmware_sim/cortex_m/build"), "{text}");
    }
}
