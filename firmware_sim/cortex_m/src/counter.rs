//! What a tick costs, by SysTick: processor cycles on a board. QEMU with `-icount` gives every
//! instruction the same time, so that counts are proportional to instructions; how many counts an
//! instruction takes is measured with a loop of known length.

use cortex_m::Peripherals;
use cortex_m::peripheral::SYST;
use cortex_m::peripheral::syst::SystClkSource;
use twinhub_types::stream::LOOP_INSTRUCTIONS;

/// SysTick counts down through 24 bits.
const MASK: u32 = 0x00ff_ffff;

/// A point in time, in counts.
#[derive(Clone, Copy, Default)]
pub struct Mark(u32);

/// Now.
pub fn now() -> Mark {
    Mark(SYST::get_current())
}

/// SysTick, running free.
pub struct Counter {
    /// Counts between two marks with nothing between them.
    nothing: u32,
}

impl Counter {
    /// Starts SysTick.
    pub fn start() -> Self {
        // SAFETY: nothing else uses SysTick.
        let mut syst = unsafe { Peripherals::steal() }.SYST;
        syst.set_clock_source(SystClkSource::Core);
        syst.set_reload(MASK);
        syst.clear_current();
        syst.enable_counter();
        let mut counter = Self { nothing: 0 };
        counter.nothing = counter.since(now());
        counter
    }

    /// Now.
    pub fn now(&self) -> Mark {
        now()
    }

    /// Counts since `mark`, at most 24 bits of them.
    pub fn since(&self, mark: Mark) -> u32 {
        let counts = mark.0.wrapping_sub(now().0) & MASK;
        counts.saturating_sub(self.nothing)
    }

    /// Counts for a loop of [`LOOP_INSTRUCTIONS`] instructions.
    pub fn loop_counts(&self) -> u32 {
        let start = now();
        // SAFETY: counts a register of its own down to zero.
        unsafe {
            core::arch::asm!(
                "2: subs {n}, {n}, #1",
                "bne 2b",
                n = inout(reg) LOOP_INSTRUCTIONS / 2 => _,
                options(nomem, nostack)
            );
        }
        self.since(start)
    }
}
