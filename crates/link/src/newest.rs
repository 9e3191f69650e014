//! Which of several answers may be applied.

use twinhub_types::ControllerFrame;

use crate::pacing::ANSWER_AGE_MAX;

/// Remembers which answers were applied.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Newest {
    /// Sequence of the next answer that may be applied.
    next: u64,
}

impl Newest {
    /// True if `answer` may be applied in tick `sequence`: newer than every one before, from no
    /// later tick, and at most [`ANSWER_AGE_MAX`] ticks old. Such an answer counts as applied.
    pub(crate) fn take(&mut self, answer: &ControllerFrame, sequence: u64) -> bool {
        let of = answer.header.sequence;
        let usable = of >= self.next && of <= sequence && sequence - of <= ANSWER_AGE_MAX;
        if usable {
            self.next = of + 1;
        }
        usable
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn answers_are_applied_once_in_order_and_not_when_old() {
        let answer = |sequence| {
            let mut answer = ControllerFrame::default();
            answer.header.sequence = sequence;
            answer
        };
        let mut newest = Newest::default();
        assert!(newest.take(&answer(0), 0));
        assert!(!newest.take(&answer(0), 1), "twice");
        assert!(newest.take(&answer(2), 4), "late");
        assert!(!newest.take(&answer(1), 4), "older than one before");
        assert!(!newest.take(&answer(9), 8), "from the future");
        assert!(!newest.take(&answer(u64::MAX), 8), "from the future");
        assert!(!newest.take(&answer(3), 24), "too old");
        assert!(newest.take(&answer(4), 24));
    }
}
