//! What the controller's process says about itself: counters and quantiles, whole numbers only.

use crate::timing::Quantiles;
use serde::{Deserialize, Serialize};

/// Words of an account on the shared page.
pub(crate) const WORDS: usize = 18;

/// Quantiles of a time in ns: p50, p99, p99.9 and the longest.
pub type QuantilesNs = [u64; 4];

/// The controller's account of itself.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Account {
    /// Frames answered.
    pub ticks: u64,
    /// Frames of the plant that never came.
    pub frames_lost: u64,
    /// Ticks without a frame, by the controller's own clock.
    pub silent_ticks: u64,
    /// Ticks whose computation took longer than a tick.
    pub overruns: u64,
    /// All health flags that were raised, as bits.
    pub health: u64,
    /// From the plant's sending of a frame to its arrival.
    pub wake_up_ns: QuantilesNs,
    /// From a frame's arrival to its answer.
    pub compute_ns: QuantilesNs,
    /// From an answer to the next frame.
    pub wait_ns: QuantilesNs,
    /// Number of measured wake-ups; the other times are measured in every tick.
    pub wake_ups: u64,
}

impl Account {
    pub(crate) fn words(&self) -> [u64; WORDS] {
        let mut words = [0; WORDS];
        words[..5].copy_from_slice(&[
            self.ticks,
            self.frames_lost,
            self.silent_ticks,
            self.overruns,
            self.health,
        ]);
        words[5..9].copy_from_slice(&self.wake_up_ns);
        words[9..13].copy_from_slice(&self.compute_ns);
        words[13..17].copy_from_slice(&self.wait_ns);
        words[17] = self.wake_ups;
        words
    }

    pub(crate) fn from_words(words: [u64; WORDS]) -> Self {
        let four = |at: usize| [words[at], words[at + 1], words[at + 2], words[at + 3]];
        Self {
            ticks: words[0],
            frames_lost: words[1],
            silent_ticks: words[2],
            overruns: words[3],
            health: words[4],
            wake_up_ns: four(5),
            compute_ns: four(9),
            wait_ns: four(13),
            wake_ups: words[17],
        }
    }
}

/// An [`Account`] as reports print it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ControllerTiming {
    /// Frames answered.
    pub ticks: u64,
    /// Frames of the plant that never came.
    pub frames_lost: u64,
    /// Ticks without a frame, by the controller's own clock.
    pub silent_ticks: u64,
    /// Ticks whose computation took longer than a tick.
    pub overruns: u64,
    /// Codes of all health flags that were raised.
    pub health: Vec<String>,
    /// From the plant's sending of a frame to its arrival, µs.
    pub wake_up_us: Quantiles,
    /// From a frame's arrival to its answer, µs.
    pub compute_us: Quantiles,
    /// From an answer to the next frame, µs.
    pub wait_us: Quantiles,
}

impl From<&Account> for ControllerTiming {
    fn from(account: &Account) -> Self {
        let raised = twinhub_types::Health::from_bits(account.health as u32);
        let quantiles = |ns| Quantiles::from_ns(account.ticks, ns);
        Self {
            ticks: account.ticks,
            frames_lost: account.frames_lost,
            silent_ticks: account.silent_ticks,
            overruns: account.overruns,
            health: twinhub_types::Health::TABLE
                .iter()
                .filter(|entry| raised.any(entry.flag))
                .map(|entry| entry.code.to_owned())
                .collect(),
            wake_up_us: Quantiles::from_ns(account.wake_ups, account.wake_up_ns),
            compute_us: quantiles(account.compute_ns),
            wait_us: quantiles(account.wait_ns),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_account_survives_its_words_and_any_words_are_an_account() {
        let mut words = [0; WORDS];
        for (i, word) in words.iter_mut().enumerate() {
            *word = u64::MAX - i as u64;
        }
        let account = Account::from_words(words);
        assert_eq!(account.words(), words);
        let timing = ControllerTiming::from(&account);
        assert!(timing.wait_us.max > 0.0 && timing.wait_us.max.is_finite());
    }
}
