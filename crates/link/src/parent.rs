//! A child process that does not outlive its parent.

use rustix::process::{Signal, getppid, set_parent_process_death_signal};

/// Asks the kernel to end this process with SIGTERM when the thread that started it ends.
///
/// `parent` is the process id of the parent as it told the child; false if that parent is
/// already gone, and the child should end at once. Start children from the main thread, or from
/// one that lives as long as they should.
pub fn watch_parent(parent: u32) -> bool {
    let _ = set_parent_process_death_signal(Some(Signal::TERM));
    // Whoever died before the request can no longer send a signal; it shows in our parent's id.
    getppid().is_some_and(|pid| pid.as_raw_nonzero().get() as u32 == parent)
}
