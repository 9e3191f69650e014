//! `registry!`: one enum of named variants that all do the same job.

/// Declares a registry: an enum whose variants each hold a type that implements `$trait`.
///
/// The enum implements the trait itself by forwarding, lists its `NAMES`, and tells the name of
/// each value. The names are those in TOML files; derive serde with
/// `#[serde(rename_all = "snake_case")]` (externally tagged: typos keep their line and column).
/// No dynamic dispatch, no allocation.
///
/// ```
/// pub trait Shape { fn area_m2(&self, scale: f64) -> f64; }
/// pub struct Square(f64);
/// impl Shape for Square { fn area_m2(&self, scale: f64) -> f64 { scale * self.0 * self.0 } }
/// twinhub_types::registry! {
///     /// Shapes.
///     pub enum AnyShape: Shape {
///         /// A square.
///         Square(Square) = "square",
///     }
///     fn area_m2(&self, scale: f64) -> f64;
/// }
/// assert_eq!(AnyShape::NAMES, ["square"]);
/// assert_eq!(AnyShape::Square(Square(2.0)).area_m2(0.5), 2.0);
/// ```
#[macro_export]
macro_rules! registry {
    (
        $(#[$meta:meta])*
        $vis:vis enum $name:ident : $trait:path {
            $($(#[$vmeta:meta])* $variant:ident($ty:ty) = $text:literal,)*
        }
        $($methods:tt)*
    ) => {
        $(#[$meta])*
        $vis enum $name { $($(#[$vmeta])* $variant($ty),)* }

        impl $name {
            /// Names of all variants, in the order of declaration.
            pub const NAMES: &'static [&'static str] = &[$($text),*];

            /// The name of this variant.
            pub const fn name(&self) -> &'static str {
                match self { $(Self::$variant(_) => $text,)* }
            }
        }

        impl $trait for $name {
            $crate::registry!(@methods [$($variant)*] $($methods)*);
        }
    };
    (@methods $variants:tt) => {};
    (@methods $variants:tt
        fn $method:ident(&self $(, $arg:ident : $aty:ty)* $(,)?) $(-> $ret:ty)?; $($rest:tt)*) => {
        $crate::registry!(@method $variants (&self) $method ($($arg: $aty),*) ($($ret)?));
        $crate::registry!(@methods $variants $($rest)*);
    };
    (@methods $variants:tt
        fn $method:ident(&mut self $(, $arg:ident : $aty:ty)* $(,)?) $(-> $ret:ty)?; $($rest:tt)*) => {
        $crate::registry!(@method $variants (&mut self) $method ($($arg: $aty),*) ($($ret)?));
        $crate::registry!(@methods $variants $($rest)*);
    };
    (@methods $variants:tt
        fn $method:ident[$gen:ident : $bound:path](&self $(, $arg:ident : $aty:ty)* $(,)?) $(-> $ret:ty)?; $($rest:tt)*) => {
        $crate::registry!(@generic $variants $gen $bound, $method ($($arg: $aty),*) ($($ret)?));
        $crate::registry!(@methods $variants $($rest)*);
    };
    (@method [$($variant:ident)*] (&self) $method:ident ($($arg:ident : $aty:ty),*) ($($ret:ty)?)) => {
        #[inline]
        fn $method(&self $(, $arg: $aty)*) $(-> $ret)? {
            $crate::registry!(@match self, [$($variant)*], $method, ($($arg),*))
        }
    };
    (@method [$($variant:ident)*] (&mut self) $method:ident ($($arg:ident : $aty:ty),*) ($($ret:ty)?)) => {
        #[inline]
        fn $method(&mut self $(, $arg: $aty)*) $(-> $ret)? {
            $crate::registry!(@match self, [$($variant)*], $method, ($($arg),*))
        }
    };
    (@generic [$($variant:ident)*] $gen:ident $bound:path, $method:ident ($($arg:ident : $aty:ty),*) ($($ret:ty)?)) => {
        #[inline(always)]
        fn $method<$gen: $bound>(&self $(, $arg: $aty)*) $(-> $ret)? {
            $crate::registry!(@match self, [$($variant)*], $method, ($($arg),*))
        }
    };
    (@match $self:ident, [$($variant:ident)*], $method:ident, $args:tt) => {
        match $self { $(Self::$variant(inner) => $crate::registry!(@call inner $method $args),)* }
    };
    (@call $inner:ident $method:ident ($($arg:ident),*)) => { $inner.$method($($arg),*) };
}
