//! The byte stream to the plant, whatever carries it.

#[cfg(feature = "semihosting")]
use crate::semihost;
use crate::session::Ended;
use crate::uart::Uart;
use crate::{counter, counter::Mark};
use twinhub_types::stream::{Decoder, Kind};

/// What carries the bytes.
pub enum Line {
    /// Two files of the host.
    #[cfg(feature = "semihosting")]
    Files(semihost::Files),
    /// The UART.
    Uart(Uart),
}

impl Line {
    /// The UART; with semihosting, the files unless the command line says `uart`.
    pub fn open() -> Self {
        #[cfg(feature = "semihosting")]
        if !semihost::command_line_asks_for_uart() {
            return Self::Files(semihost::Files::open());
        }
        Self::Uart(Uart::open())
    }

    /// Waits for bytes; fills the front of `bytes` and says how many came. `None` at the end.
    pub fn read(&mut self, bytes: &mut [u8]) -> Option<usize> {
        match self {
            #[cfg(feature = "semihosting")]
            Self::Files(files) => files.read(bytes),
            Self::Uart(uart) => uart.read(bytes),
        }
    }

    /// Writes all of `bytes`; `None` if nobody is there any more.
    pub fn write(&mut self, bytes: &[u8]) -> Option<()> {
        match self {
            #[cfg(feature = "semihosting")]
            Self::Files(files) => files.write(bytes),
            Self::Uart(uart) => {
                uart.write(bytes);
                Some(())
            }
        }
    }

    /// After a ride. Ends the program where there is something to return to; a board waits for
    /// the next ride.
    pub fn end(&mut self, ended: Ended) {
        #[cfg(feature = "semihosting")]
        {
            use cortex_m_semihosting::debug::{EXIT_FAILURE, EXIT_SUCCESS, exit};
            exit(match ended {
                Ended::LastFrame => EXIT_SUCCESS,
                Ended::Left => EXIT_FAILURE,
            });
        }
        #[cfg(not(feature = "semihosting"))]
        let _ = ended;
    }
}

/// Bytes that arrived, on their way to packets.
#[derive(Default)]
pub struct Inbox {
    decoder: Decoder,
    chunk: Chunk,
    arrived: Mark,
    broken: u32,
}

struct Chunk {
    bytes: [u8; 256],
    used: usize,
    len: usize,
}

impl Default for Chunk {
    fn default() -> Self {
        Self {
            bytes: [0; 256],
            used: 0,
            len: 0,
        }
    }
}

impl Inbox {
    /// The payload of the next packet of `kind`; others are passed over. `None` at the end.
    pub fn wait(&mut self, line: &mut Line, kind: Kind) -> Option<&[u8]> {
        loop {
            let byte = self.byte(line)?;
            match self.decoder.push(byte) {
                Ok(true) if self.decoder.packet().0 == kind as u16 => break,
                Ok(_) => {}
                Err(_) => self.broken = self.broken.saturating_add(1),
            }
        }
        Some(self.decoder.packet().1)
    }

    fn byte(&mut self, line: &mut Line) -> Option<u8> {
        if self.chunk.used >= self.chunk.len {
            self.chunk.len = line.read(&mut self.chunk.bytes)?;
            self.chunk.used = 0;
            self.arrived = counter::now();
        }
        let byte = self.chunk.bytes.get(self.chunk.used).copied();
        self.chunk.used += 1;
        byte
    }

    /// When the last bytes arrived.
    pub fn arrived(&self) -> Mark {
        self.arrived
    }

    /// Bytes and packets that were passed over.
    pub fn broken(&self) -> u32 {
        self.broken
    }
}
