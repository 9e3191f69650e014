//! A direct-drive hub motor: the rotor is the wheel.
//!
//! What: the machine of `machine.rs` with iron drag and cogging. Equation: T = k i_q -
//! (c tanh(ω/ω_c) + b ω) - T_cog, T_cog = a sin(N θ) averaged over the angle of the tick, so that
//! the work of the cogging over a tick is exactly the change of its potential. Source: hysteresis
//! loss of iron is a constant torque, eddy currents a viscous one (any textbook on machines).
//! Assumes and ignores: as in `machine.rs`; the rotor's inertia belongs to the wheel; cogging
//! faster than the tick is averaged away. Valid for: both directions, driving and braking.
//! Checked by: the conformance suite of the registry, cogging test below.

use serde::{Deserialize, Serialize};

use super::{Machine, MotorModel, MotorState, OperatingPoint, Shaft, Thermal};
use crate::admissible::{OutOfRange, within};
use crate::explain::Explain;

/// Below this rate the Coulomb friction falls to zero smoothly, rad/s.
pub(super) const COULOMB_RATE_RAD_S: f64 = 0.1;

/// Parameters of a direct-drive hub motor.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DirectDrive {
    /// Drag from hysteresis and bearings, Nm.
    pub coulomb_drag_nm: f64,
    /// Drag from eddy currents, Nm s/rad.
    pub viscous_drag_nm_s: f64,
    /// Amplitude of the cogging torque, Nm.
    pub cogging_nm: f64,
    /// Cogging periods in one turn of the wheel.
    pub cogging_cycles: u32,
    /// The electrical machine.
    pub machine: Machine,
    /// Its heat.
    pub thermal: Thermal,
}

impl DirectDrive {
    /// Magnitude of the drag torque, Nm, with the sign of the rate.
    pub fn drag_nm(&self, wheel_rate_rad_s: f64) -> f64 {
        self.coulomb_drag_nm * libm::tanh(wheel_rate_rad_s / COULOMB_RATE_RAD_S)
            + self.viscous_drag_nm_s * wheel_rate_rad_s
    }

    /// Mean of a sin(N θ) over the angle from `start_rad`, `turn_rad` long.
    fn cogging_nm(&self, start_rad: f64, turn_rad: f64) -> f64 {
        if self.cogging_nm == 0.0 {
            return 0.0;
        }
        let n = f64::from(self.cogging_cycles);
        let half = 0.5 * n * turn_rad;
        let sinc = if half.abs() < 1e-4 {
            1.0 - half * half / 6.0
        } else {
            libm::sin(half) / half
        };
        self.cogging_nm * libm::sin(n * start_rad + half) * sinc
    }
}

impl MotorModel for DirectDrive {
    fn explain(&self) -> Explain {
        Explain {
            name: "direct_drive",
            what: "a hub motor whose rotor is the wheel: drives, brakes and regenerates",
            equation: "T = k i_q - (c tanh(ω/ω_c) + b ω) - a sin(N θ); P = k i_q ω + R(ϑ) i² + v_b |i| + P_0; \
                       |v| <= m V_bus with i_d <= 0 for field weakening; C dϑ/dt = losses - (ϑ - ϑ_a)/R_th",
            source: "two-axis machine equations (Krause, Wasynczuk and Sudhoff 2002, chapter 4); parameter \
                     sets are orders of magnitude of hubs on sale, see the set's own words",
            assumes: "no saturation, no saliency, quasi-steady current behind one lag, no rectification \
                      through the diodes, one temperature",
        }
    }

    fn validate(&self) -> Result<(), OutOfRange> {
        within("coulomb_drag_nm", self.coulomb_drag_nm, 0.0, 100.0)?;
        within("viscous_drag_nm_s", self.viscous_drag_nm_s, 0.0, 10.0)?;
        within("cogging_nm", self.cogging_nm, 0.0, 100.0)?;
        within(
            "cogging_cycles",
            f64::from(self.cogging_cycles),
            1.0,
            10_000.0,
        )?;
        self.machine.validate()?;
        self.thermal.validate()
    }

    fn point(
        &self,
        torque_nm: f64,
        wheel_rate_rad_s: f64,
        state: &MotorState,
        bus_v: f64,
    ) -> OperatingPoint {
        self.machine
            .point(torque_nm, wheel_rate_rad_s, state, bus_v)
    }

    fn finish(
        &self,
        point: &OperatingPoint,
        wheel_rate_rad_s: f64,
        state: &mut MotorState,
        step_s: f64,
    ) -> Shaft {
        let turn_rad = wheel_rate_rad_s * step_s;
        let drag_nm = self.drag_nm(wheel_rate_rad_s);
        let cogging_nm = self.cogging_nm(state.angle_rad, turn_rad);
        let friction_w = drag_nm * wheel_rate_rad_s;
        state.angle_rad = wrap(state.angle_rad + turn_rad);
        state.rotor_rad_s = wheel_rate_rad_s;
        state.winding_celsius =
            self.thermal
                .step(state.winding_celsius, point.copper_w + friction_w, step_s);
        Shaft {
            torque_nm: point.motor_nm - drag_nm - cogging_nm,
            friction_w,
            stored_w: cogging_nm * wheel_rate_rad_s,
        }
    }

    fn reported_nm(&self, point: &OperatingPoint) -> f64 {
        self.machine.torque_constant_nm_per_a * point.current_a
    }
}

/// The angle in `[0, 2π)`.
pub(super) fn wrap(angle_rad: f64) -> f64 {
    let turn = 2.0 * core::f64::consts::PI;
    angle_rad - turn * libm::floor(angle_rad / turn)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motor::sets;

    #[test]
    fn cogging_repeats_n_times_a_turn_and_does_no_work_over_one() {
        let hub = DirectDrive {
            cogging_nm: 0.5,
            cogging_cycles: 51,
            ..sets::hub_28mm()
        };
        let turn = 2.0 * core::f64::consts::PI;
        let steps = 10_000;
        let step = turn / f64::from(steps);
        let mut work = 0.0;
        let mut crossings = 0;
        let mut last = 0.0;
        for i in 0..steps {
            let torque = hub.cogging_nm(f64::from(i) * step, step);
            work += torque * step;
            crossings += u32::from(last < 0.0 && torque >= 0.0);
            last = torque;
        }
        assert!(work.abs() < 1e-9, "work {work}");
        assert_eq!(crossings, 50, "51 periods begin at a zero");
    }
}
