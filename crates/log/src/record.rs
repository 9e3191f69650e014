//! What a tick topic holds: a message of the shared vocabulary, or a row of plain numbers.

use twinhub_types::wire::Message;

use crate::schema;

/// Something that a tick topic can hold: fixed size, with a `ros2msg` schema.
///
/// Every [`twinhub_types::Message`] is one; [`row!`](crate::row) declares others.
pub trait Record {
    /// Name of the schema, without package: `TruthRow`.
    const NAME: &'static str;
    /// Bytes of the payload, without the 4 bytes of CDR encapsulation.
    const SIZE: usize;
    /// The `ros2msg` text.
    fn schema() -> String;
    /// Appends exactly [`SIZE`](Self::SIZE) bytes, little endian, each scalar aligned to its size.
    fn put(&self, out: &mut Vec<u8>);
}

// A message has no padding, so every scalar lies at a multiple of its own size: its wire bytes
// are its CDR bytes.
impl<T: Message> Record for T {
    const NAME: &'static str = T::KIND;
    const SIZE: usize = T::SIZE;

    fn schema() -> String {
        schema::message_schema(T::FIELDS)
    }

    #[inline]
    fn put(&self, out: &mut Vec<u8>) {
        let start = out.len();
        out.resize(start + T::SIZE, 0);
        let written = twinhub_types::Wire::put(self, &mut out[start..]).is_some();
        debug_assert!(written, "SIZE bytes hold the message");
    }
}

/// A row of plain `f64` columns; declared with [`row!`](crate::row).
pub trait Row: Copy + Default {
    /// Column names, each ending in its unit.
    const COLUMNS: &'static [&'static str];
    /// Writes the values in the order of [`COLUMNS`](Self::COLUMNS); `out` is as long as it.
    fn values(&self, out: &mut [f64]);
}

/// Endings that say the unit of a column.
const UNITS: &[&str] = &[
    "_rad", "_rad_s", "_rad_s2", "_m", "_m_s", "_m_s2", "_n", "_n_m", "_nm", "_nm_s", "_nm_rad",
    "_kg", "_kg_m2", "_s", "_ns", "_us", "_hz", "_v", "_a", "_w", "_j", "_pa", "_celsius",
    "_ratio", "_gain", "_count", "_flag",
];

/// True if `name` ends in a unit (`_flag` is 0 or 1, `_count` a whole number).
pub const fn has_unit(name: &str) -> bool {
    let name = name.as_bytes();
    let mut i = 0;
    while i < UNITS.len() {
        let unit = UNITS[i].as_bytes();
        if name.len() > unit.len() {
            let mut k = 0;
            while k < unit.len() && name[name.len() - unit.len() + k] == unit[k] {
                k += 1;
            }
            if k == unit.len() {
                return true;
            }
        }
        i += 1;
    }
    false
}

/// Appends `values` as CDR bytes.
#[inline]
pub fn put_row<const N: usize>(values: [f64; N], out: &mut Vec<u8>) {
    let start = out.len();
    out.resize(start + 8 * N, 0);
    for (slot, value) in out[start..].chunks_exact_mut(8).zip(values) {
        slot.copy_from_slice(&value.to_le_bytes());
    }
}

/// Declares a row of `f64` columns that a tick topic can hold.
///
/// Every name ends in its unit (see [`has_unit`]); one that does not fails to compile.
///
/// ```
/// twinhub_log::row! {
///     /// Where the bicycle is.
///     pub struct Place {
///         /// Forward, m.
///         x_m,
///         /// To the right, m.
///         y_m,
///     }
/// }
/// use twinhub_log::Row;
/// assert_eq!(Place::COLUMNS, ["x_m", "y_m"]);
/// let mut values = [0.0; 2];
/// Place { x_m: 1.0, y_m: 2.0 }.values(&mut values);
/// assert_eq!(values, [1.0, 2.0]);
/// ```
///
/// ```compile_fail
/// twinhub_log::row! { pub struct Place { x, } }
/// ```
#[macro_export]
macro_rules! row {
    ($(#[$meta:meta])* $vis:vis struct $name:ident { $($(#[$fmeta:meta])* $field:ident),* $(,)? }) => {
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, Default, PartialEq)]
        $vis struct $name { $($(#[$fmeta])* pub $field: f64,)* }

        const _: () = {
            $(assert!($crate::has_unit(stringify!($field)), concat!(
                "the name of column `", stringify!($field), "` does not end in a unit"));)*
        };

        impl $crate::Row for $name {
            const COLUMNS: &'static [&'static str] = &[$(stringify!($field)),*];
            #[inline]
            fn values(&self, out: &mut [f64]) {
                out.copy_from_slice(&[$(self.$field),*]);
            }
        }

        impl $crate::Record for $name {
            const NAME: &'static str = stringify!($name);
            const SIZE: usize = 8 * <Self as $crate::Row>::COLUMNS.len();
            fn schema() -> String {
                $crate::row_schema(<Self as $crate::Row>::COLUMNS)
            }
            #[inline]
            fn put(&self, out: &mut Vec<u8>) {
                $crate::put_row([$(self.$field),*], out);
            }
        }
    };
}

#[cfg(test)]
mod tests {
    use super::*;

    row! {
        /// Two numbers.
        struct Two { angle_rad, speed_m_s }
    }

    #[test]
    fn a_name_without_a_unit_is_noticed() {
        assert!(has_unit("roll_rad") && has_unit("roll_rate_rad_s") && has_unit("wind_m_s"));
        assert!(!has_unit("roll") && !has_unit("roll_deg") && !has_unit("_rad") && !has_unit(""));
    }

    #[test]
    fn a_row_is_its_values_in_little_endian() {
        let mut out = vec![9];
        Two {
            angle_rad: 0.5,
            speed_m_s: -2.0,
        }
        .put(&mut out);
        assert_eq!(out.len(), 1 + Two::SIZE);
        assert_eq!(out[1..9], 0.5f64.to_le_bytes());
        assert_eq!(out[9..17], (-2.0f64).to_le_bytes());
        assert_eq!(Two::schema(), "float64 angle_rad\nfloat64 speed_m_s\n");
    }
}
