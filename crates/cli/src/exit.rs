//! Exit codes: 0 done, 1 the bicycle fell or a gate failed, 2 bad input, 3 the environment cannot
//! (no shared memory, a process died), 130 interrupted.

use std::process::ExitCode;

/// An error with the exit code that it ends the program with.
#[derive(Debug)]
struct Coded {
    code: u8,
    source: anyhow::Error,
}

impl std::fmt::Display for Coded {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}", self.source)
    }
}

impl std::error::Error for Coded {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        self.source.source()
    }
}

/// The bicycle fell, or a gate failed.
pub const FELL: u8 = 1;
/// The input is wrong.
pub const BAD_INPUT: u8 = 2;
/// The environment cannot.
pub const ENVIRONMENT: u8 = 3;
/// Interrupted by the user.
pub const INTERRUPTED: u8 = 130;

fn coded(code: u8, error: impl Into<anyhow::Error>) -> anyhow::Error {
    anyhow::Error::new(Coded {
        code,
        source: error.into(),
    })
}

/// Marks `error` as the user's: exit code 2.
pub fn bad_input(error: impl Into<anyhow::Error>) -> anyhow::Error {
    coded(BAD_INPUT, error)
}

/// Marks `error` as the machine's: exit code 3.
pub fn environment(error: impl Into<anyhow::Error>) -> anyhow::Error {
    coded(ENVIRONMENT, error)
}

/// Marks `error` as the user's wish to stop: exit code 130.
pub fn interrupted(error: impl Into<anyhow::Error>) -> anyhow::Error {
    coded(INTERRUPTED, error)
}

/// Prints `error` with its causes and gives its exit code; an unmarked error counts as the
/// machine's.
pub fn report(error: &anyhow::Error) -> ExitCode {
    let mut last = error.to_string();
    eprintln!("error: {last}");
    for cause in error.chain().skip(1) {
        let text = cause.to_string();
        if !last.contains(&text) {
            eprintln!("  because: {text}");
        }
        last = text;
    }
    let code = error
        .chain()
        .find_map(|e| e.downcast_ref::<Coded>())
        .map_or(ENVIRONMENT, |e| e.code);
    ExitCode::from(code)
}
