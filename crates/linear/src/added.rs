//! What a bicycle has beyond rigid bodies: matrices that are added to those of Whipple and Carvallo,
//! and the named causes that they come from.

use nalgebra::Matrix2;
use std::collections::BTreeMap;

/// Matrices of roll and steer that do not depend on speed, rows first.
#[derive(Debug, Clone, Copy, PartialEq, Default, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Added {
    /// Added to M, kg m².
    pub mass_kg_m2: [[f64; 2]; 2],
    /// Damping, N m s/rad.
    pub damping_nms_rad: [[f64; 2]; 2],
    /// Stiffness, N m/rad.
    pub stiffness_nm_rad: [[f64; 2]; 2],
}

impl Added {
    /// Nothing added.
    pub const NONE: Self = Self {
        mass_kg_m2: [[0.0; 2]; 2],
        damping_nms_rad: [[0.0; 2]; 2],
        stiffness_nm_rad: [[0.0; 2]; 2],
    };

    /// Whether every entry is finite.
    pub fn is_finite(&self) -> bool {
        let all = [self.mass_kg_m2, self.damping_nms_rad, self.stiffness_nm_rad];
        all.iter().flatten().flatten().all(|x| x.is_finite())
    }
}

pub(crate) fn matrix(rows: &[[f64; 2]; 2]) -> Matrix2<f64> {
    Matrix2::new(rows[0][0], rows[0][1], rows[1][0], rows[1][1])
}

/// A cause that a diagnosis accepted. What it changes in parameters and matrices is already in
/// them; what it does besides (friction, lag, wind) acts in rides.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NamedMechanism {
    /// Its name.
    pub name: String,
    /// Whether the residual in its equation became clean.
    pub confirmed: bool,
    /// Values by parameter.
    pub parameters: BTreeMap<String, f64>,
    /// One standard deviation by parameter, where known.
    #[serde(default)]
    pub standard_deviations: BTreeMap<String, f64>,
}
