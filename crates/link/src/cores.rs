//! Which core this thread runs on.

use rustix::thread::{CpuSet, sched_getaffinity, sched_getcpu, sched_setaffinity};

/// If this thread is on `core` and may run elsewhere, moves it to another core, where it stays
/// until the system has reason to move it: it may run where it might before. True if it moved.
pub(crate) fn step_off(core: usize) -> bool {
    if sched_getcpu() != core || core >= CpuSet::MAX_CPU {
        return false;
    }
    let Ok(allowed) = sched_getaffinity(None) else {
        return false;
    };
    let mut others = allowed;
    others.unset(core);
    if others.count() == 0 || sched_setaffinity(None, &others).is_err() {
        return false;
    }
    let _ = sched_setaffinity(None, &allowed);
    sched_getcpu() != core
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_thread_steps_off_a_core_and_may_come_back() {
        let before = sched_getaffinity(None).expect("its own cores");
        let here = sched_getcpu();
        if step_off(here) {
            assert_ne!(sched_getcpu(), here);
        }
        assert_eq!(before, sched_getaffinity(None).expect("its own cores"));
        // Nobody is on a core that does not exist.
        assert!(!step_off(CpuSet::MAX_CPU));
    }
}
