//! Events: things that happen rarely and are worth a line of text.

use twinhub_types::Instant;

/// How grave an event is; the numbers are those of `foxglove.Log`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Level {
    /// Something happened.
    Info = 2,
    /// Something that the rider or the engineer should know.
    Warning = 3,
    /// Something is broken.
    Error = 4,
}

/// An event of a ride.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Event<'a> {
    /// How grave it is.
    pub level: Level,
    /// Who says it and a stable code: `supervisor.link_lost`.
    pub code: &'a str,
    /// A sentence.
    pub text: &'a str,
}

/// Name of the schema.
pub(crate) const SCHEMA_NAME: &str = "foxglove.Log";

/// The fields of `foxglove.Log` that an event has.
pub(crate) const SCHEMA: &str = r#"{"title":"foxglove.Log","description":"An event of the ride","type":"object","properties":{"timestamp":{"type":"object","title":"time","properties":{"sec":{"type":"integer","minimum":0},"nsec":{"type":"integer","minimum":0,"maximum":999999999}}},"level":{"type":"integer","description":"2 info, 3 warning, 4 error"},"message":{"type":"string"},"name":{"type":"string"},"file":{"type":"string"},"line":{"type":"integer","minimum":0}}}"#;

impl Event<'_> {
    /// The event as JSON.
    pub(crate) fn json(&self, at: Instant) -> String {
        let ns = at.as_nanos();
        serde_json::json!({
            "timestamp": {"sec": ns / 1_000_000_000, "nsec": ns % 1_000_000_000},
            "level": self.level as u8,
            "message": self.text,
            "name": self.code,
            "file": "",
            "line": 0,
        })
        .to_string()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_event_has_exactly_the_fields_of_its_schema() {
        let schema: serde_json::Value = serde_json::from_str(SCHEMA).expect("schema is JSON");
        let event = Event {
            level: Level::Warning,
            code: "a.b",
            text: "say \"no\"\n",
        };
        let json: serde_json::Value =
            serde_json::from_str(&event.json(Instant::from_nanos(3_000_000_007))).expect("JSON");
        let keys = |value: &serde_json::Value| -> Vec<String> {
            let mut keys: Vec<_> = value.as_object().expect("object").keys().cloned().collect();
            keys.sort();
            keys
        };
        assert_eq!(keys(&json), keys(&schema["properties"]));
        assert_eq!(json["timestamp"], serde_json::json!({"sec": 3, "nsec": 7}));
        assert_eq!(
            (json["level"].as_u64(), json["message"].as_str()),
            (Some(3), Some("say \"no\"\n"))
        );
    }
}
