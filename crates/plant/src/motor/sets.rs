//! Named parameter sets of drives and batteries.
//!
//! None of them is a data sheet. The hubs are orders of magnitude of motors on sale: speed
//! constants near 9 rpm/V for a 48 V direct drive and line-to-line resistances of 0.1 to 0.2 Ω are
//! what makers and motor simulators state for the class (a motor constant k/√R of 2 to 2.5 Nm/√W for
//! a stator of about 205 mm by 28 mm); drag, cogging, inductance, heat and drive losses are
//! guesses. Their continuous torques (20 to 40 Nm) and peak (80 Nm) follow from them and are
//! checked by a test. Measure your own motor before you quote a figure.

use super::{
    Battery, DirectDrive, DriveParameters, FixedEfficiency, GearedFreewheel, Ideal, IdealSupply,
    LithiumIon, Machine, MotorDrive, PowerTrainParameters, Thermal, Watchdog,
};

/// Names of the sets of [`named`], each with one sentence.
pub const SETS: &[(&str, &str)] = &[
    (
        "ideal",
        "both torques exactly as commanded; no lag, no loss, no limit (the watchdog stays)",
    ),
    (
        "fixed_85_percent",
        "torque as commanded up to 100 Nm, 85 % efficiency each way, no lag",
    ),
    (
        "direct_drive_250w",
        "two direct-drive hubs of the 250 W class (28 mm stator) and a 48 V battery",
    ),
    (
        "direct_drive_heavy",
        "two direct-drive hubs of twice the motor constant squared, 7 to 8 kg each",
    ),
    (
        "geared_rear_250w",
        "direct-drive front hub, geared rear hub with freewheel",
    ),
];

/// The set called `name`.
pub fn named(name: &str) -> Option<PowerTrainParameters> {
    let both = |drive: DriveParameters, battery| PowerTrainParameters {
        front: drive,
        rear: drive,
        battery,
    };
    let instant = |motor| DriveParameters {
        dead_time_s: 0.0,
        lag_s: 0.0,
        watchdog: Watchdog::STANDARD,
        motor,
    };
    let ideal_supply = Battery::Ideal(IdealSupply { voltage_v: 48.0 });
    let battery = Battery::LithiumIon(battery_48v());
    Some(match name {
        "ideal" => both(instant(MotorDrive::Ideal(Ideal {})), ideal_supply),
        "fixed_85_percent" => {
            let motor = FixedEfficiency {
                efficiency_ratio: 0.85,
                peak_nm: 100.0,
            };
            both(instant(MotorDrive::FixedEfficiency(motor)), ideal_supply)
        }
        "direct_drive_250w" => both(real(MotorDrive::DirectDrive(hub_28mm())), battery),
        "direct_drive_heavy" => both(real(MotorDrive::DirectDrive(hub_heavy())), battery),
        "geared_rear_250w" => PowerTrainParameters {
            front: real(MotorDrive::DirectDrive(hub_28mm())),
            rear: real(MotorDrive::GearedFreewheel(geared_hub())),
            battery,
        },
        _ => return None,
    })
}

/// Dead time and lag of a drive on a field bus: 3 ms and 5 ms, a guess.
fn real(motor: MotorDrive) -> DriveParameters {
    DriveParameters {
        dead_time_s: 0.003,
        lag_s: 0.005,
        watchdog: Watchdog::STANDARD,
        motor,
    }
}

/// A direct-drive hub of the 250 W class.
pub fn hub_28mm() -> DirectDrive {
    DirectDrive {
        coulomb_drag_nm: 0.6,
        viscous_drag_nm_s: 0.008,
        cogging_nm: 0.1,
        cogging_cycles: 51,
        machine: Machine {
            torque_constant_nm_per_a: 1.05,
            torque_constant_error_ratio: 0.0,
            resistance_ohm: 0.18,
            inductance_h: 0.5e-3,
            pole_pairs: 23,
            peak_current_a: 76.5,
            field_weakening_a: 15.0,
            modulation_ratio: 0.95,
            bridge_drop_v: 0.3,
            standby_w: 3.0,
            derate_start_celsius: 110.0,
            derate_end_celsius: 150.0,
        },
        thermal: Thermal {
            heat_capacity_j_per_k: 1000.0,
            resistance_k_per_w: 0.55,
            ambient_celsius: 20.0,
        },
    }
}

/// A heavy direct-drive hub.
pub fn hub_heavy() -> DirectDrive {
    let light = hub_28mm();
    DirectDrive {
        coulomb_drag_nm: 1.0,
        viscous_drag_nm_s: 0.014,
        machine: Machine {
            resistance_ohm: 0.09,
            inductance_h: 0.3e-3,
            ..light.machine
        },
        thermal: Thermal {
            heat_capacity_j_per_k: 2000.0,
            resistance_k_per_w: 0.4,
            ..light.thermal
        },
        ..light
    }
}

/// A geared hub of the 250 W class with freewheel.
pub fn geared_hub() -> GearedFreewheel {
    GearedFreewheel {
        gear_ratio: 5.0,
        gear_efficiency_ratio: 0.9,
        rotor_kg_m2: 1.0e-3,
        coulomb_drag_nm: 0.4,
        viscous_drag_nm_s: 0.01,
        freewheel_drag_nm: 0.03,
        machine: Machine {
            torque_constant_nm_per_a: 0.22,
            torque_constant_error_ratio: 0.0,
            resistance_ohm: 0.16,
            inductance_h: 0.2e-3,
            pole_pairs: 8,
            peak_current_a: 36.0,
            field_weakening_a: 0.0,
            modulation_ratio: 0.95,
            bridge_drop_v: 0.3,
            standby_w: 3.0,
            derate_start_celsius: 100.0,
            derate_end_celsius: 130.0,
        },
        thermal: Thermal {
            heat_capacity_j_per_k: 500.0,
            resistance_k_per_w: 1.0,
            ambient_celsius: 20.0,
        },
    }
}

/// 13 cells in series, 14 Ah: 48 V nominal, about 670 Wh.
pub fn battery_48v() -> LithiumIon {
    LithiumIon {
        cells_in_series: 13,
        capacity_ah: 14.0,
        resistance_ohm: 0.12,
        discharge_limit_a: 30.0,
        charge_limit_a: 10.0,
        empty_cell_v: 3.0,
        full_cell_v: 4.2,
        start_charge_ratio: 0.8,
        chopper_w: 0.0,
    }
}
