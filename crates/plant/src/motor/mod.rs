//! Hub motors, their drives, battery and bus.
//!
//! A [`Drive`] turns commands into torque: watchdog, dead time, lag, then the motor of the
//! registry [`MotorDrive`]. A [`PowerTrain`] is two drives on one [`Bus`]. Torques and rates are
//! those of the wheel, positive forward; only the power train speaks of a front brake torque.

mod battery;
mod direct_drive;
mod drive;
mod geared_freewheel;
mod ideal;
mod machine;
mod power_train;
pub mod sets;
mod thermal;
mod watchdog;

pub use battery::{Battery, BatteryModel, Bus, BusEnergy, IdealSupply, LithiumIon};
pub use direct_drive::DirectDrive;
pub use drive::{Drive, DriveOutput, DriveParameters, MAX_DEAD_TICKS};
pub use geared_freewheel::GearedFreewheel;
pub use ideal::{FixedEfficiency, Ideal};
pub use machine::Machine;
pub use power_train::{PowerOutput, PowerTrain, PowerTrainParameters};
pub use thermal::Thermal;
pub use watchdog::Watchdog;

use serde::{Deserialize, Serialize};

use crate::admissible::OutOfRange;
use crate::explain::Explain;

/// What a motor remembers from tick to tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotorState {
    /// Wheel angle, rad, in `[0, 2π)`.
    pub angle_rad: f64,
    /// Rotor rate at the wheel side of the gear, rad/s; a direct drive's rotor is the wheel.
    pub rotor_rad_s: f64,
    /// Temperature of the winding, °C.
    pub winding_celsius: f64,
}

impl Default for MotorState {
    fn default() -> Self {
        Self {
            angle_rad: 0.0,
            rotor_rad_s: 0.0,
            winding_celsius: 25.0,
        }
    }
}

/// Where a motor runs in one tick, before friction: what limits and the bus decide on.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct OperatingPoint {
    /// Torque of the magnets on the rotor, at the wheel side of the gear, Nm.
    pub motor_nm: f64,
    /// Torque-producing current, A.
    pub current_a: f64,
    /// Field-weakening current, A, never positive.
    pub field_a: f64,
    /// Loss in the copper, W.
    pub copper_w: f64,
    /// Loss in bridge and electronics, W.
    pub drive_w: f64,
    /// Power taken from the bus, W; negative when it regenerates.
    pub electrical_w: f64,
    /// The bridge is switching.
    pub on: bool,
    /// The peak current held the torque back.
    pub current_limited: bool,
    /// The bus voltage held the torque back.
    pub voltage_limited: bool,
    /// The winding's temperature held the torque back.
    pub heat_limited: bool,
}

impl OperatingPoint {
    /// The bridge is open: no current.
    pub const OFF: Self = Self {
        motor_nm: 0.0,
        current_a: 0.0,
        field_a: 0.0,
        copper_w: 0.0,
        drive_w: 0.0,
        electrical_w: 0.0,
        on: false,
        current_limited: false,
        voltage_limited: false,
        heat_limited: false,
    };
}

/// What reaches the wheel in one tick.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Shaft {
    /// Torque on the wheel, Nm.
    pub torque_nm: f64,
    /// Loss in iron, bearings, gear and clutch, W.
    pub friction_w: f64,
    /// Power that went into the rotor's motion and the cogging's potential, W.
    pub stored_w: f64,
}

/// A kind of motor.
pub trait MotorModel {
    /// What it is, for users.
    fn explain(&self) -> Explain;
    /// Checks every parameter.
    fn validate(&self) -> Result<(), OutOfRange>;
    /// Where it runs when `torque_nm` is asked for.
    fn point(
        &self,
        torque_nm: f64,
        wheel_rate_rad_s: f64,
        state: &MotorState,
        bus_v: f64,
    ) -> OperatingPoint;
    /// Ends the tick at `point`: torque on the wheel, rotor, temperature.
    fn finish(
        &self,
        point: &OperatingPoint,
        wheel_rate_rad_s: f64,
        state: &mut MotorState,
        step_s: f64,
    ) -> Shaft;
    /// The torque that the drive reports for a current, Nm.
    fn reported_nm(&self, point: &OperatingPoint) -> f64;
}

twinhub_types::registry! {
    /// The motors.
    #[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
    #[serde(rename_all = "snake_case")]
    pub enum MotorDrive: MotorModel {
        /// Torque as commanded, without loss.
        Ideal(Ideal) = "ideal",
        /// Torque as commanded, one efficiency each way.
        FixedEfficiency(FixedEfficiency) = "fixed_efficiency",
        /// A hub whose rotor is the wheel.
        DirectDrive(DirectDrive) = "direct_drive",
        /// A geared hub behind a freewheel: drives, cannot brake.
        GearedFreewheel(GearedFreewheel) = "geared_freewheel",
    }
    fn explain(&self) -> Explain;
    fn validate(&self) -> Result<(), OutOfRange>;
    fn point(&self, torque_nm: f64, wheel_rate_rad_s: f64, state: &MotorState, bus_v: f64) -> OperatingPoint;
    fn finish(&self, point: &OperatingPoint, wheel_rate_rad_s: f64, state: &mut MotorState, step_s: f64) -> Shaft;
    fn reported_nm(&self, point: &OperatingPoint) -> f64;
}

impl MotorDrive {
    /// One example of every entry, in the order of `NAMES`: what `list` and `explain` show.
    pub fn examples() -> [Self; 4] {
        [
            Self::Ideal(Ideal {}),
            Self::FixedEfficiency(FixedEfficiency {
                efficiency_ratio: 0.85,
                peak_nm: 100.0,
            }),
            Self::DirectDrive(sets::hub_28mm()),
            Self::GearedFreewheel(sets::geared_hub()),
        ]
    }

    /// Mechanical over electrical power (or, when it regenerates, the other way round) at a steady
    /// torque on the wheel; 0 where power flows in from both sides. One entry of the efficiency map.
    pub fn efficiency_ratio(
        &self,
        torque_nm: f64,
        wheel_rate_rad_s: f64,
        winding_celsius: f64,
        bus_v: f64,
    ) -> f64 {
        let mut state = MotorState {
            angle_rad: 0.0,
            rotor_rad_s: wheel_rate_rad_s,
            winding_celsius,
        };
        let point = self.point(torque_nm, wheel_rate_rad_s, &state, bus_v);
        let shaft = self.finish(&point, wheel_rate_rad_s, &mut state, 1e-3);
        let mechanical_w = shaft.torque_nm * wheel_rate_rad_s;
        if mechanical_w > 0.0 && point.electrical_w > 0.0 {
            mechanical_w / point.electrical_w
        } else if mechanical_w < 0.0 && point.electrical_w < 0.0 {
            point.electrical_w / mechanical_w
        } else {
            0.0
        }
    }
}

#[cfg(test)]
mod tests;
