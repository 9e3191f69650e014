//! The protocol of the link: all that another program needs to be plant or controller.
//!
//! # Meeting
//! The plant owns the ride. It locks the ride's name, creates its shared memory, and listens on
//! the Unix stream socket `<run dir>/<ride>/hello` (see [`ride`](crate::ride) for directories,
//! locks and names). The controller connects as soon as the socket is there.
//!
//! 1. The controller sends its hello, 128 bytes.
//! 2. The plant asks the kernel who is at the other end and turns away other users. It compares
//!    the hello with its own and answers with its own: `refused` 0, the session number, and with
//!    it, as `SCM_RIGHTS`, the shared page; or `refused` 1 and no page, after which
//!    both end with a message that names both sides.
//! 3. The controller opens the services of the session and sends the byte `r`. The plant removes
//!    the socket's name: a ride has one controller.
//!
//! From then on the socket carries rings only, and its end tells that a side has left.
//!
//! # The hello
//! Little endian; its layout never changes, so that programs of any two versions can tell each
//! other why they do not fit.
//!
//! | bytes | content |
//! |---|---|
//! | 0-7 | `TWINHUB` and a zero |
//! | 8-11 | version of the hello, 1 |
//! | 12-15 | role: 1 plant, 2 controller |
//! | 16-19 | protocol version ([`PROTOCOL_VERSION`](twinhub_types::messages::PROTOCOL_VERSION)) |
//! | 20-23 | refused: 0 or 1; 0 from the controller |
//! | 24-31 | layout hash ([`PROTOCOL_HASH`]) |
//! | 32-35, 36-39 | bytes of a plant frame, of a controller frame |
//! | 40-43 | transport: 0 shared memory |
//! | 44-47 | release of iceoryx2: major, minor, patch in one byte each, 0x000a00 |
//! | 48-55 | session; 0 from the controller |
//! | 56-59 | pacing: 0 lockstep, 1 real time; the plant's counts |
//! | 60-63 | zero |
//! | 64-111 | name and version of the program, UTF-8, filled with zeros |
//! | 112-127 | zero |
//!
//! Version of the hello, protocol version, hash, both sizes, transport and release have to be
//! equal, the roles different.
//!
//! # Services
//! iceoryx2 blackboards with the root path `<run dir>/<ride>/<session>` and the prefix
//! `twinhub.<uid>.<session>.` (the session as 16 hexadecimal digits). Each has one entry, under the
//! key 0 (`u64`), whose value is the newest frame:
//!
//! | service | value | type name |
//! |---|---|---|
//! | `twinhub/plant` | [`PlantFrame`] | `twinhub::PlantFrame` |
//! | `twinhub/controller` | [`ControllerFrame`] | `twinhub::ControllerFrame` |
//!
//! One reader, two nodes. The value is the message's bytes in the order of its declaration, little
//! endian, without padding, aligned to 8: integers and floats only, so no bytes are invalid. A
//! receiver copies them once and checks the copy. What lies there before the first frame has the
//! generation that the reader finds when it opens the entry, and is not looked at.
//!
//! # The shared page
//! 4096 bytes of memory without a name, sealed against shrinking.
//!
//! | bytes | content |
//! |---|---|
//! | 0-3 | the plant's flag "I sleep" |
//! | 64-71 | when the plant sent its last frame, ns of `CLOCK_MONOTONIC`; in lockstep, its last one with a `sequence` that 16 divides |
//! | 128-131 | the controller's flag "I sleep" |
//! | 256-399 | the controller's account of itself, 18 numbers of 64 bits: frames answered, frames lost, ticks without a frame, overruns, health bits, then p50, p99, p99.9 and the longest of wake-up, compute and wait, ns, and the number of measured wake-ups |
//!
//! The flags are the bell: before it sleeps, a side raises its flag, looks for a frame once more,
//! and then waits for a byte on the socket; after publishing, a side looks at the other's flag and,
//! if it is up, sends the byte `!`. Both need sequentially consistent order. Nobody sleeps longer
//! than 20 ms at a time. Time and account serve reports only; zeros are as good.
//!
//! # Tick order
//! 1. The plant sends frame `k` with the measurement taken at ride time `k` ms.
//! 2. The controller answers frame `k` with output `k`: the same header.
//! 3. The plant applies output `k` from `k` to `k + 1` ms, then sends frame `k + 1`.
//!
//! The plant counts its frames from 0 in `sequence`, without gaps, and `tick` is equal to it. In
//! lockstep each side has every frame of the other. In real time a newer frame replaces one that
//! nobody has taken yet: the controller sees a gap, and the plant takes the newest answer that comes
//! in time, whichever of the last 20 frames it answers. [`pacing`](crate::pacing) has the rules.
//! The last frame of the plant says why it is the last (`state` other than running); it is
//! answered like any other. Then the plant closes its side of the socket, the controller closes
//! its services and its socket, and the plant removes what is left.
//!
//! # Loss
//! | what happens | what the other side does |
//! |---|---|
//! | stopped, in a debugger, slow; lockstep | waits without limit, says so every 5 s |
//! | the same, real time: controller | the plant rides on; silence is logged after 10 ms, the drives' watchdogs act after 20 ms |
//! | the same, real time: plant | the controller goes on by its own clock after 18 ms, its supervisor calls the link lost after 20 ms, no torque 150 ms later; then it waits without limit |
//! | dead | the kernel says so (pidfd) to a sleeper at once, to a spinner within 100 µs: `PeerDied` |
//! | leaves before the last frame | `PeerLeft` |
//! | sends a frame with another hash, sequence or tick | `BadFrame`; in real time only the hash has to fit, and numbers that cannot be are passed over |
//! | asks for a torque that is no number or beyond [`TORQUE_MAX_NM`] | the plant counts it as silence |
//! | stop flag raised (Ctrl-C) | any wait ends within 20 ms: `Interrupted` |
//!
//! A controller that loses its plant ticks on without frames until its watchdog has brought the
//! torques to zero, then exits with 3. A plant that loses its controller closes its log and
//! exits with 3. Who survives removes the shared memory; if both die, the next start of any ride
//! of this user does.

use crate::LinkError;
use twinhub_types::messages::PROTOCOL_HASH;
use twinhub_types::{ControllerFrame, Header, PlantFrame};

/// Largest torque that a plant believes, Nm: no hub motor gives as much.
pub const TORQUE_MAX_NM: f32 = 500.0;

/// True if both torques of an answer are numbers that a drive can follow. An answer of which this
/// is false counts as none.
pub fn is_plausible(answer: &ControllerFrame) -> bool {
    let command = &answer.output.command;
    [command.front_brake_nm, command.rear_traction_nm]
        .iter()
        .all(|nm| nm.abs() <= TORQUE_MAX_NM)
}

/// Checks the controller's answer to the plant's frame of tick `tick`.
pub fn check_answer(answer: &ControllerFrame, tick: u64, sequence: u64) -> Result<(), LinkError> {
    check("controller", &answer.header, tick, sequence)
}

/// Checks a frame of the plant.
pub fn check_frame(frame: &PlantFrame, tick: u64, sequence: u64) -> Result<(), LinkError> {
    check("plant", &frame.header, tick, sequence)
}

/// Checks that a frame comes from a program of our kind.
#[inline]
pub(crate) fn check_hash(
    sender: &'static str,
    header: &Header,
    tick: u64,
) -> Result<(), LinkError> {
    if header.protocol_hash == PROTOCOL_HASH {
        return Ok(());
    }
    Err(LinkError::BadFrame {
        sender,
        tick,
        field: "protocol_hash",
        found: header.protocol_hash,
        expected: PROTOCOL_HASH,
    })
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
    check_hash(sender, header, tick)?;
    if header.sequence != sequence {
        return bad("sequence", header.sequence, sequence);
    }
    if header.tick != tick {
        return bad("tick", header.tick, tick);
    }
    Ok(())
}
