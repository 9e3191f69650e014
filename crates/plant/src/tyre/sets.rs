//! Parameter sets that ship, by the name of their publication.

use super::{
    Combined, Friction, LateralForm, MagicFormula, NoSlip, Tyre,
    Vertical,
};

/// A parameter set with its name and origin.
#[derive(Clone, Copy, Debug)]
pub struct TyreSet {
    /// Name, for TOML and command line.
    pub name: &'static str,
    /// What it is and where it comes from.
    pub about: &'static str,
    /// The tyre.
    pub tyre: Tyre,
}

/// The set called `name`; the name of a registry entry gives its first set.
pub fn set(name: &str) -> Option<&'static TyreSet> {
    SETS.iter()
        .find(|set| set.name == name)
        .or_else(|| SETS.iter().find(|set| set.tyre.name() == name))
}

/// Vertical spring and damper of Bulsink (2017), table A.1.
const BULSINK_VERTICAL: Vertical = Vertical { stiffness_n_m: 108_970.0, damping_n_s_m: 5_448.0 };

/// Bulsink (2017), table A3: tyre 2 (37-622), 4 bar, 400 N.
const BULSINK_400N: MagicFormula = MagicFormula {
    nominal_load_n: 400.0,
    longitudinal_shape_ratio: 1.0,
    longitudinal_friction_ratio: 1.642,
    longitudinal_stiffness_ratio: 12.0,
    slip_shape_ratio: 0.990,
    camber_shape_ratio: 1.0,
    lateral_friction_ratio: 1.642,
    lateral_friction_load_ratio: -0.017,
    cornering_max_per_rad: -16.07,
    cornering_peak_ratio: 1.011,
    camber_stiffness_per_rad: -1.444,
    camber_stiffness_load_per_rad: -0.510,
    trail_slope_per_rad: 73.49,
    trail_slope_load_per_rad: -87.36,
    trail_shape_ratio: 1.0,
    trail_peak_ratio: 0.054,
    trail_peak_load_ratio: -0.043,
    twisting_per_rad: -0.134,
    twisting_load_per_rad: 0.084,
    rolling_resistance_ratio: 0.008,
    overturning_ratio: 0.053,
    longitudinal_gain: 1.0,
    cornering_gain: 1.0,
    camber_gain: 1.0,
    trail_gain: 1.0,
    twisting_gain: 1.0,
    overturning_gain: 1.0,
    friction: Friction::AsFile,
    combined: Combined::None,
    lateral_form: LateralForm::Motorcycle,
    frozen_load_n: None,
    load_range_n: None,
    vertical: BULSINK_VERTICAL,
    relaxation_length_m: None,
};

/// Every set that ships.
pub const SETS: &[TyreSet] = &[
    TyreSet {
        name: "bulsink2017",
        about: "Bulsink 2017, table A3: tyre 2 (37-622) at 4 bar, coefficients follow load",
        tyre: Tyre::MagicFormula(BULSINK_400N),
    },
    TyreSet { name: "no_slip", about: "rolls without slip, by constraint", tyre: Tyre::NoSlip(NoSlip {}) },
];
