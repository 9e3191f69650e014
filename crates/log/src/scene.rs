//! `foxglove.SceneUpdate` as JSON: the parts of it that a drawing of lines needs.

use serde::Serialize;
use serde_json::{Value, json as value};
use twinhub_types::Instant;

/// Name of the schema.
pub(crate) const SCHEMA_NAME: &str = "foxglove.SceneUpdate";

/// The scene at `at`: one entity made of `lines`.
pub(crate) fn json(at: Instant, lines: Vec<Line>) -> String {
    let ns = at.as_nanos();
    let timestamp = Time {
        sec: ns / 1_000_000_000,
        nsec: ns % 1_000_000_000,
    };
    let entity = Entity {
        timestamp,
        lines,
        ..Entity::default()
    };
    let update = SceneUpdate {
        deletions: [],
        entities: [entity],
    };
    // Plain structs of numbers and texts: nothing in them can fail to be JSON.
    serde_json::to_string(&update).unwrap_or_default()
}

/// Always an empty list.
type Nothing = [u8; 0];

#[derive(Serialize)]
struct SceneUpdate {
    deletions: Nothing,
    entities: [Entity; 1],
}

#[derive(Serialize, Default, Clone, Copy)]
struct Time {
    sec: u64,
    nsec: u64,
}

/// Fields of `foxglove.SceneEntity`, in its order.
#[derive(Serialize)]
struct Entity {
    timestamp: Time,
    frame_id: &'static str,
    id: &'static str,
    lifetime: Time,
    frame_locked: bool,
    metadata: Nothing,
    arrows: Nothing,
    cubes: Nothing,
    spheres: Nothing,
    cylinders: Nothing,
    lines: Vec<Line>,
    triangles: Nothing,
    texts: Nothing,
    models: Nothing,
}

impl Default for Entity {
    fn default() -> Self {
        Self {
            timestamp: Time::default(),
            frame_id: "bicycle",
            id: "bicycle",
            lifetime: Time::default(),
            frame_locked: false,
            metadata: [],
            arrows: [],
            cubes: [],
            spheres: [],
            cylinders: [],
            lines: Vec::new(),
            triangles: [],
            texts: [],
            models: [],
        }
    }
}

/// Fields of `foxglove.LinePrimitive`, in its order.
#[derive(Serialize)]
pub(crate) struct Line {
    #[serde(rename = "type")]
    kind: u8,
    pose: Pose,
    thickness: f64,
    scale_invariant: bool,
    points: Vec<Xyz>,
    color: Rgba,
    colors: Nothing,
    indices: Nothing,
}

#[derive(Serialize, Default)]
struct Pose {
    position: Xyz,
    orientation: Quaternion,
}

#[derive(Serialize, Default)]
struct Xyz {
    x: f64,
    y: f64,
    z: f64,
}

#[derive(Serialize)]
struct Quaternion {
    x: f64,
    y: f64,
    z: f64,
    w: f64,
}

impl Default for Quaternion {
    fn default() -> Self {
        Self {
            x: 0.0,
            y: 0.0,
            z: 0.0,
            w: 1.0,
        }
    }
}

#[derive(Serialize)]
struct Rgba {
    r: f64,
    g: f64,
    b: f64,
    a: f64,
}

/// A line primitive: 0 strip, 2 pairs.
pub(crate) fn line(kind: u8, thickness: f64, [r, g, b, a]: [f64; 4], points: &[[f64; 3]]) -> Line {
    let round = |value: f64| libm::round(value * 1e4) / 1e4;
    Line {
        kind,
        pose: Pose::default(),
        thickness,
        scale_invariant: false,
        // Foxglove: z up, y to the left.
        points: points
            .iter()
            .map(|p| Xyz {
                x: round(p[0]),
                y: round(-p[1]),
                z: round(-p[2]),
            })
            .collect(),
        color: Rgba { r, g, b, a },
        colors: [],
        indices: [],
    }
}

/// The part of the published `foxglove.SceneUpdate` schema that the scenes use.
pub(crate) fn schema() -> String {
    let number = value!({"type": "number"});
    let integer = value!({"type": "integer"});
    let text = value!({"type": "string"});
    let object = |properties: Value| value!({"type": "object", "properties": properties});
    let list = |items: Value| value!({"type": "array", "items": items});
    let time = object(value!({"sec": integer, "nsec": integer}));
    let point = object(value!({"x": number, "y": number, "z": number}));
    let color = object(value!({"r": number, "g": number, "b": number, "a": number}));
    let pose = object(value!({
        "position": point,
        "orientation": object(value!({"x": number, "y": number, "z": number, "w": number})),
    }));
    let line = object(value!({
        "type": integer, "pose": pose, "thickness": number, "scale_invariant": {"type": "boolean"},
        "points": list(point), "color": color, "colors": list(color.clone()), "indices": list(integer.clone()),
    }));
    let any = list(value!({"type": "object"}));
    let entity = object(value!({
        "timestamp": time, "frame_id": text, "id": text, "lifetime": time,
        "frame_locked": {"type": "boolean"},
        "metadata": list(object(value!({"key": text, "value": text}))),
        "arrows": any, "cubes": any, "spheres": any, "cylinders": any, "lines": list(line),
        "triangles": any, "texts": any, "models": any,
    }));
    let deletion = object(value!({"timestamp": time, "type": integer, "id": text}));
    let mut schema = object(value!({"deletions": list(deletion), "entities": list(entity)}));
    schema["title"] = value!(SCHEMA_NAME);
    schema.to_string()
}
