//! Battery and bus.
//!
//! What: one battery behind one bus for both drives. Equation: V = U(s) - R i, P = V i, so
//! i = (U - √(U² - 4 R P))/(2R); ds/dt = -i/Q; limits: current both ways, lowest and highest
//! voltage. Power that the battery refuses goes into the brake chopper as far as it reaches;
//! beyond that the drives brake less. Source: first-order cell model; the open-circuit curve is
//! the shape of NMC/graphite cells at 25 °C, from general knowledge to about 50 mV: a guess,
//! not a data sheet. Assumes and ignores: no polarisation dynamics, no temperature, no ageing,
//! all charge comes back. Valid for: rides of minutes to hours. Checked by: the tests below.

use serde::{Deserialize, Serialize};

use crate::admissible::{OutOfRange, within};
use crate::explain::Explain;

/// A kind of supply.
pub trait BatteryModel {
    /// What it is, for users.
    fn explain(&self) -> Explain;
    /// Checks every parameter.
    fn validate(&self) -> Result<(), OutOfRange>;
    /// Open-circuit voltage at a state of charge, V.
    fn open_circuit_v(&self, charge_ratio: f64) -> f64;
    /// Internal resistance, Ω.
    fn resistance_ohm(&self) -> f64;
    /// Charge of a full battery, C; infinite for a supply that never empties.
    fn capacity_c(&self) -> f64;
    /// Largest currents out and in at a state of charge, A.
    fn limits_a(&self, charge_ratio: f64) -> (f64, f64);
    /// State of charge at the start.
    fn start_charge_ratio(&self) -> f64;
    /// Largest power of the brake chopper, W.
    fn chopper_w(&self) -> f64;
}

/// A constant voltage without limits.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct IdealSupply {
    /// Voltage, V.
    pub voltage_v: f64,
}

/// A lithium-ion battery.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LithiumIon {
    /// Cells in series.
    pub cells_in_series: u32,
    /// Capacity, Ah.
    pub capacity_ah: f64,
    /// Internal resistance with wiring and protection circuit, Ω.
    pub resistance_ohm: f64,
    /// Largest current out, A.
    pub discharge_limit_a: f64,
    /// Largest current in, A; 0 for a battery that refuses regeneration.
    pub charge_limit_a: f64,
    /// Lowest voltage of a cell, V.
    pub empty_cell_v: f64,
    /// Highest voltage of a cell, V.
    pub full_cell_v: f64,
    /// State of charge at the start, 0 empty to 1 full.
    pub start_charge_ratio: f64,
    /// Largest power of a brake chopper on the bus, W; 0 for none.
    pub chopper_w: f64,
}

twinhub_types::registry! {
    /// The supplies.
    #[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
    #[serde(rename_all = "snake_case")]
    pub enum Battery: BatteryModel {
        /// Constant voltage, no limits.
        Ideal(IdealSupply) = "ideal",
        /// Lithium-ion cells.
        LithiumIon(LithiumIon) = "lithium_ion",
    }
    fn explain(&self) -> Explain;
    fn validate(&self) -> Result<(), OutOfRange>;
    fn open_circuit_v(&self, charge_ratio: f64) -> f64;
    fn resistance_ohm(&self) -> f64;
    fn capacity_c(&self) -> f64;
    fn limits_a(&self, charge_ratio: f64) -> (f64, f64);
    fn start_charge_ratio(&self) -> f64;
    fn chopper_w(&self) -> f64;
}

impl BatteryModel for IdealSupply {
    fn explain(&self) -> Explain {
        Explain {
            name: "ideal",
            what: "a supply of constant voltage that gives and takes any current",
            equation: "V = constant",
            source: "definition",
            assumes: "everything; for comparisons of the bicycle's physics alone",
        }
    }
    fn validate(&self) -> Result<(), OutOfRange> {
        within("voltage_v", self.voltage_v, 1.0, 1000.0)
    }
    fn open_circuit_v(&self, _: f64) -> f64 {
        self.voltage_v
    }
    fn resistance_ohm(&self) -> f64 {
        0.0
    }
    fn capacity_c(&self) -> f64 {
        f64::INFINITY
    }
    fn limits_a(&self, _: f64) -> (f64, f64) {
        (f64::INFINITY, f64::INFINITY)
    }
    fn start_charge_ratio(&self) -> f64 {
        0.5
    }
    fn chopper_w(&self) -> f64 {
        0.0
    }
}

/// Open-circuit voltage of one cell at 0, 0.1 .. 1 of its charge, V.
const CELL_V: [f64; 11] = [
    3.00, 3.43, 3.53, 3.59, 3.63, 3.68, 3.76, 3.86, 3.96, 4.06, 4.18,
];

impl BatteryModel for LithiumIon {
    fn explain(&self) -> Explain {
        Explain {
            name: "lithium_ion",
            what: "lithium-ion cells in series with state of charge, resistance and limits both ways",
            equation: "V = U(s) - R i, ds/dt = -i/Q, |i| and V limited",
            source: "first-order cell model; curve of NMC/graphite cells from general knowledge (about 50 mV)",
            assumes: "no polarisation dynamics, no temperature, no ageing",
        }
    }
    fn validate(&self) -> Result<(), OutOfRange> {
        within(
            "cells_in_series",
            f64::from(self.cells_in_series),
            1.0,
            100.0,
        )?;
        within("capacity_ah", self.capacity_ah, 0.01, 1000.0)?;
        within("resistance_ohm", self.resistance_ohm, 0.0, 10.0)?;
        within("discharge_limit_a", self.discharge_limit_a, 0.0, 1000.0)?;
        within("charge_limit_a", self.charge_limit_a, 0.0, 1000.0)?;
        within("empty_cell_v", self.empty_cell_v, 2.0, 3.7)?;
        within("full_cell_v", self.full_cell_v, 3.7, 4.5)?;
        within("start_charge_ratio", self.start_charge_ratio, 0.0, 1.0)?;
        within("chopper_w", self.chopper_w, 0.0, 1e5)
    }
    fn open_circuit_v(&self, charge_ratio: f64) -> f64 {
        let x = charge_ratio.clamp(0.0, 1.0) * 10.0;
        let i = (x as usize).min(9);
        let cell = CELL_V[i] + (CELL_V[i + 1] - CELL_V[i]) * (x - i as f64);
        cell * f64::from(self.cells_in_series)
    }
    fn resistance_ohm(&self) -> f64 {
        self.resistance_ohm
    }
    fn capacity_c(&self) -> f64 {
        self.capacity_ah * 3600.0
    }
    fn limits_a(&self, charge_ratio: f64) -> (f64, f64) {
        let cells = f64::from(self.cells_in_series);
        let open_v = self.open_circuit_v(charge_ratio);
        let by_voltage = |span_v: f64| {
            if self.resistance_ohm > 0.0 {
                span_v.max(0.0) / self.resistance_ohm
            } else if span_v > 0.0 {
                f64::INFINITY
            } else {
                0.0
            }
        };
        // The most that a resistance lets out is at half the open-circuit voltage.
        let most = by_voltage(0.5 * open_v);
        let out = self
            .discharge_limit_a
            .min(by_voltage(open_v - cells * self.empty_cell_v))
            .min(most);
        let into = self
            .charge_limit_a
            .min(by_voltage(cells * self.full_cell_v - open_v));
        (
            if charge_ratio <= 0.0 { 0.0 } else { out },
            if charge_ratio >= 1.0 { 0.0 } else { into },
        )
    }
    fn start_charge_ratio(&self) -> f64 {
        self.start_charge_ratio
    }
    fn chopper_w(&self) -> f64 {
        self.chopper_w
    }
}

/// Energy through the battery's terminals since the start.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BusEnergy {
    /// Given out, J.
    pub out_j: f64,
    /// Taken in, J.
    pub in_j: f64,
    /// Burnt in the chopper, J.
    pub burnt_j: f64,
    /// Lost in the battery's resistance, J.
    pub resistance_j: f64,
}

impl BusEnergy {
    /// Given out less taken in, J.
    pub fn net_j(&self) -> f64 {
        self.out_j - self.in_j
    }
}

/// The battery in use.
#[derive(Clone, Copy, Debug)]
pub struct Bus {
    battery: Battery,
    charge_ratio: f64,
    voltage_v: f64,
    current_a: f64,
    energy: BusEnergy,
}

impl Bus {
    /// A bus at rest.
    pub fn new(battery: Battery) -> Result<Self, OutOfRange> {
        battery.validate()?;
        let charge_ratio = battery.start_charge_ratio();
        let voltage_v = battery.open_circuit_v(charge_ratio);
        Ok(Self {
            battery,
            charge_ratio,
            voltage_v,
            current_a: 0.0,
            energy: BusEnergy::default(),
        })
    }

    /// Voltage at the end of the last tick, V.
    pub fn voltage_v(&self) -> f64 {
        self.voltage_v
    }

    /// Current of the last tick, positive out of the battery, A.
    pub fn current_a(&self) -> f64 {
        self.current_a
    }

    /// State of charge, 0 empty to 1 full.
    pub fn charge_ratio(&self) -> f64 {
        self.charge_ratio
    }

    /// Energy counters.
    pub fn energy(&self) -> &BusEnergy {
        &self.energy
    }

    /// Largest power that the drives may take, and give, in this tick, W; the chopper counts.
    pub fn limits_w(&self) -> (f64, f64) {
        let open_v = self.battery.open_circuit_v(self.charge_ratio);
        let r = self.battery.resistance_ohm();
        let (out_a, in_a) = self.battery.limits_a(self.charge_ratio);
        let out_w = if out_a.is_finite() {
            (open_v - r * out_a) * out_a
        } else {
            f64::INFINITY
        };
        let in_w = if in_a.is_finite() {
            (open_v + r * in_a) * in_a
        } else {
            f64::INFINITY
        };
        (out_w, in_w + self.battery.chopper_w())
    }

    /// One tick in which the drives take `power_w` (negative: give).
    pub fn step(&mut self, power_w: f64, step_s: f64) {
        let open_v = self.battery.open_circuit_v(self.charge_ratio);
        let r = self.battery.resistance_ohm();
        let (_, in_a) = self.battery.limits_a(self.charge_ratio);
        let accepted_w = if in_a.is_finite() {
            (open_v + r * in_a) * in_a
        } else {
            f64::INFINITY
        };
        let burnt_w = (-power_w - accepted_w).clamp(0.0, self.battery.chopper_w());
        let battery_w = power_w + burnt_w;
        // P = (U - R i) i, the root that vanishes with P; a power beyond U²/4R is held there
        let root = libm::sqrt((open_v * open_v - 4.0 * r * battery_w).max(0.0));
        let current_a = 2.0 * battery_w / (open_v + root);
        self.current_a = current_a;
        self.voltage_v = open_v - r * current_a;
        let charge = self.charge_ratio - current_a * step_s / self.battery.capacity_c();
        self.charge_ratio = charge.clamp(0.0, 1.0);
        self.energy.out_j += battery_w.max(0.0) * step_s;
        self.energy.in_j += (-battery_w).max(0.0) * step_s;
        self.energy.burnt_j += burnt_w * step_s;
        self.energy.resistance_j += r * current_a * current_a * step_s;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motor::sets;

    #[test]
    fn voltage_times_current_is_the_power_both_ways() {
        for power in [-300.0, -10.0, 0.0, 50.0, 900.0] {
            let mut bus = Bus::new(Battery::LithiumIon(sets::battery_48v())).unwrap();
            bus.step(power, 1e-3);
            assert!(
                (bus.voltage_v() * bus.current_a() - power).abs() < 1e-9,
                "{power}"
            );
        }
    }

    #[test]
    fn a_full_battery_refuses_and_the_chopper_burns() {
        let full = LithiumIon {
            start_charge_ratio: 1.0,
            chopper_w: 0.0,
            ..sets::battery_48v()
        };
        let bus = Bus::new(Battery::LithiumIon(full)).unwrap();
        assert_eq!(bus.limits_w().1, 0.0);
        let chopper = LithiumIon {
            chopper_w: 500.0,
            ..full
        };
        let mut bus = Bus::new(Battery::LithiumIon(chopper)).unwrap();
        assert_eq!(bus.limits_w().1, 500.0);
        bus.step(-400.0, 1.0);
        assert_eq!(bus.energy().burnt_j, 400.0);
        assert_eq!(bus.energy().in_j, 0.0);
        assert_eq!(bus.charge_ratio(), 1.0);
    }

    #[test]
    fn charge_counts_current_and_the_curve_rises() {
        let battery = Battery::LithiumIon(sets::battery_48v());
        let mut bus = Bus::new(battery).unwrap();
        let start = bus.charge_ratio();
        let mut charge_c = 0.0;
        for _ in 0..10_000 {
            bus.step(300.0, 0.1);
            charge_c += bus.current_a() * 0.1;
        }
        let used = (start - bus.charge_ratio()) * battery.capacity_c();
        assert!(
            (used - charge_c).abs() < 1e-6 * charge_c,
            "{used} {charge_c}"
        );
        let mut last = 0.0;
        for i in 0..=100 {
            let v = battery.open_circuit_v(f64::from(i) / 100.0);
            assert!(v > last);
            last = v;
        }
    }
}
