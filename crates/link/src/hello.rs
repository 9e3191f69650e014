//! The hello: 128 bytes that each side says once, and that never change their layout.

use crate::LinkError;
use crate::pacing::Pacing;
use twinhub_types::messages::{PROTOCOL_HASH, PROTOCOL_VERSION};
use twinhub_types::{ControllerFrame, PlantFrame, Wire};

/// Bytes of a hello.
pub const HELLO_BYTES: usize = 128;
const MAGIC: [u8; 8] = *b"TWINHUB\0";
const HELLO_VERSION: u32 = 1;
const TOOL_BYTES: usize = 48;

/// Frames go through iceoryx2 shared memory.
pub const TRANSPORT_SHARED_MEMORY: u32 = 0;
/// The iceoryx2 release whose shared-memory layout this build speaks: major, minor, patch.
const MIDDLEWARE: u32 = 0x00_0a_00;

/// Who speaks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// The bicycle.
    Plant,
    /// The stabilizer.
    Controller,
}

impl Role {
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Plant => "plant",
            Self::Controller => "controller",
        }
    }

    fn number(self) -> u32 {
        match self {
            Self::Plant => 1,
            Self::Controller => 2,
        }
    }
}

/// What a process says about itself at connection.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Identity {
    /// Name and version of the program, at most 48 bytes are sent.
    pub tool: String,
    /// [`PROTOCOL_VERSION`] of the program.
    pub protocol_version: u32,
    /// [`PROTOCOL_HASH`] of the program.
    pub protocol_hash: u64,
}

impl Default for Identity {
    fn default() -> Self {
        Self {
            tool: concat!("twinhub ", env!("CARGO_PKG_VERSION")).to_owned(),
            protocol_version: PROTOCOL_VERSION,
            protocol_hash: PROTOCOL_HASH,
        }
    }
}

/// One side's hello.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Hello {
    pub(crate) role: u32,
    pub(crate) refused: bool,
    pub(crate) session: u64,
    pub(crate) pacing: Pacing,
    identity: Identity,
    hello_version: u32,
    transport: u32,
    middleware: u32,
    plant_frame_bytes: u32,
    controller_frame_bytes: u32,
}

impl Hello {
    pub(crate) fn new(role: Role, identity: &Identity, session: u64, pacing: Pacing) -> Self {
        Self {
            role: role.number(),
            refused: false,
            session,
            pacing,
            identity: identity.clone(),
            hello_version: HELLO_VERSION,
            transport: TRANSPORT_SHARED_MEMORY,
            middleware: MIDDLEWARE,
            plant_frame_bytes: PlantFrame::SIZE as u32,
            controller_frame_bytes: ControllerFrame::SIZE as u32,
        }
    }

    pub(crate) fn bytes(&self) -> [u8; HELLO_BYTES] {
        let mut out = [0; HELLO_BYTES];
        let mut put = |at: usize, bytes: &[u8]| out[at..at + bytes.len()].copy_from_slice(bytes);
        put(0, &MAGIC);
        put(8, &self.hello_version.to_le_bytes());
        put(12, &self.role.to_le_bytes());
        put(16, &self.identity.protocol_version.to_le_bytes());
        put(20, &u32::from(self.refused).to_le_bytes());
        put(24, &self.identity.protocol_hash.to_le_bytes());
        put(32, &self.plant_frame_bytes.to_le_bytes());
        put(36, &self.controller_frame_bytes.to_le_bytes());
        put(40, &self.transport.to_le_bytes());
        put(44, &self.middleware.to_le_bytes());
        put(48, &self.session.to_le_bytes());
        put(
            56,
            &u32::from(self.pacing == Pacing::RealTime).to_le_bytes(),
        );
        let tool = self.identity.tool.as_bytes();
        put(64, &tool[..tool.len().min(TOOL_BYTES)]);
        out
    }

    /// Reads a hello; `None` if the sender is no twinhub program.
    pub(crate) fn parse(bytes: &[u8; HELLO_BYTES]) -> Option<Self> {
        let u32_at = |at: usize| bytes[at..].first_chunk().map(|b| u32::from_le_bytes(*b));
        let u64_at = |at: usize| bytes[at..].first_chunk().map(|b| u64::from_le_bytes(*b));
        let tool: String = String::from_utf8_lossy(&bytes[64..64 + TOOL_BYTES])
            .chars()
            .filter(|c| !c.is_control())
            .collect();
        (bytes[..8] == MAGIC).then_some(())?;
        Some(Self {
            hello_version: u32_at(8)?,
            role: u32_at(12)?,
            refused: u32_at(20)? != 0,
            identity: Identity {
                tool,
                protocol_version: u32_at(16)?,
                protocol_hash: u64_at(24)?,
            },
            plant_frame_bytes: u32_at(32)?,
            controller_frame_bytes: u32_at(36)?,
            transport: u32_at(40)?,
            middleware: u32_at(44)?,
            session: u64_at(48)?,
            pacing: match u32_at(56)? {
                0 => Pacing::Lockstep,
                _ => Pacing::RealTime,
            },
        })
    }

    /// What keeps the two from talking, if anything does.
    fn mismatch(&self, theirs: &Self) -> Option<&'static str> {
        let (ours, other) = (&self.identity, &theirs.identity);
        if self.hello_version != theirs.hello_version {
            Some("another version of the hello")
        } else if self.role == theirs.role {
            Some("both have the same role")
        } else if ours.protocol_version != other.protocol_version {
            Some("another protocol version")
        } else if ours.protocol_hash != other.protocol_hash
            || self.plant_frame_bytes != theirs.plant_frame_bytes
            || self.controller_frame_bytes != theirs.controller_frame_bytes
        {
            Some("another message layout")
        } else if self.transport != theirs.transport || self.middleware != theirs.middleware {
            Some("another transport or version of the shared-memory middleware")
        } else if theirs.refused {
            Some("the other side refused")
        } else {
            None
        }
    }

    /// Accepts or refuses the process `pid` that said `theirs`.
    pub(crate) fn accept(&self, theirs: &Self, pid: u32) -> Result<(), LinkError> {
        match self.mismatch(theirs) {
            None => Ok(()),
            Some(reason) => Err(LinkError::Refused {
                pid,
                reason,
                ours: self.to_string(),
                theirs: theirs.to_string(),
            }),
        }
    }
}

impl std::fmt::Display for Hello {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let role = match self.role {
            1 => "plant",
            2 => "controller",
            _ => "unknown role",
        };
        write!(
            f,
            "{role} `{}`, protocol {}, layout {:016x}, frames of {} and {} bytes, iceoryx2 {}.{}.{}",
            self.identity.tool,
            self.identity.protocol_version,
            self.identity.protocol_hash,
            self.plant_frame_bytes,
            self.controller_frame_bytes,
            self.middleware >> 16,
            self.middleware >> 8 & 0xff,
            self.middleware & 0xff,
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_hello_survives_its_bytes_and_a_stranger_is_known() {
        let hello = Hello::new(
            Role::Controller,
            &Identity::default(),
            0x1234_5678_9abc_def0,
            Pacing::RealTime,
        );
        assert_eq!(Hello::parse(&hello.bytes()), Some(hello.clone()));
        let mut bytes = hello.bytes();
        bytes[3] ^= 1;
        assert_eq!(Hello::parse(&bytes), None);
    }

    #[test]
    fn every_difference_is_refused_and_both_sides_are_named() {
        let plant = Hello::new(Role::Plant, &Identity::default(), 1, Pacing::Lockstep);
        let fits = Hello::new(Role::Controller, &Identity::default(), 0, Pacing::Lockstep);
        assert!(plant.accept(&fits, 9).is_ok());
        let changes: [fn(&mut Hello); 7] = [
            |h| h.hello_version += 1,
            |h| h.role = 1,
            |h| h.identity.protocol_version += 1,
            |h| h.identity.protocol_hash ^= 0xff,
            |h| h.plant_frame_bytes += 8,
            |h| h.middleware += 1,
            |h| h.refused = true,
        ];
        for change in changes {
            let mut other = fits.clone();
            change(&mut other);
            assert!(plant.accept(&other, 9).is_err(), "{other:?}");
        }
        let mut other = fits;
        other.identity.protocol_hash = 0xdead_beef_0000_0001;
        let text = plant
            .accept(&other, 9)
            .expect_err("another layout")
            .to_string();
        assert!(text.contains("deadbeef00000001"), "{text}");
        assert!(text.contains(&format!("{PROTOCOL_HASH:016x}")), "{text}");
    }
}
