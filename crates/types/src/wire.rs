//! Messages of fixed layout: integers and floats only, little endian, no padding, no value that
//! can be invalid. One declaration gives the memory layout (`repr(C)`), the bytes on a serial
//! line, the columns of a log and a hash that two processes compare before they talk.

/// One scalar of a message: dotted name (`measurement.imu.gyro_rad_s`), scalar type, length
/// (1, or the length of an array).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Field {
    /// Name as in the Rust source.
    pub name: &'static str,
    /// `u32`, `u64`, `f32`, or the name of a nested message.
    pub kind: &'static str,
    /// 1 for a scalar or a nested message, n for an array.
    pub len: usize,
    /// Fields of a nested message; empty for scalars.
    pub nested: &'static [Field],
}

/// Something with a fixed little-endian encoding.
pub trait Wire: Copy + Default {
    /// Bytes on the wire; equal to `size_of::<Self>()`.
    const SIZE: usize;
    /// Hash of names, types and order of everything inside.
    const LAYOUT_HASH: u64;
    /// Scalar type or message name.
    const KIND: &'static str;
    /// 1, or the length of an array.
    const LEN: usize;
    /// Fields of a message; empty for scalars.
    const FIELDS: &'static [Field];
    /// Writes the value to the front of `out` and returns the rest; `None` if `out` is too short.
    fn put<'a>(&self, out: &'a mut [u8]) -> Option<&'a mut [u8]>;
    /// Reads a value from the front of `bytes` and returns it with the rest; `None` if too short.
    fn get(bytes: &[u8]) -> Option<(Self, &[u8])>;
}

/// A message: a [`Wire`] struct declared by [`message!`](crate::message).
pub trait Message: Wire + PartialEq + core::fmt::Debug {}

/// FNV-1a over a string, continued from `hash`.
pub const fn hash_str(mut hash: u64, text: &str) -> u64 {
    let bytes = text.as_bytes();
    let mut i = 0;
    while i < bytes.len() {
        hash = (hash ^ bytes[i] as u64).wrapping_mul(0x100_0000_01b3);
        i += 1;
    }
    hash
}

/// FNV-1a over an integer, continued from `hash`.
pub const fn hash_u64(mut hash: u64, value: u64) -> u64 {
    let mut i = 0;
    while i < 8 {
        hash = (hash ^ ((value >> (8 * i)) & 0xff)).wrapping_mul(0x100_0000_01b3);
        i += 1;
    }
    hash
}

/// The offset basis of FNV-1a.
pub const HASH_START: u64 = 0xcbf2_9ce4_8422_2325;

macro_rules! scalar {
    ($($ty:ident),*) => {$(
        impl Wire for $ty {
            const SIZE: usize = core::mem::size_of::<$ty>();
            const LAYOUT_HASH: u64 = hash_str(HASH_START, stringify!($ty));
            const KIND: &'static str = stringify!($ty);
            const LEN: usize = 1;
            const FIELDS: &'static [Field] = &[];
            #[inline]
            fn put<'a>(&self, out: &'a mut [u8]) -> Option<&'a mut [u8]> {
                let (head, rest) = out.split_first_chunk_mut()?;
                *head = self.to_le_bytes();
                Some(rest)
            }
            #[inline]
            fn get(bytes: &[u8]) -> Option<(Self, &[u8])> {
                let (head, rest) = bytes.split_first_chunk()?;
                Some((Self::from_le_bytes(*head), rest))
            }
        }
    )*};
}
scalar!(u32, u64, f32);

impl Wire for [f32; 3] {
    const SIZE: usize = 12;
    const LAYOUT_HASH: u64 = hash_str(HASH_START, "[f32; 3]");
    const KIND: &'static str = "f32";
    const LEN: usize = 3;
    const FIELDS: &'static [Field] = &[];
    #[inline]
    fn put<'a>(&self, out: &'a mut [u8]) -> Option<&'a mut [u8]> {
        let rest = self[0].put(out)?;
        let rest = self[1].put(rest)?;
        self[2].put(rest)
    }
    #[inline]
    fn get(bytes: &[u8]) -> Option<(Self, &[u8])> {
        let (a, rest) = f32::get(bytes)?;
        let (b, rest) = f32::get(rest)?;
        let (c, rest) = f32::get(rest)?;
        Some(([a, b, c], rest))
    }
}

/// Declares a message: a `repr(C)` struct of integers, floats and other messages without padding.
///
/// A field list that would leave padding does not compile.
#[macro_export]
macro_rules! message {
    ($(#[$meta:meta])* pub struct $name:ident { $($(#[$fmeta:meta])* pub $field:ident : $ty:ty,)* }) => {
        $(#[$meta])*
        #[repr(C)]
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub struct $name { $($(#[$fmeta])* pub $field: $ty,)* }

        impl $crate::wire::Wire for $name {
            const SIZE: usize = {
                let sum = 0 $(+ <$ty as $crate::wire::Wire>::SIZE)*;
                assert!(sum == core::mem::size_of::<$name>(), "a message must have no padding");
                sum
            };
            const LAYOUT_HASH: u64 = {
                let hash = $crate::wire::hash_str($crate::wire::HASH_START, stringify!($name));
                $(
                    let hash = $crate::wire::hash_str(hash, stringify!($field));
                    let hash = $crate::wire::hash_u64(hash, <$ty as $crate::wire::Wire>::LAYOUT_HASH);
                )*
                hash
            };
            const KIND: &'static str = stringify!($name);
            const LEN: usize = 1;
            const FIELDS: &'static [$crate::wire::Field] = &[$(
                $crate::wire::Field {
                    name: stringify!($field),
                    kind: <$ty as $crate::wire::Wire>::KIND,
                    len: <$ty as $crate::wire::Wire>::LEN,
                    nested: <$ty as $crate::wire::Wire>::FIELDS,
                },
            )*];
            #[inline]
            fn put<'a>(&self, out: &'a mut [u8]) -> Option<&'a mut [u8]> {
                $(let out = $crate::wire::Wire::put(&self.$field, out)?;)*
                Some(out)
            }
            #[inline]
            fn get(bytes: &[u8]) -> Option<(Self, &[u8])> {
                $(let ($field, bytes) = <$ty as $crate::wire::Wire>::get(bytes)?;)*
                Some((Self { $($field,)* }, bytes))
            }
        }

        impl $crate::wire::Message for $name {}
    };
}
