//! Names of the topics of a ride.

/// The true state of the plant.
pub const PLANT_TRUTH: &str = "/plant/truth";
/// What the rider model does.
pub const RIDER_STATE: &str = "/rider/state";
/// What the sensors say: [`twinhub_types::Measurement`].
pub const SENSOR_MEASUREMENT: &str = "/sensor/measurement";
/// What the rider wants: [`twinhub_types::RiderIntent`].
pub const RIDER_INTENT: &str = "/rider/intent";
/// What the controller answers: [`twinhub_types::Output`].
pub const CONTROL_OUTPUT: &str = "/control/output";
/// How long the link took; not in the digest.
pub const LINK_TIMING: &str = "/link/timing";
/// Things that happen rarely.
pub const EVENT: &str = "/event";
/// The bicycle in three dimensions.
pub const SCENE: &str = "/scene";
