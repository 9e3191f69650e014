//! What can be wrong with a bicycle.

use std::path::PathBuf;

/// A bicycle that cannot be loaded, or that cannot exist.
#[non_exhaustive]
#[derive(Debug, thiserror::Error)]
pub enum BicycleError {
    /// Neither a built-in set nor a file.
    #[error(
        "no bicycle `{found}`: it is neither a built-in set ({}) nor an existing file \
         (a bicycle `.toml`, or a BicycleParameters `*Benchmark.txt`)",
        crate::sets::NAMES.join(", ")
    )]
    UnknownBicycle {
        /// What was asked for.
        found: String,
    },
    /// A built-in set has no such option or value.
    #[error("built-in set `{set}`: option `{found}` is not known; accepted: {accepted}")]
    UnknownOption {
        /// The set.
        set: String,
        /// The option as given.
        found: String,
        /// What the set offers.
        accepted: String,
    },
    /// The file cannot be read.
    #[error("cannot read bicycle file {}: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// One line of a file is wrong.
    #[error("{}, line {line}, key `{key}`: found `{found}`, accepted: {accepted}", path.display())]
    Line {
        /// The file.
        path: PathBuf,
        /// Counted from 1.
        line: usize,
        /// The key, empty if there is none.
        key: String,
        /// The text found.
        found: String,
        /// What would be accepted.
        accepted: String,
    },
    /// Keys are missing in a file.
    #[error("{}: missing keys: {}{hint}", path.display(), keys.join(", "))]
    Missing {
        /// The file.
        path: PathBuf,
        /// The keys.
        keys: Vec<&'static str>,
        /// How to mend it.
        hint: String,
    },
    /// What stands after `+` is a whole bicycle.
    #[error(
        "`{found}` is a whole bicycle; after `+`, accepted: a rider's file with mB, xB, zB, IBxx, \
         IByy, IBzz, IBxz and no other of the bicycle's keys"
    )]
    NotARider {
        /// As given.
        found: String,
    },
    /// A bicycle TOML file is malformed.
    #[error("{}: {message}", path.display())]
    Toml {
        /// The file.
        path: PathBuf,
        /// The parser's message with line and column.
        message: String,
    },
    /// No parameter has this symbol.
    #[error("no parameter `{found}`{hint}; accepted: {}", crate::SYMBOLS.join(", "))]
    UnknownSymbol {
        /// As given.
        found: String,
        /// Suggestion.
        hint: String,
    },
    /// `KEY=VALUE` is not that, or its value is not a number.
    #[error("`{found}`: accepted is SYMBOL=NUMBER, for instance IBxx=9.2")]
    Assignment {
        /// As given.
        found: String,
    },
    /// A value lies outside what is possible.
    #[error("parameter `{symbol}` = {value}: accepted: {accepted}")]
    Value {
        /// The symbol.
        symbol: String,
        /// The value found.
        value: f64,
        /// What would be accepted.
        accepted: &'static str,
    },
    /// A moment of inertia that no body has.
    #[error("inertia of {body}: {what}; accepted: {accepted}")]
    Inertia {
        /// Which body.
        body: &'static str,
        /// What is wrong, with figures.
        what: String,
        /// What would be accepted.
        accepted: &'static str,
    },
    /// The mass matrix cannot be inverted.
    #[error(
        "the mass matrix of `{bicycle}` is singular (reciprocal condition {rcond:.1e}, accepted: \
         at least 1e-13): roll and steer have no separate inertia, so there are no four modes"
    )]
    SingularMass {
        /// Name of the bicycle.
        bicycle: String,
        /// Reciprocal condition number.
        rcond: f64,
    },
    /// A file with a problem in its values.
    #[error("{}: {source}", path.display())]
    InFile {
        /// The file.
        path: PathBuf,
        /// The problem.
        #[source]
        source: Box<BicycleError>,
    },
}
