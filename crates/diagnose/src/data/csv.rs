//! CSV rides, plain or compressed with gzip: a header line, then one row a sample.

use super::table::{Column, Table};
use super::{DataError, time_column};
use crate::study::{Place, RideSpec, TimeSpec};
use std::io::Read;
use std::path::Path;
use std::rc::Rc;

/// Beyond this a file is no ride: 1 GB of text, ten million rows.
const MOST_BYTES: u64 = 1 << 30;
const MOST_ROWS: usize = 10_000_000;

pub fn read(spec: &RideSpec, path: &Path) -> Result<Table, DataError> {
    let file = std::fs::File::open(path).map_err(|source| DataError::Read {
        path: path.to_owned(),
        source,
    })?;
    let reader: Box<dyn Read> = match path.extension().is_some_and(|e| e == "gz") {
        true => Box::new(flate2::read::MultiGzDecoder::new(std::io::BufReader::new(
            file,
        ))),
        false => Box::new(file),
    };
    from_reader(spec, path, reader)
}

fn from_reader(spec: &RideSpec, path: &Path, reader: impl Read) -> Result<Table, DataError> {
    let mut csv = csv::ReaderBuilder::new()
        .trim(csv::Trim::All)
        .from_reader(reader.take(MOST_BYTES));
    let header = csv.headers().map_err(|e| row_error(path, &e))?.clone();
    let names: Vec<String> = header
        .iter()
        .map(|h| h.trim_start_matches('\u{feff}').to_owned())
        .collect();
    let index = |column: &str, place: &Place| -> Result<usize, DataError> {
        let found: Vec<usize> = (0..names.len()).filter(|i| names[*i] == column).collect();
        match found[..] {
            [one] => Ok(one),
            [] => Err(DataError::Column {
                place: place.clone(),
                path: path.to_owned(),
                column: column.to_owned(),
                available: names.clone(),
            }),
            _ => Err(DataError::File {
                path: path.to_owned(),
                found: format!("{} columns named `{column}`", found.len()),
                accepted: "each column name once".to_owned(),
            }),
        }
    };
    let time = time_column(spec)
        .map(|name| index(name, &spec.place))
        .transpose()?;
    let wanted = spec
        .channels
        .iter()
        .map(|c| index(&c.column, &c.place))
        .collect::<Result<Vec<_>, _>>()?;
    let mut times_s: Vec<f64> = vec![];
    let mut values: Vec<Vec<f64>> = vec![vec![]; wanted.len()];
    let mut record = csv::StringRecord::new();
    while csv
        .read_record(&mut record)
        .map_err(|e| row_error(path, &e))?
    {
        let line = record.position().map_or(0, |p| p.line());
        let cell = |column: usize| -> Result<f64, DataError> {
            let text = record.get(column).unwrap_or("");
            if text.is_empty() || text.eq_ignore_ascii_case("nan") {
                return Ok(f64::NAN);
            }
            match text.parse::<f64>() {
                Ok(x) if x.is_finite() => Ok(x),
                _ => Err(DataError::Cell {
                    path: path.to_owned(),
                    line,
                    column: names[column].clone(),
                    found: text.to_owned(),
                }),
            }
        };
        let refuse = |found: String, accepted: &str| {
            Err(DataError::Row {
                path: path.to_owned(),
                line,
                found,
                accepted: accepted.to_owned(),
            })
        };
        let t = match (time, &spec.time) {
            (Some(column), _) => cell(column)?,
            (None, TimeSpec::RateHz(rate)) => times_s.len() as f64 / rate,
            (None, _) => f64::NAN,
        };
        if t.is_nan() {
            return refuse(
                format!("no time in column {}", time_column(spec).unwrap_or("")),
                "a time in every row",
            );
        }
        if let Some(before) = times_s.last()
            && t <= *before
        {
            return refuse(format!("time {t} s after {before} s"), "times that ascend");
        }
        if times_s.len() >= MOST_ROWS {
            return refuse("too many rows".to_owned(), "ten million rows");
        }
        times_s.push(t);
        for (column, list) in wanted.iter().zip(&mut values) {
            list.push(cell(*column)?);
        }
    }
    if times_s.len() < 2 {
        return Err(DataError::File {
            path: path.to_owned(),
            found: format!("{} rows", times_s.len()),
            accepted: "a header and at least two rows".to_owned(),
        });
    }
    let times_s = Rc::new(times_s);
    Ok(Table {
        columns: values
            .into_iter()
            .map(|values| Column {
                times_s: times_s.clone(),
                values,
            })
            .collect(),
    })
}

fn row_error(path: &Path, error: &csv::Error) -> DataError {
    let line = error.position().map_or(1, |p| p.line());
    match error.kind() {
        csv::ErrorKind::UnequalLengths {
            expected_len, len, ..
        } => DataError::Row {
            path: path.to_owned(),
            line,
            found: format!("{len} cells"),
            accepted: format!("{expected_len}, as in the header"),
        },
        csv::ErrorKind::Io(source) => DataError::Read {
            path: path.to_owned(),
            source: std::io::Error::new(source.kind(), source.to_string()),
        },
        _ => DataError::Row {
            path: path.to_owned(),
            line,
            found: error.to_string(),
            accepted: "CSV in UTF-8".to_owned(),
        },
    }
}
