//! How plant and controller are joined: arguments of `twinhub ride`.

use clap::{Args, ValueEnum};
use twinhub_link::fault::LinkFault;
use twinhub_link::{Pacing, Waiting};

/// What answers the plant.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Target {
    /// The controller in a process of its own, over shared memory.
    Process,
    /// The controller in the plant's process and thread.
    InProcess,
    /// The controller's image for a Cortex-M4F, in an emulator.
    CortexM,
}

/// What says when a tick begins.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum PacingName {
    Lockstep,
    Realtime,
}

/// How one side waits for the other.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum WaitingName {
    Spin,
    Block,
}

/// The link of a ride.
#[derive(Args, Clone, Debug)]
pub struct LinkArgs {
    /// What says when a tick begins: the answer to the one before (as fast as the machine allows,
    /// one digest), or the clock, 1000 times a second.
    #[arg(long, value_enum, default_value = "lockstep")]
    pacing: PacingName,
    /// How each side waits for the other: spinning (fastest, takes two cores while it lasts), or
    /// asleep until it is woken.
    #[arg(long, value_enum, default_value = "spin")]
    waiting: WaitingName,
    /// What answers the plant.
    #[arg(long, value_enum, default_value = "process")]
    target: Target,
    /// Break the link, besides what the course says: a kind (`late`, `dropout`, `repeat`, `corrupt`,
    /// `stuck`, `death`), a way (`to_controller`, `to_plant`), and its numbers. May be given
    /// several times. `--fault dropout,to_plant,start_s=5,end_s=8,share_ratio=0.2`
    #[arg(long = "fault", value_name = "FAULT", value_parser = parse_fault)]
    pub faults: Vec<LinkFault>,
    /// The same as `--target in-process`; gives the same digests.
    #[arg(long, conflicts_with = "target")]
    in_process: bool,
}

impl LinkArgs {
    /// What says when a tick begins.
    pub fn pacing(&self) -> Pacing {
        match self.pacing {
            PacingName::Lockstep => Pacing::Lockstep,
            PacingName::Realtime => Pacing::RealTime,
        }
    }

    /// How each side waits.
    pub fn waiting(&self) -> Waiting {
        match self.waiting {
            WaitingName::Spin => Waiting::Spin,
            WaitingName::Block => Waiting::Block,
        }
    }

    /// What answers the plant.
    pub fn target(&self) -> Target {
        if self.in_process {
            Target::InProcess
        } else {
            self.target
        }
    }
}

/// A fault from words: `dropout,to_plant,start_s=5,end_s=8,share_ratio=0.2`.
fn parse_fault(text: &str) -> Result<LinkFault, String> {
    let example = "such as `dropout,to_plant,start_s=5,end_s=8,share_ratio=0.2`";
    let mut words = text.split(',').map(str::trim);
    let (Some(kind), Some(channel)) = (words.next(), words.next()) else {
        return Err(format!(
            "`{text}`: a kind and a channel are wanted, {example}"
        ));
    };
    let mut own = toml::Table::new();
    let mut of_kind = toml::Table::new();
    own.insert("channel".into(), channel.into());
    for word in words {
        let (key, value) = word
            .split_once('=')
            .ok_or_else(|| format!("`{word}`: key=value is wanted, {example}"))?;
        let value: f64 = value
            .parse()
            .map_err(|_| format!("`{word}`: `{value}` is not a number"))?;
        let table = if matches!(key, "start_s" | "end_s") {
            &mut own
        } else {
            &mut of_kind
        };
        table.insert(key.to_owned(), value.into());
    }
    own.entry("start_s").or_insert(0.0.into());
    let kind = toml::Table::from_iter([(kind.to_owned(), of_kind.into())]);
    own.insert("kind".into(), kind.into());
    let fault: LinkFault = own
        .try_into()
        .map_err(|e: toml::de::Error| format!("`{text}`: {}", e.message()))?;
    fault.check().map_err(|e| format!("`{text}`: {e}"))?;
    Ok(fault)
}
