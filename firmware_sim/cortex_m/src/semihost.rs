//! Semihosting: files of the host, for QEMU and debuggers.
//!
//! Source: "Semihosting for AArch32 and AArch64", Arm, SYS_OPEN, SYS_READ, SYS_WRITE and
//! SYS_GET_CMDLINE.

use cortex_m_semihosting::syscall;

/// What the host names its two pipes, in QEMU's working directory.
const TO_TARGET: &core::ffi::CStr = c"to_target";
const FROM_TARGET: &core::ffi::CStr = c"from_target";
const MODE_READ_BINARY: usize = 1;
const MODE_WRITE_BINARY: usize = 5;

/// Two files: one to read, one to write.
pub struct Files {
    input: usize,
    output: usize,
}

impl Files {
    /// Opens both; waits for a plant at their other ends.
    pub fn open() -> Self {
        Self {
            input: open(TO_TARGET, MODE_READ_BINARY),
            output: open(FROM_TARGET, MODE_WRITE_BINARY),
        }
    }

    /// See [`Line::read`](crate::line::Line::read).
    pub fn read(&mut self, bytes: &mut [u8]) -> Option<usize> {
        let (place, len) = (bytes.as_mut_ptr(), bytes.len());
        // SAFETY: the host writes at most `len` bytes to `place`, and answers with how many of
        // them are missing.
        let missing = unsafe { syscall!(READ, self.input, place, len) };
        len.checked_sub(missing).filter(|&n| n > 0)
    }

    /// See [`Line::write`](crate::line::Line::write).
    pub fn write(&mut self, bytes: &[u8]) -> Option<()> {
        let (place, len) = (bytes.as_ptr(), bytes.len());
        // SAFETY: the host reads `len` bytes from `place`.
        let missing = unsafe { syscall!(WRITE, self.output, place, len) };
        (missing == 0).then_some(())
    }
}

fn open(name: &core::ffi::CStr, mode: usize) -> usize {
    // SAFETY: name and length are those of one text.
    unsafe { syscall!(OPEN, name.as_ptr(), mode, name.count_bytes()) }
}

/// True if the program was started with the argument `uart`.
pub fn command_line_asks_for_uart() -> bool {
    let mut text = [0u8; 64];
    let block = [text.as_mut_ptr() as usize, text.len()];
    // SAFETY: the host writes at most `text.len()` bytes to `text`.
    let failed = unsafe { cortex_m_semihosting::syscall1(0x15, block.as_ptr() as usize) };
    failed == 0 && text.windows(5).any(|word| word == b" uart")
}
