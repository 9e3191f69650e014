//! A geared hub motor behind a freewheel.
//!
//! What: a fast small motor, a planetary gear and a one-way clutch: it can drive the wheel, never
//! brake it, and an idle one does not drag. Equation: at the wheel side of the gear the rotor,
//! with J' = n² J, would reach ω* = ω_r + (T' - drag) Δt/J' in the tick. If ω* exceeds the wheel's
//! rate, the clutch is closed: it transmits J' (ω* - ω_w)/Δt, and the rotor ends at the wheel's
//! rate; else it transmits nothing. T' = η n k i_q when the motor pulls. Source: plastic one-way
//! clutch, our own discretisation; energy is lost in it, never made. Assumes and ignores: no lash,
//! no clutch compliance; as in `machine.rs`. Valid for: forward riding. Checked by: the
//! conformance suite of the registry and the tests below.

use serde::{Deserialize, Serialize};

use super::direct_drive::{COULOMB_RATE_RAD_S, wrap};
use super::{Machine, MotorModel, MotorState, OperatingPoint, Shaft, Thermal};
use crate::admissible::{OutOfRange, within};
use crate::explain::Explain;

/// Parameters of a geared hub motor with freewheel.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GearedFreewheel {
    /// Rotor turns for one turn of the wheel.
    pub gear_ratio: f64,
    /// Efficiency of the gear when the motor pulls.
    pub gear_efficiency_ratio: f64,
    /// Inertia of the rotor about its own axis, kg m².
    pub rotor_kg_m2: f64,
    /// Drag of rotor and gear at the wheel side, Nm.
    pub coulomb_drag_nm: f64,
    /// Drag of rotor and gear at the wheel side, Nm s/rad.
    pub viscous_drag_nm_s: f64,
    /// Drag of the open freewheel on the wheel, Nm.
    pub freewheel_drag_nm: f64,
    /// The electrical machine, at its own rotor.
    pub machine: Machine,
    /// Its heat.
    pub thermal: Thermal,
}

impl MotorModel for GearedFreewheel {
    fn explain(&self) -> Explain {
        Explain {
            name: "geared_freewheel",
            what: "a geared hub motor behind a one-way clutch: drives, cannot brake or regenerate",
            equation: "ω* = ω_r + (η n k i_q - drag) Δt/(n² J); clutch torque = max(0, n² J (ω* - ω_w)/Δt)",
            source: "plastic one-way clutch; two-axis machine equations; parameter sets are orders of \
                     magnitude of hubs on sale",
            assumes: "no lash, no compliance; the rotor's spin-up delays torque after coasting",
        }
    }

    fn validate(&self) -> Result<(), OutOfRange> {
        within("gear_ratio", self.gear_ratio, 1.0, 50.0)?;
        within(
            "gear_efficiency_ratio",
            self.gear_efficiency_ratio,
            0.1,
            1.0,
        )?;
        within("rotor_kg_m2", self.rotor_kg_m2, 1e-6, 1.0)?;
        within("coulomb_drag_nm", self.coulomb_drag_nm, 0.0, 100.0)?;
        within("viscous_drag_nm_s", self.viscous_drag_nm_s, 0.0, 10.0)?;
        within("freewheel_drag_nm", self.freewheel_drag_nm, 0.0, 10.0)?;
        self.machine.validate()?;
        self.thermal.validate()
    }

    fn point(&self, torque_nm: f64, _: f64, state: &MotorState, bus_v: f64) -> OperatingPoint {
        let n = self.gear_ratio;
        // A drive of this kind asks for no braking current: the clutch could not pass it on.
        let rotor_nm = torque_nm.max(0.0) / n;
        let point = self
            .machine
            .point(rotor_nm, n * state.rotor_rad_s, state, bus_v);
        OperatingPoint {
            motor_nm: n * point.motor_nm,
            ..point
        }
    }

    fn finish(
        &self,
        point: &OperatingPoint,
        wheel_rate_rad_s: f64,
        state: &mut MotorState,
        step_s: f64,
    ) -> Shaft {
        let inertia = self.gear_ratio * self.gear_ratio * self.rotor_kg_m2;
        let start = state.rotor_rad_s;
        let drag_nm = self.coulomb_drag_nm * libm::tanh(start / COULOMB_RATE_RAD_S)
            + self.viscous_drag_nm_s * start;
        let pull_nm = point.motor_nm
            * if point.motor_nm * start > 0.0 {
                self.gear_efficiency_ratio
            } else {
                1.0
            };
        let free = start + (pull_nm - drag_nm) * step_s / inertia;
        let (clutch_nm, end) = if free > wheel_rate_rad_s {
            (
                inertia * (free - wheel_rate_rad_s) / step_s,
                wheel_rate_rad_s,
            )
        } else {
            (0.0, free)
        };
        let freewheel_nm = if clutch_nm > 0.0 {
            0.0
        } else {
            self.freewheel_drag_nm * libm::tanh(wheel_rate_rad_s / COULOMB_RATE_RAD_S)
        };
        let torque_nm = clutch_nm - freewheel_nm;
        // First law over the tick: what neither the wheel nor the rotor's motion got is heat.
        let stored_w = 0.5 * inertia * (end * end - start * start) / step_s;
        let friction_w = point.motor_nm * start - torque_nm * wheel_rate_rad_s - stored_w;
        state.angle_rad = wrap(state.angle_rad + wheel_rate_rad_s * step_s);
        state.rotor_rad_s = end;
        let heat_w = point.copper_w + (drag_nm * start).max(0.0);
        state.winding_celsius = self.thermal.step(state.winding_celsius, heat_w, step_s);
        Shaft {
            torque_nm,
            friction_w,
            stored_w,
        }
    }

    fn reported_nm(&self, point: &OperatingPoint) -> f64 {
        self.gear_ratio * self.machine.torque_constant_nm_per_a * point.current_a
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motor::sets;

    fn run(
        hub: &GearedFreewheel,
        state: &mut MotorState,
        torque: f64,
        rate: f64,
        ticks: u32,
    ) -> Shaft {
        let mut last = Shaft::default();
        for _ in 0..ticks {
            let point = hub.point(torque, rate, state, 40.0);
            last = hub.finish(&point, rate, state, 1e-3);
        }
        last
    }

    #[test]
    fn it_drives_after_spinning_up_and_never_brakes() {
        let hub = sets::geared_hub();
        let mut state = MotorState::default();
        let first = run(&hub, &mut state, 20.0, 10.0, 1);
        assert!(
            first.torque_nm <= 0.0,
            "the rotor stands still, the wheel turns"
        );
        let settled = run(&hub, &mut state, 20.0, 10.0, 500);
        let drag = hub.coulomb_drag_nm + hub.viscous_drag_nm_s * 10.0;
        let true_constant = 1.0 + hub.machine.torque_constant_error_ratio;
        let expected = 20.0 * true_constant * hub.gear_efficiency_ratio - drag;
        assert!(
            (settled.torque_nm - expected).abs() < 1e-9,
            "{} {expected}",
            settled.torque_nm
        );
        let braking = run(&hub, &mut state, -40.0, 10.0, 500);
        assert!(
            braking.torque_nm > -0.2,
            "a freewheel cannot brake: {}",
            braking.torque_nm
        );
        assert!(state.rotor_rad_s < 10.0, "the rotor coasts down");
    }

    #[test]
    fn friction_in_steady_drive_is_gear_loss_plus_drag() {
        let hub = sets::geared_hub();
        let mut state = MotorState {
            rotor_rad_s: 10.0,
            ..MotorState::default()
        };
        let shaft = run(&hub, &mut state, 20.0, 10.0, 10);
        let gear = 20.0
            * (1.0 + hub.machine.torque_constant_error_ratio)
            * (1.0 - hub.gear_efficiency_ratio);
        let drag = hub.coulomb_drag_nm + hub.viscous_drag_nm_s * 10.0;
        assert!(
            (shaft.friction_w - (gear + drag) * 10.0).abs() < 1e-6,
            "{}",
            shaft.friction_w
        );
    }
}
