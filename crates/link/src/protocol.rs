//! The protocol of the link.
//!
//! # Tick order
//! 1. The plant sends frame `k` with the measurement taken at ride time `k` ms.
//! 2. The controller answers frame `k` with output `k`: same `tick`, same `time_ns`.
//! 3. The plant applies output `k` from `k` to `k + 1` ms, then sends frame `k + 1`.
//!
//! Both count their frames from 0 in `sequence`, without gaps. The last frame of the plant says
//! why it is the last (`state` other than running); it is answered like any other.

use crate::LinkError;
use twinhub_types::messages::PROTOCOL_HASH;
use twinhub_types::{ControllerFrame, Header, PlantFrame};

/// Checks the controller's answer to the plant's frame of tick `tick`.
pub fn check_answer(answer: &ControllerFrame, tick: u64, sequence: u64) -> Result<(), LinkError> {
    check("controller", &answer.header, tick, sequence)
}

/// Checks a frame of the plant.
pub fn check_frame(frame: &PlantFrame, tick: u64, sequence: u64) -> Result<(), LinkError> {
    check("plant", &frame.header, tick, sequence)
}

#[inline]
fn check(sender: &'static str, header: &Header, tick: u64, sequence: u64) -> Result<(), LinkError> {
    let bad = |field, found, expected| {
        Err(LinkError::BadFrame {
            sender,
            tick,
            field,
            found,
            expected,
        })
    };
    if header.protocol_hash != PROTOCOL_HASH {
        return bad("protocol_hash", header.protocol_hash, PROTOCOL_HASH);
    }
    if header.sequence != sequence {
        return bad("sequence", header.sequence, sequence);
    }
    if header.tick != tick {
        return bad("tick", header.tick, tick);
    }
    Ok(())
}
