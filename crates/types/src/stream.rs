//! The byte stream: messages in packets with a length and a checksum, for controllers that no
//! shared memory reaches (a microcontroller, another language). `crates/link/STREAM.md` describes
//! it for those who implement it.
//!
//! A packet is `TWHB`, kind and length of the payload (`u16` each), the payload, and the CRC-32
//! of everything between magic and checksum; all little endian.
//!
//! Source of the checksum: CRC-32 of IEEE 802.3, reflected, as in zlib, PNG and Ethernet.

use crate::message;
use crate::messages::{ControllerFrame, PROTOCOL_HASH, PROTOCOL_VERSION, PlantFrame};
use crate::wire::Wire;

/// What every packet begins with.
pub const MAGIC: [u8; 4] = *b"TWHB";
/// Bytes before the payload: magic, kind, length.
pub const HEAD_BYTES: usize = 8;
/// Bytes after the payload.
pub const CHECKSUM_BYTES: usize = 4;
/// Longest payload. Longer ones are refused before they are read.
pub const PAYLOAD_MAX: usize = 512;
/// Longest packet.
pub const PACKET_MAX: usize = HEAD_BYTES + PAYLOAD_MAX + CHECKSUM_BYTES;
/// Version of the stream, in its hello; raised when framing or order of packets change.
pub const STREAM_VERSION: u32 = 1;

/// What a packet holds. A receiver passes over kinds that it does not know.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u16)]
pub enum Kind {
    /// A [`StreamHello`], once each way.
    Hello = 1,
    /// The law in the plant's configuration, for controllers that are ours; once, after the hello.
    Law = 2,
    /// A [`PlantFrame`], once a tick.
    Plant = 3,
    /// A [`ControllerFrame`], the answer.
    Controller = 4,
    /// A [`TargetReport`], after the last answer, from targets that count.
    Report = 5,
}

impl Kind {
    /// Every kind.
    pub const ALL: [Self; 5] = [
        Self::Hello,
        Self::Law,
        Self::Plant,
        Self::Controller,
        Self::Report,
    ];

    /// The kind with number `number`, if there is one.
    pub fn from_u16(number: u16) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| *kind as u16 == number)
    }
}

message! {
    /// What each side says first on a byte stream. Its layout never changes.
    #[derive(Default)]
    pub struct StreamHello {
        /// [`STREAM_VERSION`] of the sender.
        pub stream_version: u32,
        /// 1 plant, 2 controller.
        pub role: u32,
        /// [`PROTOCOL_VERSION`] of the sender.
        pub protocol_version: u32,
        /// 1 if the sender refuses to ride with the other side, else 0.
        pub refused: u32,
        /// [`PROTOCOL_HASH`] of the sender.
        pub protocol_hash: u64,
        /// Bytes of a plant frame.
        pub plant_frame_bytes: u32,
        /// Bytes of a controller frame.
        pub controller_frame_bytes: u32,
    }
}

/// [`StreamHello::role`] of the plant.
pub const ROLE_PLANT: u32 = 1;
/// [`StreamHello::role`] of the controller.
pub const ROLE_CONTROLLER: u32 = 2;

impl StreamHello {
    /// The hello of this build.
    pub const fn new(role: u32) -> Self {
        Self {
            stream_version: STREAM_VERSION,
            role,
            protocol_version: PROTOCOL_VERSION,
            refused: 0,
            protocol_hash: PROTOCOL_HASH,
            plant_frame_bytes: PlantFrame::SIZE as u32,
            controller_frame_bytes: ControllerFrame::SIZE as u32,
        }
    }

    /// What keeps this side from riding with `theirs`, if anything does.
    pub fn mismatch(&self, theirs: &Self) -> Option<&'static str> {
        if self.stream_version != theirs.stream_version {
            Some("another version of the byte stream")
        } else if self.role == theirs.role {
            Some("both have the same role")
        } else if self.protocol_version != theirs.protocol_version {
            Some("another protocol version")
        } else if self.protocol_hash != theirs.protocol_hash
            || self.plant_frame_bytes != theirs.plant_frame_bytes
            || self.controller_frame_bytes != theirs.controller_frame_bytes
        {
            Some("another message layout")
        } else if theirs.refused != 0 {
            Some("the other side refused")
        } else {
            None
        }
    }
}

message! {
    /// What a target measured while it rode. Counts are those of its own counter: processor cycles
    /// on a board; in QEMU proportional to instructions, by `loop_counts`.
    #[derive(Default)]
    pub struct TargetReport {
        /// Ticks answered.
        pub ticks: u32,
        /// Packets that were passed over because they were broken.
        pub broken_packets: u32,
        /// Counts for a loop of [`LOOP_INSTRUCTIONS`] instructions.
        pub loop_counts: u32,
        /// Most counts of one controller step.
        pub step_counts_max: u32,
        /// The tick that took them.
        pub step_max_tick: u32,
        /// Most counts from a frame's last byte to the bytes of its answer: checksums, decoding,
        /// step and encoding.
        pub tick_counts_max: u32,
        /// Sum of the counts of all controller steps.
        pub step_counts_sum: u64,
        /// Sum of the counts from last byte to answer.
        pub tick_counts_sum: u64,
        /// Bytes of the stack.
        pub stack_bytes: u32,
        /// Most bytes of it that were ever in use (painted stack).
        pub stack_used_bytes: u32,
    }
}

/// Instructions of the loop behind [`TargetReport::loop_counts`].
pub const LOOP_INSTRUCTIONS: u32 = 2000;

/// Four bits at a time: a table of 64 bytes.
const CRC_TABLE: [u32; 16] = {
    let mut table = [0; 16];
    let mut i = 0;
    while i < 16 {
        let mut crc = i as u32;
        let mut bit = 0;
        while bit < 4 {
            crc = (crc >> 1) ^ if crc & 1 == 1 { 0xedb8_8320 } else { 0 };
            bit += 1;
        }
        table[i] = crc;
        i += 1;
    }
    table
};

/// CRC-32 of IEEE 802.3.
pub fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(u32::MAX, |crc, &byte| {
        let crc = crc ^ u32::from(byte);
        let crc = CRC_TABLE[(crc & 15) as usize] ^ (crc >> 4);
        CRC_TABLE[(crc & 15) as usize] ^ (crc >> 4)
    })
}

/// A packet that is ready to be sent.
pub struct Packet {
    bytes: [u8; PACKET_MAX],
    len: usize,
}

impl Packet {
    /// `message` as a packet of `kind`; empty if it is longer than [`PAYLOAD_MAX`].
    pub fn of(kind: Kind, message: &impl Wire) -> Self {
        let mut packet = Self {
            bytes: [0; PACKET_MAX],
            len: 0,
        };
        packet.len = seal(kind, &mut packet.bytes, |room| {
            let whole = room.len();
            message.put(room).map(|rest| whole - rest.len())
        });
        packet
    }

    /// `payload` as a packet of `kind`; empty if it is longer than [`PAYLOAD_MAX`].
    pub fn raw(kind: Kind, payload: &[u8]) -> Self {
        let mut packet = Self {
            bytes: [0; PACKET_MAX],
            len: 0,
        };
        packet.len = seal(kind, &mut packet.bytes, |room| {
            room.get_mut(..payload.len())?.copy_from_slice(payload);
            Some(payload.len())
        });
        packet
    }

    /// What goes over the line.
    pub fn bytes(&self) -> &[u8] {
        self.bytes.get(..self.len).unwrap_or(&[])
    }
}

/// Head and checksum around the payload that `fill` writes; the packet's length, 0 if it has none.
fn seal(
    kind: Kind,
    bytes: &mut [u8; PACKET_MAX],
    fill: impl FnOnce(&mut [u8]) -> Option<usize>,
) -> usize {
    let [_, _, _, _, _, _, _, _, room @ ..] = bytes;
    let length = room.get_mut(..PAYLOAD_MAX).and_then(fill).unwrap_or(0);
    let [k0, k1] = (kind as u16).to_le_bytes();
    let [l0, l1] = (length as u16).to_le_bytes();
    let [m0, m1, m2, m3] = MAGIC;
    for (byte, value) in bytes.iter_mut().zip([m0, m1, m2, m3, k0, k1, l0, l1]) {
        *byte = value;
    }
    let end = HEAD_BYTES + length;
    let Some((body, rest)) = bytes.split_at_mut_checked(end) else {
        return 0;
    };
    let crc = crc32(body.get(MAGIC.len()..).unwrap_or(&[]));
    match rest.first_chunk_mut() {
        Some(place) if length > 0 => *place = crc.to_le_bytes(),
        _ => return 0,
    }
    end + CHECKSUM_BYTES
}

/// Why bytes are no packet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Broken {
    /// A byte outside of any packet.
    Stray {
        /// The byte.
        byte: u8,
    },
    /// A payload longer than [`PAYLOAD_MAX`] is announced.
    Length {
        /// Its length.
        found: u16,
    },
    /// The checksum does not fit.
    Checksum {
        /// As sent.
        found: u32,
        /// As computed.
        expected: u32,
    },
}

impl core::fmt::Display for Broken {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Stray { byte } => write!(f, "byte {byte:#04x} stands outside of any packet"),
            Self::Length { found } => {
                write!(
                    f,
                    "a payload of {found} bytes is announced; at most {PAYLOAD_MAX}"
                )
            }
            Self::Checksum { found, expected } => {
                write!(
                    f,
                    "the checksum is {found:#010x}, expected {expected:#010x}"
                )
            }
        }
    }
}

/// Finds packets in a stream of bytes. After anything broken it looks for the next magic.
pub struct Decoder {
    bytes: [u8; PACKET_MAX],
    filled: usize,
    /// Bytes of the packet, once its head is known; 0 before.
    whole: usize,
    /// End of the last packet's payload; 0 before the first.
    end: usize,
}

impl Default for Decoder {
    fn default() -> Self {
        Self {
            bytes: [0; PACKET_MAX],
            filled: 0,
            whole: 0,
            end: 0,
        }
    }
}

impl Decoder {
    /// Takes one byte; true if it ends a packet, which [`packet`](Self::packet) then gives.
    #[inline]
    pub fn push(&mut self, byte: u8) -> Result<bool, Broken> {
        if let Some(place) = self.bytes.get_mut(self.filled) {
            *place = byte;
        }
        self.filled += 1;
        if self.whole == 0 {
            return self.head(byte).map(|()| false);
        }
        if self.filled < self.whole {
            return Ok(false);
        }
        let end = self.whole - CHECKSUM_BYTES;
        (self.filled, self.whole, self.end) = (0, 0, 0);
        let (body, rest) = self.bytes.split_at_checked(end).unwrap_or((&[], &[]));
        let found = u32::from_le_bytes(rest.first_chunk().copied().unwrap_or_default());
        let expected = crc32(body.get(MAGIC.len()..).unwrap_or(&[]));
        if found != expected {
            return Err(Broken::Checksum { found, expected });
        }
        self.end = end;
        Ok(true)
    }

    /// Number of the kind and payload of the packet that the last byte ended; kind 0 if it ended
    /// none.
    #[inline]
    pub fn packet(&self) -> (u16, &[u8]) {
        match self.bytes.get(..self.end) {
            Some([_, _, _, _, k0, k1, _, _, payload @ ..]) => {
                (u16::from_le_bytes([*k0, *k1]), payload)
            }
            _ => (0, &[]),
        }
    }

    /// The head so far.
    #[inline]
    fn head(&mut self, byte: u8) -> Result<(), Broken> {
        self.end = 0;
        if let Some(expected) = MAGIC.get(self.filled - 1) {
            if byte != *expected {
                self.filled = usize::from(byte == MAGIC[0]);
                return Err(Broken::Stray { byte });
            }
        } else if self.filled == HEAD_BYTES {
            let [_, _, _, _, _, _, l0, l1, ..] = self.bytes;
            let found = u16::from_le_bytes([l0, l1]);
            if usize::from(found) > PAYLOAD_MAX {
                self.filled = 0;
                return Err(Broken::Length { found });
            }
            self.whole = HEAD_BYTES + usize::from(found) + CHECKSUM_BYTES;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    extern crate std;
    use std::vec::Vec;

    /// Everything that comes out of `bytes`.
    fn decode(decoder: &mut Decoder, bytes: &[u8]) -> (Vec<(u16, Vec<u8>)>, Vec<Broken>) {
        let (mut packets, mut broken) = (Vec::new(), Vec::new());
        for byte in bytes {
            match decoder.push(*byte) {
                Ok(true) => {
                    let (kind, payload) = decoder.packet();
                    packets.push((kind, payload.to_vec()));
                }
                Ok(false) => {}
                Err(error) => broken.push(error),
            }
        }
        (packets, broken)
    }

    #[test]
    fn the_checksum_is_that_of_zlib() {
        // The check value that every catalogue of CRCs gives for CRC-32.
        assert_eq!(crc32(b"123456789"), 0xcbf4_3926);
        assert_eq!(crc32(b""), 0);
    }

    #[test]
    fn a_frame_survives_the_stream_and_what_stands_around_it() {
        let mut frame = PlantFrame::default();
        frame.header.tick = 77;
        frame.intent.pedal_nm = f32::from_bits(0x7fc0_1234);
        let packet = Packet::of(Kind::Plant, &frame);
        assert_eq!(packet.bytes().len(), 8 + PlantFrame::SIZE + 4);
        let mut line = b"noise TWH".to_vec();
        line.extend(packet.bytes());
        line.extend(packet.bytes());
        let (packets, broken) = decode(&mut Decoder::default(), &line);
        assert!(broken.iter().all(|b| matches!(b, Broken::Stray { .. })));
        assert_eq!(packets.len(), 2);
        for (kind, payload) in packets {
            assert_eq!(Kind::from_u16(kind), Some(Kind::Plant));
            let (back, _) = PlantFrame::get(&payload).expect("whole");
            assert_eq!(back.header.tick, 77);
            assert_eq!(back.intent.pedal_nm.to_bits(), 0x7fc0_1234);
        }
    }

    #[test]
    fn every_flipped_bit_is_found_and_the_next_packet_is_read() {
        let hello = Packet::of(Kind::Hello, &StreamHello::new(ROLE_PLANT));
        for bit in 0..hello.bytes().len() * 8 {
            let mut line = hello.bytes().to_vec();
            line[bit / 8] ^= 1 << (bit % 8);
            let (packets, _) = decode(&mut Decoder::default(), &line);
            assert!(packets.is_empty(), "bit {bit}");
            // A longer length swallows what follows; after a packet's worth of it all is well.
            for _ in 0..40 {
                line.extend(hello.bytes());
            }
            let (packets, broken) = decode(&mut Decoder::default(), &line);
            assert!(packets.len() >= 20 && !broken.is_empty(), "bit {bit}");
        }
    }

    #[test]
    fn payloads_that_are_too_long_are_refused_on_both_sides() {
        assert!(
            Packet::raw(Kind::Law, &[1; PAYLOAD_MAX + 1])
                .bytes()
                .is_empty()
        );
        let longest = Packet::raw(Kind::Law, &[1; PAYLOAD_MAX]);
        assert_eq!(longest.bytes().len(), PACKET_MAX);
        let (packets, broken) = decode(&mut Decoder::default(), longest.bytes());
        assert_eq!((packets.len(), broken.len()), (1, 0));
        let mut decoder = Decoder::default();
        let (_, broken) = decode(&mut decoder, b"TWHB\x03\x00\x01\x02");
        assert_eq!(broken, [Broken::Length { found: 513 }]);
    }

    #[test]
    fn a_hello_that_does_not_fit_says_why() {
        let plant = StreamHello::new(ROLE_PLANT);
        let controller = StreamHello::new(ROLE_CONTROLLER);
        assert_eq!(plant.mismatch(&controller), None);
        assert_eq!(plant.mismatch(&plant), Some("both have the same role"));
        let other = StreamHello {
            protocol_hash: 1,
            ..controller
        };
        assert_eq!(plant.mismatch(&other), Some("another message layout"));
    }
}
