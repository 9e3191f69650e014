//! What plant and controller say to each other: one frame each way and tick.
//!
//! Units and signs as in [`conventions`](crate::conventions). A sample that was never taken has
//! the stamp [`NEVER_NS`](crate::NEVER_NS); its values are then ignored.

use crate::message;
use crate::time::NEVER_NS;
use crate::wire::{Wire, hash_str, hash_u64};

/// Version of the protocol; raised when the meaning of a field changes without its layout.
pub const PROTOCOL_VERSION: u32 = 1;

/// What both sides compare before the first tick: layouts of both frames, and the version.
pub const PROTOCOL_HASH: u64 = {
    let hash = hash_str(crate::wire::HASH_START, "twinhub");
    let hash = hash_u64(hash, PROTOCOL_VERSION as u64);
    let hash = hash_u64(hash, PlantFrame::LAYOUT_HASH);
    hash_u64(hash, ControllerFrame::LAYOUT_HASH)
};

/// How a ride goes on after this frame; `Header::state`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum RideState {
    /// The ride goes on.
    Running = 0,
    /// This was the last frame; the course is finished.
    Finished = 1,
    /// The bicycle fell; this was the last frame.
    Fell = 2,
    /// The sender was asked to stop; this was the last frame.
    Stopped = 3,
}

impl RideState {
    /// The state with number `value`; an unknown number counts as `Stopped`.
    pub const fn from_u32(value: u32) -> Self {
        match value {
            0 => Self::Running,
            1 => Self::Finished,
            2 => Self::Fell,
            _ => Self::Stopped,
        }
    }
}

message! {
    /// What every frame begins with.
    #[derive(Default)]
    pub struct Header {
        /// [`PROTOCOL_HASH`] of the sender.
        pub protocol_hash: u64,
        /// Counts the sender's frames from 0 without gaps.
        pub sequence: u64,
        /// The tick that the frame belongs to.
        pub tick: u64,
        /// Ride time of the tick, ns.
        pub time_ns: u64,
        /// A [`RideState`].
        pub state: u32,
        /// Always 0.
        pub reserved: u32,
    }
}

message! {
    /// Inertial measurement unit on the rear frame, body axes (x forward, y right, z down).
    pub struct ImuSample {
        /// When the sample was taken, ns of ride time.
        pub stamp_ns: u64,
        /// Angular rates: roll, pitch, yaw rate of the body, rad/s.
        pub gyro_rad_s: [f32; 3],
        /// Specific force, m/s².
        pub accel_m_s2: [f32; 3],
    }
}

message! {
    /// Measured roll, where a sensor for it exists (laboratory).
    pub struct RollSample {
        /// When the sample was taken, ns of ride time.
        pub stamp_ns: u64,
        /// Roll angle, rad.
        pub roll_rad: f32,
        /// Roll rate, rad/s.
        pub roll_rate_rad_s: f32,
    }
}

message! {
    /// Steer encoder.
    pub struct SteerSample {
        /// When the sample was taken, ns of ride time.
        pub stamp_ns: u64,
        /// Steer angle, rad.
        pub steer_rad: f32,
        /// Steer rate, rad/s; NaN if the encoder gives none.
        pub steer_rate_rad_s: f32,
    }
}

message! {
    /// Wheel-speed sensors.
    pub struct WheelSample {
        /// When the sample was taken, ns of ride time.
        pub stamp_ns: u64,
        /// Front wheel rate, positive forward, rad/s.
        pub front_rad_s: f32,
        /// Rear wheel rate, positive forward, rad/s.
        pub rear_rad_s: f32,
        /// Forward speed of the bicycle as its own speedometer gives it, m/s.
        pub speed_m_s: f32,
        /// Always 0.
        pub reserved: u32,
    }
}

message! {
    /// What the motor drives report.
    pub struct MotorSample {
        /// When the sample was taken, ns of ride time.
        pub stamp_ns: u64,
        /// Front brake torque from the drive's current, Nm.
        pub front_brake_nm: f32,
        /// Rear traction torque from the drive's current, Nm.
        pub rear_traction_nm: f32,
        /// Bus voltage, V.
        pub bus_v: f32,
        /// Bus current, positive out of the battery, A.
        pub bus_a: f32,
        /// Hottest winding, degrees Celsius.
        pub winding_celsius: f32,
        /// Always 0.
        pub reserved: u32,
    }
}

message! {
    /// Everything that the controller is told about the bicycle in one tick.
    #[derive(Default)]
    pub struct Measurement {
        /// Inertial measurement unit.
        pub imu: ImuSample,
        /// Measured roll.
        pub roll: RollSample,
        /// Steer encoder.
        pub steer: SteerSample,
        /// Wheel speeds.
        pub wheels: WheelSample,
        /// Motor drives.
        pub motors: MotorSample,
    }
}

message! {
    /// What the rider wants, from levers, pedals and the switch on the bar.
    pub struct RiderIntent {
        /// When the intent was read, ns of ride time.
        pub stamp_ns: u64,
        /// 1 while the stabilizer is switched on, else 0.
        pub assist_on: u32,
        /// 1 while the pedals are driven forward, else 0.
        pub pedalling: u32,
        /// Front brake lever, 0 released to 1 fully pulled.
        pub front_brake_ratio: f32,
        /// Rear brake lever, 0 released to 1 fully pulled.
        pub rear_brake_ratio: f32,
        /// Torque of the rider at the crank, Nm.
        pub pedal_nm: f32,
        /// Crank rate, rad/s.
        pub cadence_rad_s: f32,
    }
}

message! {
    /// What the controller believes about the bicycle.
    #[derive(Default)]
    pub struct Estimate {
        /// Roll angle, rad.
        pub roll_rad: f32,
        /// Roll rate, rad/s.
        pub roll_rate_rad_s: f32,
        /// Steer angle, rad.
        pub steer_rad: f32,
        /// Steer rate, rad/s.
        pub steer_rate_rad_s: f32,
        /// Forward speed, m/s.
        pub speed_m_s: f32,
        /// Yaw rate, rad/s.
        pub yaw_rate_rad_s: f32,
        /// One standard deviation of the roll angle, rad.
        pub roll_sd_rad: f32,
        /// One standard deviation of the speed, m/s.
        pub speed_sd_m_s: f32,
    }
}

message! {
    /// Torques that the controller asks of the motor drives.
    #[derive(Default)]
    pub struct Command {
        /// Front brake torque, Nm, never negative.
        pub front_brake_nm: f32,
        /// Rear traction torque, Nm, negative brakes.
        pub rear_traction_nm: f32,
    }
}

message! {
    /// What the controller says in one tick.
    #[derive(Default)]
    pub struct Output {
        /// The torques.
        pub command: Command,
        /// The pair that the law asked for before limits (front brake torque), Nm.
        pub demand_nm: f32,
        /// A [`Mode`](crate::Mode).
        pub mode: u32,
        /// Bits of [`Health`](crate::Health).
        pub health: u32,
        /// Bits of [`LimitedBy`](crate::LimitedBy): what held the command back in this tick.
        pub limited_by: u32,
        /// The state that the command rests on.
        pub estimate: Estimate,
    }
}

message! {
    /// Plant to controller.
    #[derive(Default)]
    pub struct PlantFrame {
        /// Who, when.
        pub header: Header,
        /// What the sensors say.
        pub measurement: Measurement,
        /// What the rider wants.
        pub intent: RiderIntent,
    }
}

message! {
    /// Controller to plant.
    #[derive(Default)]
    pub struct ControllerFrame {
        /// Who, when.
        pub header: Header,
        /// The controller's answer.
        pub output: Output,
    }
}

impl Default for ImuSample {
    fn default() -> Self {
        Self {
            stamp_ns: NEVER_NS,
            gyro_rad_s: [0.0; 3],
            accel_m_s2: [0.0; 3],
        }
    }
}

impl Default for RollSample {
    fn default() -> Self {
        Self {
            stamp_ns: NEVER_NS,
            roll_rad: 0.0,
            roll_rate_rad_s: 0.0,
        }
    }
}

impl Default for SteerSample {
    fn default() -> Self {
        Self {
            stamp_ns: NEVER_NS,
            steer_rad: 0.0,
            steer_rate_rad_s: 0.0,
        }
    }
}

impl Default for WheelSample {
    fn default() -> Self {
        Self {
            stamp_ns: NEVER_NS,
            front_rad_s: 0.0,
            rear_rad_s: 0.0,
            speed_m_s: 0.0,
            reserved: 0,
        }
    }
}

impl Default for MotorSample {
    fn default() -> Self {
        Self {
            stamp_ns: NEVER_NS,
            front_brake_nm: 0.0,
            rear_traction_nm: 0.0,
            bus_v: 0.0,
            bus_a: 0.0,
            winding_celsius: 0.0,
            reserved: 0,
        }
    }
}

impl Default for RiderIntent {
    fn default() -> Self {
        Self {
            stamp_ns: NEVER_NS,
            assist_on: 0,
            pedalling: 0,
            front_brake_ratio: 0.0,
            rear_brake_ratio: 0.0,
            pedal_nm: 0.0,
            cadence_rad_s: 0.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_hold_a_whole_frame() {
        let mut frame = PlantFrame::default();
        frame.header.tick = 7;
        frame.measurement.imu.gyro_rad_s = [1.0, -2.0, 3.5];
        frame.intent.pedal_nm = -0.25;
        let mut bytes = [0u8; PlantFrame::SIZE];
        assert!(frame.put(&mut bytes).is_some_and(|rest| rest.is_empty()));
        let (back, rest) = PlantFrame::get(&bytes).expect("long enough");
        assert_eq!(back, frame);
        assert!(rest.is_empty());
        assert!(PlantFrame::get(&bytes[..PlantFrame::SIZE - 1]).is_none());
    }

    #[test]
    fn the_hash_sees_names_types_and_order() {
        message! { #[derive(Default)] pub struct A { pub x: f32, pub y: u32, } }
        mod other {
            crate::message! { #[derive(Default)] pub struct A { pub y: u32, pub x: f32, } }
        }
        mod renamed {
            crate::message! { #[derive(Default)] pub struct A { pub x: f32, pub z: u32, } }
        }
        assert_ne!(A::LAYOUT_HASH, other::A::LAYOUT_HASH);
        assert_ne!(A::LAYOUT_HASH, renamed::A::LAYOUT_HASH);
        assert_ne!(PlantFrame::LAYOUT_HASH, ControllerFrame::LAYOUT_HASH);
    }
}
