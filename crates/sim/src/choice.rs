//! A part of a course that is named or written out: `motors = "ideal"`, `motors = "mine.toml"`, or
//! `[motors.front]` with its keys.

use serde::de::value::MapAccessDeserializer;
use serde::de::{DeserializeOwned, MapAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::fmt;
use std::marker::PhantomData;

/// A name (of what ships, or a file), or the thing itself.
#[derive(Clone, Debug, PartialEq)]
pub enum Choice<T> {
    /// A name or a file.
    Named(String),
    /// The values.
    Given(Box<T>),
}

impl<T> Choice<T> {
    /// The values; `None` while it is only a name.
    pub fn given(&self) -> Option<&T> {
        match self {
            Self::Named(_) => None,
            Self::Given(values) => Some(values),
        }
    }
}

impl<T> From<T> for Choice<T> {
    fn from(values: T) -> Self {
        Self::Given(Box::new(values))
    }
}

impl<T: Serialize> Serialize for Choice<T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Named(name) => serializer.serialize_str(name),
            Self::Given(values) => values.serialize(serializer),
        }
    }
}

// Not an untagged enum: that would lose line and key of a mistake in the values.
impl<'de, T: DeserializeOwned> Deserialize<'de> for Choice<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct NameOrTable<T>(PhantomData<T>);
        impl<'de, T: DeserializeOwned> Visitor<'de> for NameOrTable<T> {
            type Value = Choice<T>;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                write!(f, "a name that ships, a file, or a table")
            }
            fn visit_str<E>(self, name: &str) -> Result<Choice<T>, E> {
                Ok(Choice::Named(name.to_owned()))
            }
            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Choice<T>, A::Error> {
                let values = T::deserialize(MapAccessDeserializer::new(map))?;
                Ok(Choice::Given(Box::new(values)))
            }
        }
        deserializer.deserialize_any(NameOrTable(PhantomData))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use twinhub_plant::road::Road;

    #[derive(Debug, Deserialize)]
    #[serde(deny_unknown_fields)]
    struct File {
        road: Choice<Road>,
    }

    #[test]
    fn names_and_tables_are_read_and_a_typo_keeps_its_line() {
        let file: File = toml::from_str("road = \"wet\"").expect("a name");
        assert_eq!(file.road, Choice::Named("wet".into()));
        let file: File = toml::from_str("[road]\nfriction_ratio = 0.5").expect("a table");
        assert_eq!(file.road, Road::level(0.5).into());
        let error = toml::from_str::<File>("[road]\nfriction_ratio = 0.5\nslop_rad = 0.1")
            .expect_err("a typo")
            .to_string();
        assert!(
            error.contains("line 3") && error.contains("slop_rad"),
            "{error}"
        );
        let error = toml::from_str::<File>("road = 3")
            .expect_err("a number")
            .to_string();
        assert!(error.contains("a name that ships"), "{error}");
    }
}
