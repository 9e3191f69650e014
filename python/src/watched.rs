//! Long work that hears signals: it runs on a thread of its own while the caller's looks for Ctrl-C
//! and calls `progress`.

use crate::errors;
use pyo3::prelude::*;
use std::any::Any;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::time::Duration;

/// Wall time between two looks at signals.
const LOOK_EVERY: Duration = Duration::from_millis(50);

/// What work that is to end unwinds with.
struct Ended;

/// The work's side.
pub struct Teller {
    stop: Arc<AtomicBool>,
    told: Sender<String>,
}

impl Teller {
    /// Says where the work is. Does not come back if the work is to end.
    pub fn tell(&self, text: &str) {
        // Nobody listens: the caller has gone already.
        if self.stop.load(Ordering::Relaxed) || self.told.send(text.to_owned()).is_err() {
            std::panic::resume_unwind(Box::new(Ended));
        }
    }

    /// Is the work to go on?
    pub fn go_on(&self) -> bool {
        !self.stop.load(Ordering::Relaxed)
    }
}

/// Runs `work`; its last word is the answer. Ctrl-C, and what `progress` raises, end the call at once;
/// the work ends when it next looks, and nothing is told after that.
///
/// # Errors
/// What a signal or `progress` raises; a `RideError` if the work panics.
pub fn watched<T: Send + 'static>(
    py: Python<'_>,
    progress: Option<&Py<PyAny>>,
    work: impl FnOnce(&Teller) -> T + Send + 'static,
) -> PyResult<T> {
    let stop = Arc::new(AtomicBool::new(false));
    let (told, hears) = channel::<String>();
    let teller = Teller {
        stop: Arc::clone(&stop),
        told,
    };
    let worker = std::thread::spawn(move || {
        let answer = work(&teller);
        drop(teller);
        answer
    });
    py.detach(move || {
        loop {
            let heard = hears.recv_timeout(LOOK_EVERY);
            let looked = Python::attach(|py| -> PyResult<()> {
                py.check_signals()?;
                if let (Ok(text), Some(progress)) = (&heard, progress) {
                    progress.call1(py, (text,))?;
                }
                Ok(())
            });
            if let Err(error) = looked {
                stop.store(true, Ordering::Relaxed);
                return Err(error);
            }
            if matches!(heard, Err(RecvTimeoutError::Disconnected)) {
                return worker.join().map_err(|panic| panicked(&*panic));
            }
        }
    })
}

/// A panic of the work as an exception.
pub fn panicked(panic: &(dyn Any + Send)) -> PyErr {
    let text = panic
        .downcast_ref::<&str>()
        .map(|text| (*text).to_owned())
        .or_else(|| panic.downcast_ref::<String>().cloned())
        .unwrap_or_else(|| "of unknown cause".to_owned());
    errors::python::RideError::new_err(format!(
        "a mistake of twinhub's, not of yours: {text}; please report it with what you called"
    ))
}
