#![forbid(unsafe_code)]
//! Ride logs: MCAP files that Foxglove, PlotJuggler, `rosbag`-like tools and Python open.
//!
//! [`RideLog`] writes, [`read`] reads, [`row!`] declares what a topic of plain numbers holds.
//!
//! What is in a log
//! * Metadata `twinhub` (version, git hash, config digest, seed) and the resolved configuration
//!   as attachment `config.toml` come first.
//! * Tick topics (`/plant/* /rider/* /sensor/* /control/* /link/*`): CDR, little endian, with a
//!   `ros2msg` schema, profile `ros2`. Truth and estimate never share a topic.
//! * `/event`: JSON, schema `foxglove.Log`. `/scene`: JSON, schema `foxglove.SceneUpdate`.
//! * Metadata `twinhub_end` with the digest, the message count and notes come last.
//!
//! Times: `publish_time` is when the sample was taken; `log_time` is when it was written, on the
//! clock of the ride (a lockstep ride runs hundreds of times faster than the wall, and viewers
//! play by `log_time`). Both count from the start of the ride.
//!
//! The digest is BLAKE3 over topic, publish time and payload of every record of the tick topics
//! that are marked [`Digested`](Digest::Digested), in the order written; 32 hex characters. Log
//! times, events, scenes and link timing do not enter it.

mod bicycle;
mod digest;
mod drain;
mod error;
mod event;
mod layouts;
mod messages;
mod reader;
mod record;
mod records;
mod scene;
mod schema;
mod table;
mod topics;
mod writer;

pub use bicycle::{BicycleShape, ScenePose};
pub use digest::{DigestStream, digest_text};
pub use error::LogError;
pub use event::{Event, Level};
pub use layouts::{FOXGLOVE_LAYOUT, PLOTJUGGLER_LAYOUT, check_layouts};
pub use messages::messages;
pub use reader::{Attachment, FILE_MAX, LogFile, Recovery, read};
pub use record::{Record, Row, has_unit, put_row};
pub use schema::row_schema;
pub use table::{Column, Table, TextRecord};
pub use topics::{
    CONTROL_OUTPUT, EVENT, LINK_TIMING, PLANT_TRUTH, RIDER_INTENT, RIDER_STATE, SCENE,
    SENSOR_MEASUREMENT,
};
pub use writer::{BATCH, Digest, IN_FLIGHT_MAX, LogSummary, Metadata, RideLog, Topic};
