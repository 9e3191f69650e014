//! Messages read back from the columns of a log, bit for bit.
//!
//! Assumes and ignores: columns are `f64`, which holds every `f32` and `u32` exactly and integers
//! up to 2^53 (ride times of 104 days). Which NaN a NaN was is lost.

use crate::error::LogError;
use crate::reader::LogFile;
use twinhub_types::{Field, Message, NEVER_NS};

/// Every record of the tick topic `topic` as the message that was logged there.
///
/// # Errors
/// If the log has no such topic, or the topic lacks a column of the message.
pub fn messages<M: Message>(log: &LogFile, topic: &str) -> Result<Vec<M>, LogError> {
    let mut columns = Vec::new();
    gather(log, topic, M::FIELDS, "", &mut columns)?;
    let mut bytes = vec![0; M::SIZE];
    let read = |row| {
        let mut rest = &mut bytes[..];
        for (kind, values) in &columns {
            rest = put(rest, kind, values[row]);
        }
        M::get(&bytes).map(|(message, _)| message)
    };
    Ok((0..log.table(topic)?.len()).filter_map(read).collect())
}

/// Scalar type and values of every leaf, in wire order.
fn gather<'a>(
    log: &'a LogFile,
    topic: &str,
    fields: &[Field],
    prefix: &str,
    out: &mut Vec<(&'static str, &'a [f64])>,
) -> Result<(), LogError> {
    for field in fields {
        let name = format!("{prefix}{}", field.name);
        if !field.nested.is_empty() {
            gather(log, topic, field.nested, &format!("{name}."), out)?;
        } else if field.len == 1 {
            out.push((field.kind, log.column(topic, &name)?));
        } else {
            for index in 0..field.len {
                out.push((field.kind, log.column(topic, &format!("{name}.{index}"))?));
            }
        }
    }
    Ok(())
}

fn put<'a>(out: &'a mut [u8], kind: &str, value: f64) -> &'a mut [u8] {
    let bytes: &[u8] = match kind {
        "f32" => &(value as f32).to_le_bytes(),
        "u32" => &(value as u32).to_le_bytes(),
        _ if value.is_nan() => &NEVER_NS.to_le_bytes(),
        _ => &(value as u64).to_le_bytes(),
    };
    let (head, rest) = out.split_at_mut(bytes.len());
    head.copy_from_slice(bytes);
    rest
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::table::{Column, Table};
    use twinhub_types::{Measurement, Wire};

    #[test]
    fn a_measurement_comes_back_from_its_columns() {
        let mut sent = Measurement::default();
        sent.imu.stamp_ns = 12_345_000_000;
        sent.imu.gyro_rad_s = [0.1, -0.2, 1e-42];
        sent.wheels.reserved = 7;
        let mut columns = Vec::new();
        let mut bytes = vec![0; Measurement::SIZE];
        assert!(sent.put(&mut bytes).is_some());
        columns_of(Measurement::FIELDS, "", &mut &bytes[..], &mut columns);
        let table = Table {
            publish_time_ns: vec![0],
            columns,
            ..Table::default()
        };
        let log = LogFile {
            tables: [("t".to_owned(), table)].into(),
            ..LogFile::default()
        };
        assert_eq!(messages::<Measurement>(&log, "t").expect("whole"), [sent]);
        let error = messages::<twinhub_types::Output>(&log, "t").expect_err("another message");
        assert!(
            error.to_string().contains("command.front_brake_nm"),
            "{error}"
        );
    }

    fn columns_of(fields: &[Field], prefix: &str, bytes: &mut &[u8], out: &mut Vec<Column>) {
        for field in fields {
            let name = format!("{prefix}{}", field.name);
            if !field.nested.is_empty() {
                columns_of(field.nested, &format!("{name}."), bytes, out);
                continue;
            }
            for index in 0..field.len {
                let value = match field.kind {
                    "f32" => take::<4>(bytes, |b| f64::from(f32::from_le_bytes(b))),
                    "u32" => take::<4>(bytes, |b| f64::from(u32::from_le_bytes(b))),
                    _ => take::<8>(bytes, |b| match u64::from_le_bytes(b) {
                        NEVER_NS => f64::NAN,
                        ns => ns as f64,
                    }),
                };
                let name = if field.len == 1 {
                    name.clone()
                } else {
                    format!("{name}.{index}")
                };
                out.push(Column {
                    name,
                    values: vec![value],
                });
            }
        }
    }

    fn take<const N: usize>(bytes: &mut &[u8], value: impl Fn([u8; N]) -> f64) -> f64 {
        let (head, rest) = bytes.split_first_chunk().expect("long enough");
        *bytes = rest;
        value(*head)
    }
}
