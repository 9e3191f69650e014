//! UART 0 of the machine mps2-an386 (CMSDK APB UART), by polling. The one file to replace for
//! another chip.
//!
//! Source: "Cortex-M System Design Kit, Technical Reference Manual", Arm, APB UART: data, state,
//! control, baud divider.

use core::ptr::{read_volatile, write_volatile};

const DATA: *mut u32 = 0x4000_4000 as *mut u32;
const STATE: *const u32 = 0x4000_4004 as *const u32;
const CONTROL: *mut u32 = 0x4000_4008 as *mut u32;
const BAUD_DIVIDER: *mut u32 = 0x4000_4010 as *mut u32;

const TX_FULL: u32 = 1;
const RX_FULL: u32 = 2;
const TX_AND_RX: u32 = 3;
/// The smallest that the UART takes; QEMU ignores it.
const FASTEST: u32 = 16;

/// The UART, switched on.
pub struct Uart(());

impl Uart {
    /// Switches it on.
    pub fn open() -> Self {
        // SAFETY: registers of the UART, which nothing else uses.
        unsafe {
            write_volatile(BAUD_DIVIDER, FASTEST);
            write_volatile(CONTROL, TX_AND_RX);
        }
        Self(())
    }

    /// Waits for the next byte and puts it in front of `bytes`.
    pub fn read(&mut self, bytes: &mut [u8]) -> Option<usize> {
        // SAFETY: as in `open`.
        while unsafe { read_volatile(STATE) } & RX_FULL == 0 {}
        // SAFETY: as in `open`.
        *bytes.first_mut()? = unsafe { read_volatile(DATA) } as u8;
        Some(1)
    }

    /// Sends `bytes`.
    pub fn write(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            // SAFETY: as in `open`.
            while unsafe { read_volatile(STATE) } & TX_FULL != 0 {}
            // SAFETY: as in `open`.
            unsafe { write_volatile(DATA, byte.into()) };
        }
    }
}
