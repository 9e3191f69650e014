//! The columns that a study names, each with its times.

use super::DataError;
use crate::study::RideSpec;
use std::path::Path;
use std::rc::Rc;

/// One column; NaN where a value is missing.
pub struct Column {
    pub times_s: Rc<Vec<f64>>,
    pub values: Vec<f64>,
}

/// One column a channel, in the order of the study.
pub struct Table {
    pub columns: Vec<Column>,
}

/// From an MCAP log: columns are named "/topic:field", and every topic has its own sample times.
pub fn from_log(spec: &RideSpec, path: &Path) -> Result<Table, DataError> {
    let log = twinhub_log::read(path)?;
    let columns = spec.channels.iter().map(|channel| {
        let available = || {
            let all = log.tables.iter().flat_map(|(topic, t)| {
                t.columns.iter().map(move |c| format!("{topic}:{}", c.name))
            });
            all.collect::<Vec<_>>()
        };
        let found = channel.column.split_once(':').and_then(|(topic, field)| {
            let table = log.tables.get(topic)?;
            Some((table, table.column(field)?))
        });
        let Some((table, values)) = found else {
            return Err(DataError::Column {
                place: channel.place.clone(),
                path: path.to_owned(),
                column: channel.column.clone(),
                available: available(),
            });
        };
        let values = values
            .iter()
            .map(|v| if v.is_finite() { *v } else { f64::NAN })
            .collect();
        Ok(Column {
            times_s: Rc::new(table.times_s()),
            values,
        })
    });
    Ok(Table {
        columns: columns.collect::<Result<_, _>>()?,
    })
}
