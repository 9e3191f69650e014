//! The electrical machine and its bridge: torque, voltage limit, losses.
//!
//! What: a permanent-magnet synchronous machine under field-oriented control, quasi-steady.
//!
//! Equation: in the rotor's axes, with line-to-line quantities (so that P = v·i and the limit is
//! the bus voltage),
//!   v_q = R i_q + X i_d + E,  v_d = R i_d - X i_q,  E = k ω,  X = p ω L,  T = k i_q,
//!   |v| <= m V_bus:  a circle about i0 = -E (R, X)/(R² + X²) with radius m V_bus/√(R² + X²);
//!   P = T ω + R (i_q² + i_d²) + v_b |i| + P_0,  R = R_25 (1 + 0.00393 (ϑ - 25)).
//! The current i_d is zero below base speed; above it is the smallest that meets the limit, up to
//! `field_weakening_a`. The command is divided by the nominal k; the torque uses the true one.
//!
//! Source: the two-axis equations of any textbook on synchronous machines, e.g. Krause,
//! Wasynczuk and Sudhoff (2002), Analysis of Electric Machinery and Drive Systems, chapter 4;
//! copper's temperature coefficient 0.00393 1/K at 20-25 °C.
//!
//! Assumes and ignores: no saturation, no saliency, no change of the magnets with heat, current
//! ripple and the current loop's transient (a first-order lag stands for both). Where the
//! back-EMF exceeds what `field_weakening_a` can hold down, the bridge is off and the current
//! zero: rectification through its diodes is ignored.
//!
//! Valid for: wheel rates up to about three times base speed.
//!
//! Checked by: the tests below (energy to 1e-12 relative, voltage limit, no-load speed).

use serde::{Deserialize, Serialize};

use super::{MotorState, OperatingPoint};
use crate::admissible::{OutOfRange, within};

/// Electrical parameters, line to line.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Machine {
    /// Nominal torque constant k, Nm/A; 60/(2π Kv) with Kv in rpm/V.
    pub torque_constant_nm_per_a: f64,
    /// True torque constant over nominal, less one.
    pub torque_constant_error_ratio: f64,
    /// Resistance line to line at 25 °C, with leads and bridge, Ω.
    pub resistance_ohm: f64,
    /// Inductance line to line, H.
    pub inductance_h: f64,
    /// Pairs of magnet poles.
    pub pole_pairs: u32,
    /// Largest torque-producing current, A.
    pub peak_current_a: f64,
    /// Largest field-weakening current, A; 0 for none.
    pub field_weakening_a: f64,
    /// Share of the bus voltage that the bridge can use.
    pub modulation_ratio: f64,
    /// Switching loss of the bridge per ampere, V.
    pub bridge_drop_v: f64,
    /// Consumption of the drive's electronics while it is on, W.
    pub standby_w: f64,
    /// Winding temperature where the current limit begins to fall, °C.
    pub derate_start_celsius: f64,
    /// Winding temperature where the current limit is zero, °C.
    pub derate_end_celsius: f64,
}

const COPPER_PER_K: f64 = 0.00393;

impl Machine {
    /// Checks every parameter.
    pub fn validate(&self) -> Result<(), OutOfRange> {
        within(
            "torque_constant_nm_per_a",
            self.torque_constant_nm_per_a,
            1e-3,
            100.0,
        )?;
        within(
            "torque_constant_error_ratio",
            self.torque_constant_error_ratio,
            -0.5,
            0.5,
        )?;
        within("resistance_ohm", self.resistance_ohm, 1e-4, 100.0)?;
        within("inductance_h", self.inductance_h, 0.0, 1.0)?;
        within("pole_pairs", f64::from(self.pole_pairs), 1.0, 200.0)?;
        within("peak_current_a", self.peak_current_a, 0.0, 1000.0)?;
        within("field_weakening_a", self.field_weakening_a, 0.0, 1000.0)?;
        within("modulation_ratio", self.modulation_ratio, 0.1, 1.0)?;
        within("bridge_drop_v", self.bridge_drop_v, 0.0, 10.0)?;
        within("standby_w", self.standby_w, 0.0, 100.0)?;
        within(
            "derate_start_celsius",
            self.derate_start_celsius,
            -40.0,
            300.0,
        )?;
        within(
            "derate_end_celsius",
            self.derate_end_celsius,
            self.derate_start_celsius,
            300.0,
        )
    }

    /// Where the machine runs when `torque_nm` is asked for at `rate_rad_s`, both of its own rotor.
    pub fn point(
        &self,
        torque_nm: f64,
        rate_rad_s: f64,
        state: &MotorState,
        bus_v: f64,
    ) -> OperatingPoint {
        let k = self.torque_constant_nm_per_a * (1.0 + self.torque_constant_error_ratio);
        let r = self.resistance_ohm * (1.0 + COPPER_PER_K * (state.winding_celsius - 25.0));
        let e = k * rate_rad_s;
        let x = f64::from(self.pole_pairs) * rate_rad_s * self.inductance_h;

        // current limit with derating
        let span = self.derate_end_celsius - self.derate_start_celsius;
        let cool = if state.winding_celsius <= self.derate_start_celsius {
            1.0
        } else if span > 0.0 {
            ((self.derate_end_celsius - state.winding_celsius) / span).max(0.0)
        } else {
            0.0
        };
        let wanted = torque_nm / self.torque_constant_nm_per_a;
        let mut q = wanted.clamp(-self.peak_current_a, self.peak_current_a);
        let current_limited = q != wanted;
        let thermal = self.peak_current_a * cool;
        let heat_limited = q.abs() > thermal;
        q = q.clamp(-thermal, thermal);

        // |I - i0| <= m V/|Z|
        let z2 = r * r + x * x;
        let (q0, d0) = (-e * r / z2, -e * x / z2);
        let radius = self.modulation_ratio * bus_v.max(0.0) / libm::sqrt(z2);
        let best_d = d0.clamp(-self.field_weakening_a, 0.0);
        let width2 = radius * radius - (best_d - d0) * (best_d - d0);
        if width2 < 0.0 {
            return OperatingPoint {
                voltage_limited: true,
                ..OperatingPoint::OFF
            };
        }
        let width = libm::sqrt(width2);
        let held = q.clamp(q0 - width, q0 + width);
        let voltage_limited = held != q;
        q = held;
        let room2 = radius * radius - (q - q0) * (q - q0);
        let d = (d0 + libm::sqrt(room2.max(0.0))).clamp(-self.field_weakening_a, 0.0);

        let current2 = q * q + d * d;
        let copper_w = r * current2;
        let bridge_w = self.bridge_drop_v * libm::sqrt(current2);
        OperatingPoint {
            motor_nm: k * q,
            current_a: q,
            field_a: d,
            copper_w,
            drive_w: bridge_w + self.standby_w,
            electrical_w: e * q + copper_w + bridge_w + self.standby_w,
            on: true,
            current_limited,
            voltage_limited,
            heat_limited,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motor::sets;

    fn machine() -> Machine {
        sets::hub_28mm().machine
    }

    fn state(celsius: f64) -> MotorState {
        MotorState {
            winding_celsius: celsius,
            ..MotorState::default()
        }
    }

    #[test]
    fn electrical_power_is_mechanical_power_plus_losses_and_the_voltage_fits() {
        let m = machine();
        for torque in [-80.0, -30.0, -1.0, 0.0, 5.0, 60.0, 120.0] {
            for rate in [-20.0, 0.0, 1.0, 14.0, 35.0, 60.0] {
                let p = m.point(torque, rate, &state(25.0), 48.0);
                let sum = p.motor_nm * rate + p.copper_w + p.drive_w;
                assert!(
                    (p.electrical_w - sum).abs() <= 1e-12 * (1.0 + sum.abs()),
                    "{torque} {rate}"
                );
                if p.on {
                    let (r, x) = (
                        m.resistance_ohm,
                        f64::from(m.pole_pairs) * rate * m.inductance_h,
                    );
                    let e =
                        m.torque_constant_nm_per_a * (1.0 + m.torque_constant_error_ratio) * rate;
                    let vq = r * p.current_a + x * p.field_a + e;
                    let vd = r * p.field_a - x * p.current_a;
                    let limit = m.modulation_ratio * 48.0;
                    assert!(
                        libm::hypot(vq, vd) <= limit * (1.0 + 1e-9),
                        "{torque} {rate}"
                    );
                }
            }
        }
    }

    #[test]
    fn without_field_weakening_drive_torque_ends_at_the_no_load_speed() {
        let m = Machine {
            field_weakening_a: 0.0,
            torque_constant_error_ratio: 0.0,
            ..machine()
        };
        let no_load = m.modulation_ratio * 48.0 / m.torque_constant_nm_per_a;
        assert!(m.point(80.0, 0.999 * no_load, &state(25.0), 48.0).motor_nm > 0.0);
        assert!(m.point(80.0, 1.001 * no_load, &state(25.0), 48.0).motor_nm <= 0.0);
        let weak = Machine {
            field_weakening_a: 30.0,
            ..m
        };
        assert!(
            weak.point(80.0, 1.001 * no_load, &state(25.0), 48.0)
                .motor_nm
                > 0.0
        );
    }

    #[test]
    fn a_hot_winding_loses_its_current_and_a_warm_one_costs_more() {
        let m = machine();
        let cold = m.point(20.0, 10.0, &state(25.0), 48.0);
        let warm = m.point(20.0, 10.0, &state(100.0), 48.0);
        assert!((warm.copper_w / cold.copper_w - (1.0 + 0.00393 * 75.0)).abs() < 1e-9);
        assert_eq!(
            m.point(20.0, 10.0, &state(m.derate_end_celsius), 48.0)
                .motor_nm,
            0.0
        );
    }
}
