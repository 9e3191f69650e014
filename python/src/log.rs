//! Logs as numpy columns.

use crate::errors;
use numpy::IntoPyArray;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use std::path::PathBuf;
use twinhub_log::{LogFile, Table};

/// Reads the log `path`.
#[pyfunction]
pub fn read_log(py: Python<'_>, path: PathBuf) -> PyResult<Bound<'_, PyDict>> {
    let log = py
        .detach(|| twinhub_log::read(&path))
        .map_err(|e| errors::log(&e))?;
    to_python(py, log)
}

/// Everything in a log; the columns are handed over, not copied.
pub fn to_python(py: Python<'_>, log: LogFile) -> PyResult<Bound<'_, PyDict>> {
    let stated_digest = log.stated_digest().map(str::to_owned);
    let config = log.config_text().map(str::to_owned);

    let topics = PyDict::new(py);
    for (topic, table) in log.tables {
        topics.set_item(topic, columns(py, table)?)?;
    }
    let texts = PyDict::new(py);
    for (topic, records) in log.texts {
        let records: Vec<_> = records
            .into_iter()
            .map(|r| (r.publish_time_ns as f64 * 1e-9, r.text))
            .collect();
        texts.set_item(topic, records)?;
    }
    let attachments = PyDict::new(py);
    for attachment in log.attachments {
        attachments.set_item(attachment.name, PyBytes::new(py, &attachment.data))?;
    }
    let recovery = log.recovery.map(|r| (r.used_bytes, r.lost_bytes, r.reason));

    let answer = PyDict::new(py);
    answer.set_item("topics", topics)?;
    answer.set_item("texts", texts)?;
    answer.set_item("undecoded", log.undecoded)?;
    answer.set_item("metadata", log.metadata)?;
    answer.set_item("attachments", attachments)?;
    answer.set_item("config", config)?;
    answer.set_item("recovery", recovery)?;
    answer.set_item("digest", log.digest)?;
    answer.set_item("stated_digest", stated_digest)?;
    Ok(answer)
}

/// Columns of a topic: `t_s`, when each sample was taken, then those of the schema. A schema's own
/// `t_s` (no topic of twinhub has one) is called `message.t_s`.
fn columns(py: Python<'_>, table: Table) -> PyResult<Bound<'_, PyDict>> {
    let columns = PyDict::new(py);
    columns.set_item("t_s", table.times_s().into_pyarray(py))?;
    for column in table.columns {
        let name = if column.name == "t_s" {
            "message.t_s"
        } else {
            &column.name
        };
        columns.set_item(name, column.values.into_pyarray(py))?;
    }
    Ok(columns)
}
