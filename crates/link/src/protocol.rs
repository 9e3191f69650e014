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
//!    it, as `SCM_RIGHTS`, the shared page of the bell; or `refused` 1 and no page, after which
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
//! | 56-63 | zero |
//! | 64-111 | name and version of the program, UTF-8, filled with zeros |
//! | 112-127 | zero |
//!
//! Version of the hello, protocol version, hash, both sizes, transport and release have to be
//! equal, the roles different.
//!
//! # Services
//! iceoryx2 publish-subscribe with the root path `<run dir>/<ride>/<session>` and the prefix
//! `twinhub.<uid>.<session>.` (the session as 16 hexadecimal digits):
//!
//! | service | payload | type name |
//! |---|---|---|
//! | `twinhub/plant` | [`PlantFrame`] | `twinhub::PlantFrame` |
//! | `twinhub/controller` | [`ControllerFrame`] | `twinhub::ControllerFrame` |
//!
//! Safe overflow off, history 0, buffer 2, one borrowed sample, one publisher, one subscriber,
//! two nodes. The payload is the message's bytes in the order of its declaration, little endian,
//! without padding, aligned to 8: integers and floats only, so no bytes are invalid. A receiver
//! copies them once and checks the copy.
//!
//! # The bell
//! A page of memory without a name, sealed against shrinking: at byte 0 the plant's, at byte 128
//! the controller's 32-bit flag "I sleep". Before it sleeps, a side raises its flag, looks for a
//! frame once more, and then waits for a byte on the socket; after publishing, a side looks at
//! the other's flag and, if it is up, sends the byte `!`. Both need sequentially consistent order.
//! Nobody sleeps longer than 20 ms at a time.
//!
//! # Tick order
//! 1. The plant sends frame `k` with the measurement taken at ride time `k` ms.
//! 2. The controller answers frame `k` with output `k`: the same header.
//! 3. The plant applies output `k` from `k` to `k + 1` ms, then sends frame `k + 1`.
//!
//! Both count their frames from 0 in `sequence`, without gaps; in lockstep `tick` is equal to it.
//! The last frame of the plant says why it is the last (`state` other than running); it is
//! answered like any other. Then the plant closes its side of the socket, the controller closes
//! its services and its socket, and the plant removes what is left.
//!
//! # Loss
//! | what happens | what the other side does |
//! |---|---|
//! | stopped, in a debugger, slow | waits without limit, says so every 5 s |
//! | dead | the kernel says so (pidfd) to a sleeper at once, to a spinner within 100 µs: `PeerDied` |
//! | leaves before the last frame | `PeerLeft` |
//! | sends a frame with another hash, sequence or tick | `BadFrame` |
//! | stop flag raised (Ctrl-C) | any wait ends within 20 ms: `Interrupted` |
//!
//! A controller that loses its plant ticks on without frames until its watchdog has brought the
//! torques to zero, then exits with 3. A plant that loses its controller closes its log and
//! exits with 3. Who survives removes the shared memory; if both die, the next start of any ride
//! of this user does.

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
