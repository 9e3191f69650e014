//! Faults of the link, by schedule and seed; [`Faulty`](crate::Faulty) lays them over any port.
//!
//! What: between `start_s` and `end_s` one channel does what `kind` says; later faults of a list
//! see the output of earlier ones. A fault changes what a frame carries (samples and their stamps,
//! wishes; answers with their count) and never the controller's clock: a frame that is lost is the
//! last one once more, with samples that have grown older, which is what a receiver is left with.
//! So both sides tick on, and a ride with faults has one digest on every target, in lockstep.
//! Equation: see [`LinkFaultKind`]. Source: our own list; words as for the faults of sensors.
//! Assumes and ignores: frames of the link carry no checksum, so corruption reaches the receiver;
//! a channel with one loses such frames, which is `dropout`. Valid for: any port.
//! Checked by: the tests below, and `tests/link_faults.rs` of the closed loop.

use serde::{Deserialize, Serialize};

/// The way that a fault hits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Channel {
    /// Samples and wishes on their way to the controller.
    ToController,
    /// Answers on their way to the plant.
    ToPlant,
}

impl Channel {
    /// The name, as courses have it.
    pub fn name(self) -> &'static str {
        match self {
            Self::ToController => "to_controller",
            Self::ToPlant => "to_plant",
        }
    }
}

/// What goes wrong.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum LinkFaultKind {
    /// Frames arrive late, each by `delay_s` and a share of `jitter_s`, evenly drawn. Whole ticks;
    /// frames may overtake each other.
    Late {
        /// Least delay, s; 0 to 1.
        delay_s: f64,
        /// Largest further delay, s; 0 to 1.
        #[serde(default)]
        jitter_s: f64,
    },
    /// Frames are lost.
    Dropout {
        /// Share of frames that are lost.
        share_ratio: f64,
    },
    /// An old frame is delivered again in place of the new one: one of the last ten.
    Repeat {
        /// Share of frames that are replaced.
        share_ratio: f64,
    },
    /// Bits of a frame flip, one to 64 of them, anywhere in what it carries.
    Corrupt {
        /// Share of frames that are hit.
        share_ratio: f64,
    },
    /// The sender hangs: the same frame over and over.
    Stuck {},
    /// The sender is gone; an end has no meaning.
    Death {},
}

/// One fault.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LinkFault {
    /// Which way it hits.
    pub channel: Channel,
    /// When it begins, s.
    pub start_s: f64,
    /// When it ends, s; without it, never.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub end_s: Option<f64>,
    /// What goes wrong.
    pub kind: LinkFaultKind,
}

/// A number of a fault that cannot be.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("`{key}` is {found}, accepted is {accepted}")]
pub struct LinkFaultError {
    /// The key.
    pub key: &'static str,
    /// What was found.
    pub found: f64,
    /// What would be accepted.
    pub accepted: &'static str,
}

impl LinkFault {
    /// Checks every number.
    ///
    /// # Errors
    /// The first one that is out of range.
    pub fn check(&self) -> Result<(), LinkFaultError> {
        let within = |key, found: f64, least: f64, most: f64, accepted| {
            if found >= least && found <= most {
                Ok(())
            } else {
                Err(LinkFaultError {
                    key,
                    found,
                    accepted,
                })
            }
        };
        within("start_s", self.start_s, 0.0, 1e6, "0 to 1e6 s")?;
        if let Some(end_s) = self.end_s {
            within("end_s", end_s, self.start_s, 1e6, "start_s to 1e6 s")?;
        }
        match self.kind {
            LinkFaultKind::Late { delay_s, jitter_s } => {
                within("delay_s", delay_s, 0.0, 1.0, "0 to 1 s")?;
                within("jitter_s", jitter_s, 0.0, 1.0, "0 to 1 s")?;
                let both = delay_s + jitter_s;
                within("delay_s + jitter_s", both, 0.0, 1.0, "0 to 1 s")
            }
            LinkFaultKind::Dropout { share_ratio }
            | LinkFaultKind::Repeat { share_ratio }
            | LinkFaultKind::Corrupt { share_ratio } => {
                within("share_ratio", share_ratio, 0.0, 1.0, "0 to 1")
            }
            LinkFaultKind::Stuck {} | LinkFaultKind::Death {} => Ok(()),
        }
    }
}

impl LinkFaultKind {
    /// The name, as courses have it.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Late { .. } => "late",
            Self::Dropout { .. } => "dropout",
            Self::Repeat { .. } => "repeat",
            Self::Corrupt { .. } => "corrupt",
            Self::Stuck {} => "stuck",
            Self::Death {} => "death",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_out_of_range_are_refused_by_key() {
        let fault = |kind| LinkFault {
            channel: Channel::ToPlant,
            start_s: 1.0,
            end_s: Some(2.0),
            kind,
        };
        let good = fault(LinkFaultKind::Dropout { share_ratio: 0.5 });
        assert_eq!(good.check(), Ok(()));
        let key = |fault: LinkFault| fault.check().expect_err("out of range").key;
        assert_eq!(
            key(fault(LinkFaultKind::Repeat {
                share_ratio: f64::NAN
            })),
            "share_ratio"
        );
        let late = |delay_s, jitter_s| fault(LinkFaultKind::Late { delay_s, jitter_s });
        assert_eq!(key(late(-0.1, 0.0)), "delay_s");
        assert_eq!(key(late(0.6, 0.6)), "delay_s + jitter_s");
        let early = LinkFault {
            end_s: Some(0.5),
            ..good
        };
        assert_eq!(key(early), "end_s");
        let never = LinkFault {
            start_s: f64::INFINITY,
            ..good
        };
        assert_eq!(key(never), "start_s");
    }
}
