//! Sensors that do not tell the truth.

mod gyro_misalignment;
mod rider_delay;
mod roll_rate_sensor_delay;
mod roll_sensor_bias;
mod speed_quantisation;
mod speed_scale;
mod steer_sensor_bias;
mod steer_sensor_delay;
mod steer_sensor_scale;

pub use gyro_misalignment::GyroMisalignment;
pub use rider_delay::RiderDelay;
pub use roll_rate_sensor_delay::RollRateSensorDelay;
pub use roll_sensor_bias::RollSensorBias;
pub use speed_quantisation::SpeedQuantisation;
pub use speed_scale::SpeedScale;
pub use steer_sensor_bias::SteerSensorBias;
pub use steer_sensor_delay::SteerSensorDelay;
pub use steer_sensor_scale::SteerSensorScale;
