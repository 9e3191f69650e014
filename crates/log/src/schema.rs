//! `ros2msg` schemas: written from declarations, and read back into byte layouts.
//!
//! Equation: CDR (OMG DDS-XTypes 1.3, 7.4.1), little endian: 4 bytes of encapsulation
//! (`00 01 00 00`), then every scalar at the next multiple of its own size, counted from the end
//! of the encapsulation; a fixed array is its elements in a row; a nested message has no
//! alignment of its own.
//! Assumes and ignores: messages of fixed size. A schema with strings or sequences has no
//! columns.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use twinhub_types::Field;

/// The package that the schema names stand in.
pub(crate) const PACKAGE: &str = "twinhub_msgs";

/// Encapsulation of plain little-endian CDR.
pub(crate) const ENCAPSULATION: [u8; 4] = [0, 1, 0, 0];

const RULE: &str =
    "================================================================================";

/// Full name of the schema of `name`.
pub(crate) fn schema_name(name: &str) -> String {
    format!("{PACKAGE}/msg/{name}")
}

/// Schema of a row of `f64` columns.
pub fn row_schema(columns: &[&str]) -> String {
    columns
        .iter()
        .map(|column| format!("float64 {column}\n"))
        .collect()
}

/// Schema of a message, nested messages appended.
pub(crate) fn message_schema(fields: &'static [Field]) -> String {
    let mut text = String::new();
    let mut nested: Vec<(&str, &[Field])> = Vec::new();
    put_fields(fields, &mut text, &mut nested);
    let mut next = 0;
    while let Some(&(name, fields)) = nested.get(next) {
        let _ = write!(text, "{RULE}\nMSG: {PACKAGE}/{name}\n");
        put_fields(fields, &mut text, &mut nested);
        next += 1;
    }
    text
}

fn put_fields(
    fields: &'static [Field],
    text: &mut String,
    nested: &mut Vec<(&'static str, &'static [Field])>,
) {
    for field in fields {
        let kind = match field.kind {
            "u32" => "uint32".to_string(),
            "u64" => "uint64".to_string(),
            "f32" => "float32".to_string(),
            "f64" => "float64".to_string(),
            message => {
                if nested.iter().all(|(name, _)| *name != message) {
                    nested.push((message, field.nested));
                }
                format!("{PACKAGE}/{message}")
            }
        };
        let length = if field.len == 1 {
            String::new()
        } else {
            format!("[{}]", field.len)
        };
        let _ = writeln!(text, "{kind}{length} {}", field.name);
    }
}

/// A scalar type of CDR.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Scalar {
    Bool,
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    F32,
    F64,
}

impl Scalar {
    fn of(name: &str) -> Option<Self> {
        Some(match name {
            "bool" => Self::Bool,
            "int8" => Self::I8,
            "uint8" | "byte" | "char" => Self::U8,
            "int16" => Self::I16,
            "uint16" => Self::U16,
            "int32" => Self::I32,
            "uint32" => Self::U32,
            "int64" => Self::I64,
            "uint64" => Self::U64,
            "float32" => Self::F32,
            "float64" => Self::F64,
            _ => return None,
        })
    }

    const fn size(self) -> usize {
        match self {
            Self::Bool | Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::I64 | Self::U64 | Self::F64 => 8,
        }
    }
}

/// One scalar of a record: where it stands and what it is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Place {
    /// Dotted name; elements of arrays are numbered: `imu.gyro_rad_s.0`.
    pub name: String,
    pub scalar: Scalar,
    /// Bytes after the encapsulation.
    pub offset: usize,
}

/// Where every scalar of a record stands.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Layout {
    pub places: Vec<Place>,
    /// Bytes of the payload, with the encapsulation.
    pub size: usize,
}

/// Columns that a schema may have; more is taken for damage.
const PLACES_MAX: usize = 4096;
/// Fields that are looked at, empty messages included.
const STEPS_MAX: usize = 4 * PLACES_MAX;
/// Depth that messages may nest to.
const DEPTH_MAX: usize = 16;

/// The layout that a `ros2msg` text describes, or why it has none.
pub(crate) fn layout(text: &str) -> Result<Layout, String> {
    let mut messages: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    let mut current = "";
    messages.insert(current, Vec::new());
    for line in text.lines() {
        let line = line.split('#').next().unwrap_or("").trim();
        if line.is_empty() || line.starts_with("===") {
            continue;
        }
        if let Some(name) = line.strip_prefix("MSG:") {
            current = name.trim();
            messages.entry(current).or_default();
        } else if let Some(lines) = messages.get_mut(current) {
            lines.push(line);
        }
    }
    let mut layout = Layout::default();
    let (mut end, mut steps) = (0, 0);
    place(
        &messages,
        "",
        "",
        (0, &mut steps),
        &mut end,
        &mut layout.places,
    )?;
    layout.size = ENCAPSULATION.len() + end;
    Ok(layout)
}

fn place(
    messages: &BTreeMap<&str, Vec<&str>>,
    message: &str,
    prefix: &str,
    (depth, steps): (usize, &mut usize),
    end: &mut usize,
    places: &mut Vec<Place>,
) -> Result<(), String> {
    if depth > DEPTH_MAX {
        return Err(format!("messages nest more than {DEPTH_MAX} deep"));
    }
    let lines = messages
        .get(message)
        .ok_or_else(|| format!("`{message}` is not defined"))?;
    for line in lines {
        let mut words = line.split_whitespace();
        let (Some(kind), Some(name)) = (words.next(), words.next()) else {
            return Err(format!("cannot read `{line}`"));
        };
        if name.contains('=') || words.next().is_some_and(|word| word.starts_with('=')) {
            continue; // a constant takes no bytes
        }
        let (kind, length) = match kind.split_once('[') {
            None => (kind, None),
            Some((kind, rest)) => match rest.strip_suffix(']').map(str::parse::<usize>) {
                Some(Ok(length)) => (kind, Some(length)),
                _ => return Err(format!("`{line}` has no fixed size")),
            },
        };
        for index in 0..length.unwrap_or(1) {
            *steps += 1;
            if *steps > STEPS_MAX {
                return Err(format!("more than {STEPS_MAX} fields"));
            }
            let name = match length {
                None => format!("{prefix}{name}"),
                Some(_) => format!("{prefix}{name}.{index}"),
            };
            if let Some(scalar) = Scalar::of(kind) {
                if places.len() >= PLACES_MAX {
                    return Err(format!("more than {PLACES_MAX} columns"));
                }
                let offset = end.next_multiple_of(scalar.size());
                *end = offset + scalar.size();
                places.push(Place {
                    name,
                    scalar,
                    offset,
                });
            } else if kind == "string" || kind == "wstring" || kind.contains("<=") {
                return Err(format!("`{line}` has no fixed size"));
            } else {
                let nested = resolve(messages, kind)
                    .ok_or_else(|| format!("`{line}`: `{kind}` is not defined"))?;
                place(
                    messages,
                    nested,
                    &format!("{name}."),
                    (depth + 1, &mut *steps),
                    end,
                    places,
                )?;
            }
        }
    }
    Ok(())
}

/// The key of the message that `kind` means: `pkg/Name`, `pkg/msg/Name` or `Name`.
fn resolve<'a>(messages: &BTreeMap<&'a str, Vec<&str>>, kind: &str) -> Option<&'a str> {
    let last = kind.rsplit('/').next()?;
    messages
        .keys()
        .find(|key| **key == kind)
        .or_else(|| {
            messages
                .keys()
                .find(|key| !key.is_empty() && key.rsplit('/').next() == Some(last))
        })
        .copied()
}

#[cfg(test)]
mod tests {
    use super::*;
    use twinhub_types::{Measurement, Output, Wire};

    #[test]
    fn the_layout_of_a_message_is_its_memory() {
        let layout = layout(&message_schema(Measurement::FIELDS)).expect("own schema");
        assert_eq!(layout.size, 4 + Measurement::SIZE);
        let find = |name: &str| {
            layout
                .places
                .iter()
                .find(|p| p.name == name)
                .unwrap_or_else(|| panic!("{name}"))
                .offset
        };
        assert_eq!(find("imu.stamp_ns"), 0);
        assert_eq!(find("imu.gyro_rad_s.2"), 16);
        assert_eq!(
            find("motors.bus_v"),
            std::mem::offset_of!(Measurement, motors)
                + std::mem::offset_of!(twinhub_types::MotorSample, bus_v)
        );
    }

    #[test]
    fn a_nested_message_is_defined_once() {
        let text = message_schema(Output::FIELDS);
        assert_eq!(text.matches("MSG: twinhub_msgs/Estimate").count(), 1);
        assert!(
            text.starts_with("twinhub_msgs/Command command\nfloat32 demand_nm\n"),
            "{text}"
        );
    }

    #[test]
    fn scalars_are_aligned_to_their_size() {
        let layout = layout("uint8 a\nfloat64 b # comment\nuint8[3] c\nint16 d\nint32 K=5\n")
            .expect("fixed");
        let offsets: Vec<_> = layout.places.iter().map(|p| p.offset).collect();
        assert_eq!(offsets, [0, 8, 16, 17, 18, 20]);
        assert_eq!(layout.size, 4 + 22);
    }

    #[test]
    fn what_has_no_fixed_size_is_refused() {
        for text in [
            "string s",
            "float64[] x",
            "Foo foo",
            "float64",
            "uint8[9999] x",
            "float64[<=3] y",
        ] {
            assert!(layout(text).is_err(), "{text}");
        }
        let endless = "A a\n===\nMSG: p/A\nA a\n";
        assert!(layout(endless).is_err());
    }
}
