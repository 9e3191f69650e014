//! Rows kept as columns by name, or written as CSV.

use super::{Columns, Scenario, Summary, run};
use crate::error::RideError;
use std::io::{self, Write};

/// A run with all its rows.
#[derive(Clone, Debug)]
pub struct Recording {
    names: Vec<String>,
    columns: Vec<Vec<f64>>,
    /// What it came to.
    pub summary: Summary,
}

impl Recording {
    /// Names of the columns.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// A column by name.
    pub fn column(&self, name: &str) -> Option<&[f64]> {
        let k = self.names.iter().position(|n| n == name)?;
        Some(&self.columns[k])
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.columns.first().map_or(0, Vec::len)
    }
}

/// Runs a scenario and keeps every row; `watch` as in [`run`].
///
/// # Errors
/// As [`run`].
pub fn record(
    scenario: &Scenario,
    watch: &mut dyn FnMut(f64) -> bool,
) -> Result<Recording, RideError> {
    let (mut names, mut columns) = (Vec::new(), Vec::<Vec<f64>>::new());
    let summary = run(scenario, watch, &mut |head: &Columns, row| {
        if columns.is_empty() {
            names = head.names().to_vec();
            columns = vec![Vec::new(); names.len()];
        }
        for (column, value) in columns.iter_mut().zip(row) {
            column.push(*value);
        }
    })?;
    Ok(Recording {
        names,
        columns,
        summary,
    })
}

/// Runs a scenario and writes its rows as CSV: a line of names, then numbers that read back
/// without loss.
///
/// # Errors
/// As [`run`]; the inner result is that of writing.
pub fn write_csv(
    scenario: &Scenario,
    out: &mut dyn Write,
    watch: &mut dyn FnMut(f64) -> bool,
) -> Result<io::Result<Summary>, RideError> {
    let mut written = Ok(());
    let mut first = true;
    let failed = core::cell::Cell::new(false);
    let summary = run(
        scenario,
        &mut |share| !failed.get() && watch(share),
        &mut |head: &Columns, row| {
            if written.is_err() {
                return;
            }
            written = write_row(out, head, row, first);
            first = false;
            failed.set(written.is_err());
        },
    )?;
    Ok(written.and_then(|()| out.flush()).map(|()| summary))
}

fn write_row(out: &mut dyn Write, head: &Columns, row: &[f64], first: bool) -> io::Result<()> {
    if first {
        writeln!(out, "{}", head.names().join(","))?;
    }
    for (k, value) in row.iter().enumerate() {
        if k > 0 {
            out.write_all(b",")?;
        }
        write!(out, "{value:?}")?;
    }
    writeln!(out)
}
