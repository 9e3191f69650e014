//! Thread time of pieces of work, interleaved, and their instructions under callgrind.

use std::process::Command;

/// Repetitions of every row.
pub const REPETITIONS: usize = 41;
/// Time that one repetition should take, s.
const BLOCK_S: f64 = 4.0e-3;

/// A piece of work: `run(count)` does it `count` times.
pub struct Row {
    pub name: &'static str,
    pub about: &'static str,
    /// Results that one call gives: SIMD lanes.
    pub results: usize,
    pub run: Box<dyn Fn(usize)>,
}

/// What a row took, per result.
#[derive(Clone, Copy, Default)]
pub struct Cost {
    pub least_ns: f64,
    pub median_ns: f64,
    pub instructions: Option<f64>,
}

/// Time that this thread has spent on a processor, s.
fn thread_time_s() -> f64 {
    let mut t = libc::timespec {
        tv_sec: 0,
        tv_nsec: 0,
    };
    // SAFETY: a valid clock and a valid place for its answer.
    unsafe { libc::clock_gettime(libc::CLOCK_THREAD_CPUTIME_ID, &mut t) };
    t.tv_sec as f64 + 1e-9 * t.tv_nsec as f64
}

fn timed(row: &Row, count: usize) -> f64 {
    let start = thread_time_s();
    (row.run)(count);
    thread_time_s() - start
}

/// Times all rows in turn, again and again, so that the machine's moods meet all of them.
pub fn times(rows: &[Row]) -> Vec<Cost> {
    let counts: Vec<usize> = rows
        .iter()
        .map(|row| {
            timed(row, 100);
            let once = timed(row, 400) / 400.0;
            ((BLOCK_S / once) as usize).max(1)
        })
        .collect();
    let mut each = vec![Vec::with_capacity(REPETITIONS); rows.len()];
    for _ in 0..REPETITIONS {
        for (k, row) in rows.iter().enumerate() {
            each[k].push(timed(row, counts[k]) * 1e9 / (counts[k] * row.results) as f64);
        }
    }
    each.into_iter()
        .map(|mut ns| {
            ns.sort_by(f64::total_cmp);
            Cost {
                least_ns: ns[0],
                median_ns: ns[ns.len() / 2],
                instructions: None,
            }
        })
        .collect()
}

/// Run lengths whose difference counts.
const SHORT: usize = 200;
const LONG: usize = 1200;

/// Whether valgrind is there.
pub fn valgrind_is_there() -> bool {
    Command::new("valgrind")
        .arg("--version")
        .output()
        .is_ok_and(|o| o.status.success())
}

/// Instructions per result of a row: this program runs itself under callgrind with two lengths.
pub fn instructions(name: &str, results: usize, arguments: &[String]) -> Result<f64, String> {
    let collected = |count: usize| -> Result<f64, String> {
        let program = std::env::current_exe().map_err(|e| e.to_string())?;
        let output = Command::new("valgrind")
            .args(["--tool=callgrind", "--callgrind-out-file=/dev/null"])
            .arg(program)
            .args(arguments)
            .args(["--repeat", name, &count.to_string()])
            .output()
            .map_err(|e| format!("valgrind: {e}"))?;
        let told = String::from_utf8_lossy(&output.stderr);
        let number = told
            .lines()
            .find_map(|line| line.split_once("Collected : "));
        number
            .and_then(|(_, n)| n.trim().parse().ok())
            .ok_or_else(|| format!("valgrind said: {told}"))
    };
    Ok((collected(LONG)? - collected(SHORT)?) / ((LONG - SHORT) * results) as f64)
}
