//! Signals to the processes of a ride, and the draw that decides about them.

use std::process::Child;
use twinhub_link::pacing::monotonic_ns;

/// One side of a ride.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// The plant's process.
    Plant,
    /// The controller's process.
    Controller,
}

/// Sends `signal` to `child`; gives the time of the monotonic clock just before, ns.
pub fn send(child: &Child, signal: i32) -> u64 {
    let at_ns = monotonic_ns();
    // SAFETY: the child was not waited for yet, so its number is still its own.
    unsafe { libc::kill(child.id() as i32, signal) };
    at_ns
}

/// A stream of even draws: SplitMix64 (Steele, Lea and Flood, 2014).
pub struct Draw(u64);

impl Draw {
    /// The stream of `seed` and `number`.
    pub fn new(seed: u64, number: u64) -> Self {
        Self(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ number.wrapping_mul(0xd1b5_4a32_d192_ed03))
    }

    /// A whole number from `least` to `most`.
    pub fn within(&mut self, least: u64, most: u64) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        least + (z ^ (z >> 31)) % (most - least + 1)
    }

    /// True in `percent` of 100 draws.
    pub fn one_in_100(&mut self, percent: u64) -> bool {
        self.within(0, 99) < percent
    }
}
