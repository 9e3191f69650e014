#![no_std]
#![no_main]
//! The stabilizer's controller as firmware of a Cortex-M4F: joins a ride over a byte stream and
//! answers its plant tick by tick. The same crates as the controller's process.
//!
//! No panic: the panic handler calls a function that exists nowhere, so an image with a panic in
//! it does not link. No allocator. Its clock is the plant's: it answers when a frame comes, and
//! waits without limit (lockstep). `README.md` says what a board on a bicycle needs besides.

mod counter;
mod line;
#[cfg(feature = "semihosting")]
mod semihost;
mod session;
mod stack;
mod uart;

use line::Line;

unsafe extern "C" {
    safe fn the_firmware_can_panic() -> !;
}

#[panic_handler]
fn panic(_: &core::panic::PanicInfo) -> ! {
    the_firmware_can_panic()
}

#[cortex_m_rt::entry]
fn main() -> ! {
    let counter = counter::Counter::start();
    let mut line = Line::open();
    loop {
        let ended = session::ride(&mut line, &counter);
        line.end(ended);
    }
}

/// A fault of the processor, a stack that grew too far among them: the end in QEMU; on a board the
/// watchdog's business, and the motor drives ramp out by themselves.
#[cortex_m_rt::exception]
unsafe fn HardFault(_: &cortex_m_rt::ExceptionFrame) -> ! {
    #[cfg(feature = "semihosting")]
    cortex_m_semihosting::debug::exit(cortex_m_semihosting::debug::EXIT_FAILURE);
    loop {
        cortex_m::asm::nop();
    }
}
