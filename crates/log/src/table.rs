//! Columns of a topic, decoded straight from the CDR bytes.

use twinhub_types::NEVER_NS;

use crate::schema::{ENCAPSULATION, Layout, Scalar};

/// One scalar of a topic over the ride.
#[derive(Clone, Debug, PartialEq)]
pub struct Column {
    /// Dotted name: `estimate.roll_rad`; elements of arrays are numbered: `imu.gyro_rad_s.0`.
    pub name: String,
    /// One value for each record. Integers are rounded to the nearest `f64`; the stamp of a
    /// sample that was never taken is NaN.
    pub values: Vec<f64>,
}

/// A tick topic: times and columns, all of the same length.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Table {
    /// Name of the schema: `twinhub_msgs/msg/Output`.
    pub schema_name: String,
    /// True if its records enter the digest.
    pub digested: bool,
    /// When each sample was taken, ns of ride time.
    pub publish_time_ns: Vec<u64>,
    /// When each sample was written, ns of ride time.
    pub log_time_ns: Vec<u64>,
    /// The columns in the order of the schema.
    pub columns: Vec<Column>,
}

impl Table {
    /// Number of records.
    pub fn len(&self) -> usize {
        self.publish_time_ns.len()
    }

    /// True if the topic has no record.
    pub fn is_empty(&self) -> bool {
        self.publish_time_ns.is_empty()
    }

    /// When each sample was taken, s of ride time.
    pub fn times_s(&self) -> Vec<f64> {
        self.publish_time_ns
            .iter()
            .map(|&ns| ns as f64 * 1e-9)
            .collect()
    }

    /// The values of column `name`.
    pub fn column(&self, name: &str) -> Option<&[f64]> {
        self.columns
            .iter()
            .find(|column| column.name == name)
            .map(|column| &column.values[..])
    }
}

/// A record of a JSON topic.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TextRecord {
    /// When it happened, ns of ride time.
    pub publish_time_ns: u64,
    /// When it was written, ns of ride time.
    pub log_time_ns: u64,
    /// The JSON text.
    pub text: String,
}

/// Records that fit into the cache while all their columns are decoded.
const BLOCK: usize = 128;

/// Decodes `payloads`, each at least `layout.size` bytes with its encapsulation.
pub(crate) fn decode(layout: &Layout, payloads: &[&[u8]]) -> Vec<Column> {
    let mut columns: Vec<Column> = layout
        .places
        .iter()
        .map(|place| Column {
            name: place.name.clone(),
            values: Vec::with_capacity(payloads.len()),
        })
        .collect();
    for block in payloads.chunks(BLOCK) {
        for (place, column) in layout.places.iter().zip(&mut columns) {
            let at = ENCAPSULATION.len() + place.offset;
            let out = &mut column.values;
            match place.scalar {
                Scalar::F64 => scalars(block, at, out, f64::from_le_bytes),
                Scalar::F32 => scalars(block, at, out, |b| f64::from(f32::from_le_bytes(b))),
                Scalar::U64 => scalars(block, at, out, |b| match u64::from_le_bytes(b) {
                    NEVER_NS => f64::NAN,
                    value => value as f64,
                }),
                Scalar::I64 => scalars(block, at, out, |b| i64::from_le_bytes(b) as f64),
                Scalar::U32 => scalars(block, at, out, |b| f64::from(u32::from_le_bytes(b))),
                Scalar::I32 => scalars(block, at, out, |b| f64::from(i32::from_le_bytes(b))),
                Scalar::U16 => scalars(block, at, out, |b| f64::from(u16::from_le_bytes(b))),
                Scalar::I16 => scalars(block, at, out, |b| f64::from(i16::from_le_bytes(b))),
                Scalar::U8 | Scalar::Bool => scalars(block, at, out, |[b]| f64::from(b)),
                Scalar::I8 => scalars(block, at, out, |b| f64::from(i8::from_le_bytes(b))),
            }
        }
    }
    columns
}

#[inline]
fn scalars<const N: usize>(
    block: &[&[u8]],
    at: usize,
    out: &mut Vec<f64>,
    value: impl Fn([u8; N]) -> f64,
) {
    out.extend(block.iter().map(|payload| {
        payload
            .get(at..at + N)
            .and_then(|b| b.try_into().ok())
            .map_or(f64::NAN, &value)
    }));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::schema::layout;

    #[test]
    fn every_scalar_type_comes_back() {
        let layout = layout(
            "float64 a\nfloat32 b\nuint32 c\nuint64 d\nint8 e\nint16 f\nbool g\nint64 h\nint32 i\nuint16 j\nuint8 k\nuint64 never\n",
        )
        .expect("fixed");
        let mut bytes = vec![0u8; layout.size];
        bytes[1] = 1;
        let mut put = |name: &str, value: &[u8]| {
            let place = layout
                .places
                .iter()
                .find(|p| p.name == name)
                .expect("place");
            bytes[4 + place.offset..][..value.len()].copy_from_slice(value);
        };
        put("a", &(-1.5f64).to_le_bytes());
        put("b", &0.25f32.to_le_bytes());
        put("c", &4_000_000_000u32.to_le_bytes());
        put("d", &(1u64 << 40).to_le_bytes());
        put("e", &(-5i8).to_le_bytes());
        put("f", &(-300i16).to_le_bytes());
        put("g", &[1]);
        put("h", &(-7i64).to_le_bytes());
        put("i", &(-8i32).to_le_bytes());
        put("j", &60_000u16.to_le_bytes());
        put("k", &[200]);
        put("never", &u64::MAX.to_le_bytes());
        let payloads = vec![&bytes[..]; BLOCK + 3];
        let columns = decode(&layout, &payloads);
        let last: Vec<f64> = columns.iter().map(|c| c.values[BLOCK + 2]).collect();
        let expected = [
            -1.5,
            0.25,
            4e9,
            1_099_511_627_776.0,
            -5.0,
            -300.0,
            1.0,
            -7.0,
            -8.0,
            60_000.0,
            200.0,
        ];
        assert_eq!(last[..11], expected);
        assert!(last[11].is_nan());
        assert!(columns.iter().all(|c| c.values.len() == BLOCK + 3));
    }
}
