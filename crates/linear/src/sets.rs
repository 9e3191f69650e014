//! Built-in parameter sets, by publication name.

use crate::bicycle::Bicycle;
use crate::bulsink::{self, Options};
use crate::error::BicycleError;
use std::path::Path;

/// Names of the built-in sets.
pub const NAMES: &[&str] = &[
    "meijaard2007_benchmark",
    "bulsink2017_bicycle1",
    "bulsink2017_bicycle2",
];

const MEIJAARD: &str = include_str!("../data/meijaard2007_benchmark.toml");

/// One line about a built-in set and its options.
pub fn describe(name: &str) -> Option<&'static str> {
    match name {
        "meijaard2007_benchmark" => {
            Some("benchmark bicycle with rider, Meijaard et al. (2007), table 1")
        }
        "bulsink2017_bicycle1" => Some(
            "bicycle 1 with rigid 80 kg rider, Bulsink (2017), table A.1; options products=tensor|adams, wheel_k=NUMBER",
        ),
        "bulsink2017_bicycle2" => Some(
            "bicycle 2 with bicycle 1's rider, Bulsink (2017), table A.1; options products=tensor|adams, wheel_k=NUMBER",
        ),
        _ => None,
    }
}

/// The set that `spec` names: `NAME` or `NAME:OPTION=VALUE,...`; `None` if there is no such set.
/// Names are matched without regard to case.
pub(crate) fn find(spec: &str) -> Option<Result<Bicycle, BicycleError>> {
    let (name, options) = spec.split_once(':').unwrap_or((spec, ""));
    let name = *NAMES.iter().find(|n| n.eq_ignore_ascii_case(name))?;
    let bulsink = |number| {
        Options::parse(name, options).and_then(|options| bulsink::bicycle(number, options))
    };
    Some(match name {
        "bulsink2017_bicycle1" => bulsink(bulsink::Number::One),
        "bulsink2017_bicycle2" => bulsink(bulsink::Number::Two),
        _ if !options.is_empty() => Err(BicycleError::UnknownOption {
            set: name.to_owned(),
            found: options.to_owned(),
            accepted: "none".to_owned(),
        }),
        _ => Bicycle::from_toml(MEIJAARD, Path::new("meijaard2007_benchmark.toml")),
    })
}
