//! What a real-time ride asks of the operating system, and what it got.

use serde::{Deserialize, Serialize};
use std::io::Error;

/// Priority of a real-time ride among the first-in-first-out threads: in the middle, below what
/// kernels give their own threads.
pub const PRIORITY: i32 = 40;

/// What the operating system allowed this process.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Rights {
    /// The tick's thread runs before all others (SCHED_FIFO).
    pub sched_fifo: bool,
    /// Memory stays in memory (mlockall).
    pub memory_locked: bool,
    /// Why not, where something was refused.
    pub refused: Vec<String>,
}

impl Rights {
    /// Asks for everything, for the calling thread; threads that it starts later are ordinary.
    pub fn acquire() -> Self {
        let mut rights = Self::default();
        match ask_fifo() {
            Ok(()) => rights.sched_fifo = true,
            Err(e) => rights.refused.push(format!("SCHED_FIFO: {e}")),
        }
        // SAFETY: only changes how this process' pages are kept.
        match unsafe { libc::mlockall(libc::MCL_CURRENT | libc::MCL_FUTURE) } {
            0 => rights.memory_locked = true,
            _ => rights
                .refused
                .push(format!("mlockall: {}", Error::last_os_error())),
        }
        // An ordinary thread sleeps up to 50 µs longer than it asks for; a refusal costs just that.
        // SAFETY: sets one number of this thread.
        let _ = unsafe { libc::prctl(libc::PR_SET_TIMERSLACK, 1_u64, 0_u64, 0_u64, 0_u64) };
        rights
    }
}

/// Makes the calling thread a first-in-first-out one.
pub(crate) fn ask_fifo() -> Result<(), Error> {
    let parameters = libc::sched_param {
        sched_priority: PRIORITY,
    };
    let policy = libc::SCHED_FIFO | libc::SCHED_RESET_ON_FORK;
    // SAFETY: `parameters` lives through the call; 0 is the calling thread.
    match unsafe { libc::sched_setscheduler(0, policy, &parameters) } {
        0 => Ok(()),
        _ => Err(Error::last_os_error()),
    }
}

impl std::fmt::Display for Rights {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let got = |yes, name: &'static str| if yes { name } else { "" };
        let mut words = vec![
            got(self.sched_fifo, "SCHED_FIFO"),
            got(self.memory_locked, "locked memory"),
        ];
        words.retain(|word| !word.is_empty());
        if words.is_empty() {
            words.push("no real-time rights");
        }
        write!(f, "{}", words.join(", "))?;
        if !self.refused.is_empty() {
            write!(
                f,
                " (refused: {}; see `twinhub doctor`)",
                self.refused.join(", ")
            )?;
        }
        Ok(())
    }
}
