//! Long work that hears signals: it runs on a thread of its own while the caller's looks for Ctrl-C
//! and hears how far it is.

use crate::errors;
use pyo3::prelude::*;
use std::any::Any;
use std::panic::resume_unwind;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::time::Duration;

/// Wall time between two looks at signals.
const LOOK_EVERY: Duration = Duration::from_millis(50);

/// What work that is to end unwinds with.
pub struct Ended;

/// Ends the work that calls it, from as deep as it is.
pub fn end() -> ! {
    resume_unwind(Box::new(Ended))
}

/// The work's side: messages of the kind `M` go to the caller's.
pub struct Teller<M> {
    stop: Arc<AtomicBool>,
    told: Sender<M>,
}

impl<M> Teller<M> {
    /// Says where the work is. Does not come back if the work is to end.
    pub fn tell(&self, message: M) {
        // Nobody listens: the caller has gone already.
        if !self.go_on() || self.told.send(message).is_err() {
            end();
        }
    }

    /// Is the work to go on?
    pub fn go_on(&self) -> bool {
        !self.stop.load(Ordering::Relaxed)
    }
}

/// Hears texts with a callable, if there is one.
pub fn texts(
    progress: Option<&Py<PyAny>>,
) -> impl FnMut(Python<'_>, String) -> PyResult<()> + Send {
    move |py, text| match progress {
        Some(progress) => progress.call1(py, (text,)).map(|_| ()),
        None => Ok(()),
    }
}

/// Runs `work`; its last word is the answer. `hear` gets what it tells. Ctrl-C, and what `hear` raises,
/// end the call at once; the work ends when it next looks, and nothing is heard after that.
///
/// # Errors
/// What a signal or `hear` raises; a `RideError` if the work panics.
pub fn watched<T: Send + 'static, M: Send + 'static>(
    py: Python<'_>,
    mut hear: impl FnMut(Python<'_>, M) -> PyResult<()> + Send,
    work: impl FnOnce(&Teller<M>) -> T + Send + 'static,
) -> PyResult<T> {
    let stop = Arc::new(AtomicBool::new(false));
    let (told, hears) = channel();
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
            let message = hears.recv_timeout(LOOK_EVERY);
            let over = matches!(message, Err(RecvTimeoutError::Disconnected));
            let heard = Python::attach(|py| {
                py.check_signals()?;
                message.map_or(Ok(()), |message| hear(py, message))
            });
            if let Err(error) = heard {
                stop.store(true, Ordering::Relaxed);
                return Err(error);
            }
            if over {
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
