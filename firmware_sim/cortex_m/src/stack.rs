//! How much of the stack was ever used: cortex-m-rt paints it before the program starts.

use core::ptr::{addr_of, read_volatile};

const PAINT: u32 = cortex_m_rt::STACK_PAINT_VALUE;

unsafe extern "C" {
    static _stack_start: u32;
    static _stack_end: u32;
}

/// Lowest and highest address; the stack grows down.
fn ends() -> (*const u32, *const u32) {
    (addr_of!(_stack_end), addr_of!(_stack_start))
}

/// Bytes of the stack.
pub fn bytes() -> u32 {
    let (low, high) = ends();
    (high as usize - low as usize) as u32
}

/// Most bytes that were ever in use.
pub fn used_bytes() -> u32 {
    let (low, high) = ends();
    let mut at = low;
    // SAFETY: `at` stays within the stack, which is memory of ours, aligned to words.
    while at < high && unsafe { read_volatile(at) } == PAINT {
        at = at.wrapping_add(1);
    }
    (high as usize - at as usize) as u32
}
