//! Motors without physics, for comparisons.
//!
//! What: `ideal` gives the commanded torque without loss; `fixed_efficiency` gives it up to a
//! peak, with one efficiency for each direction of power. Equation: P_el = T ω, or T ω / η when it
//! drives and η T ω when it brakes. Source: the 85 % each way in which energies of torque pairs
//! are often quoted. Assumes and ignores: no copper loss at standstill, no drag, no envelope, no
//! heat: a real hub motor at high torque and low speed is far worse. Valid for: separating what
//! the torque does from what the motor does. Checked by: the conformance suite of the registry.

use serde::{Deserialize, Serialize};

use super::{MotorModel, MotorState, OperatingPoint, Shaft};
use crate::admissible::{OutOfRange, within};
use crate::explain::Explain;

/// Torque as commanded, without loss.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Ideal {}

/// Torque as commanded up to a peak, one efficiency each way.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FixedEfficiency {
    /// Efficiency from bus to wheel and from wheel to bus.
    pub efficiency_ratio: f64,
    /// Largest torque, Nm.
    pub peak_nm: f64,
}

fn shaft(point: &OperatingPoint) -> Shaft {
    Shaft {
        torque_nm: point.motor_nm,
        friction_w: 0.0,
        stored_w: 0.0,
    }
}

impl MotorModel for Ideal {
    fn explain(&self) -> Explain {
        Explain {
            name: "ideal",
            what: "a motor whose torque is the command, without loss, limit or friction",
            equation: "T = T_cmd, P_el = T ω",
            source: "definition",
            assumes: "everything; for comparisons of the bicycle's physics alone",
        }
    }

    fn validate(&self) -> Result<(), OutOfRange> {
        Ok(())
    }

    fn point(
        &self,
        torque_nm: f64,
        wheel_rate_rad_s: f64,
        _: &MotorState,
        _: f64,
    ) -> OperatingPoint {
        OperatingPoint {
            motor_nm: torque_nm,
            electrical_w: torque_nm * wheel_rate_rad_s,
            on: true,
            ..OperatingPoint::OFF
        }
    }

    fn finish(&self, point: &OperatingPoint, _: f64, _: &mut MotorState, _: f64) -> Shaft {
        shaft(point)
    }

    fn reported_nm(&self, point: &OperatingPoint) -> f64 {
        point.motor_nm
    }
}

impl MotorModel for FixedEfficiency {
    fn explain(&self) -> Explain {
        Explain {
            name: "fixed_efficiency",
            what: "a motor with one efficiency for driving and for regeneration, up to a peak torque",
            equation: "T = clamp(T_cmd, ±T_peak); P_el = T ω/η if T ω > 0, else η T ω",
            source: "the way in which energies of torque pairs are often quoted (85 % each way)",
            assumes: "no copper loss at standstill, no drag, no speed limit, no heat",
        }
    }

    fn validate(&self) -> Result<(), OutOfRange> {
        within("efficiency_ratio", self.efficiency_ratio, 0.01, 1.0)?;
        within("peak_nm", self.peak_nm, 0.0, 1000.0)
    }

    fn point(
        &self,
        torque_nm: f64,
        wheel_rate_rad_s: f64,
        _: &MotorState,
        _: f64,
    ) -> OperatingPoint {
        let motor_nm = torque_nm.clamp(-self.peak_nm, self.peak_nm);
        let mechanical_w = motor_nm * wheel_rate_rad_s;
        let electrical_w = if mechanical_w > 0.0 {
            mechanical_w / self.efficiency_ratio
        } else {
            mechanical_w * self.efficiency_ratio
        };
        OperatingPoint {
            motor_nm,
            electrical_w,
            drive_w: electrical_w - mechanical_w,
            on: true,
            current_limited: motor_nm != torque_nm,
            ..OperatingPoint::OFF
        }
    }

    fn finish(&self, point: &OperatingPoint, _: f64, _: &mut MotorState, _: f64) -> Shaft {
        shaft(point)
    }

    fn reported_nm(&self, point: &OperatingPoint) -> f64 {
        point.motor_nm
    }
}
