//! The two bicycles with rider of Bulsink (2017), "Bicycling stability", table A.1.
//!
//! The table is written z up. Its products of inertia follow either the usual tensor (entry =
//! -∫xz dm) or the footnote on Adams (entry = +∫xz dm), and wheel inertias are not given; both are
//! named options here. The rider is rigid and part of the rear body, his arms too (case 1 of the
//! thesis). Gravity 9.81 m/s² is assumed. Bicycle 2's rider is "variable" in the table: here he is
//! bicycle 1's, at the same place.

use crate::bicycle::Bicycle;
use crate::error::BicycleError;
use crate::parameters::Parameters;
use crate::rigid_body::RigidBody;
use core::f64::consts::FRAC_PI_2;

#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Number {
    One,
    Two,
}

/// How the products of inertia of table A.1 are read.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Products {
    /// Entry = -∫xz dm, z up.
    Tensor,
    /// Entry = +∫xz dm, z up: the footnote.
    Adams,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Options {
    products: Products,
    /// Wheel spin inertia over m R².
    wheel_k: f64,
}

impl Default for Options {
    /// Case 1's figures come closest with these; see the tests.
    fn default() -> Self {
        Self {
            products: Products::Adams,
            wheel_k: 0.43,
        }
    }
}

impl Options {
    pub fn parse(set: &str, text: &str) -> Result<Self, BicycleError> {
        let mut options = Self::default();
        for item in text.split(',').filter(|s| !s.is_empty()) {
            match item.split_once('=').map(|(k, v)| (k.trim(), v.trim())) {
                Some(("products", "tensor")) => options.products = Products::Tensor,
                Some(("products", "adams")) => options.products = Products::Adams,
                Some(("wheel_k", v))
                    if v.parse::<f64>().is_ok_and(|k| (0.0..=1.0).contains(&k)) =>
                {
                    options.wheel_k = v.parse().unwrap_or(options.wheel_k);
                }
                _ => {
                    return Err(BicycleError::UnknownOption {
                        set: set.to_owned(),
                        found: item.to_owned(),
                        accepted: "products=tensor, products=adams, wheel_k=NUMBER from 0 to 1"
                            .to_owned(),
                    });
                }
            }
        }
        Ok(options)
    }
}

/// A body as the table has it: z up, off-diagonal entry.
struct Row {
    mass_kg: f64,
    centre_m: [f64; 2],
    /// Ixx, Iyy, Izz and the off-diagonal entry.
    inertia_kg_m2: [f64; 4],
}

impl Row {
    fn body(&self, products: Products) -> RigidBody {
        let [x_m, z_up_m] = self.centre_m;
        let [ixx_kg_m2, iyy_kg_m2, izz_kg_m2, entry] = self.inertia_kg_m2;
        // Here Ixz = -∫xz dm with z down, that is +∫xz dm with z up.
        let ixz_kg_m2 = match products {
            Products::Tensor => -entry,
            Products::Adams => entry,
        };
        RigidBody {
            mass_kg: self.mass_kg,
            x_m,
            z_m: -z_up_m,
            ixx_kg_m2,
            iyy_kg_m2,
            izz_kg_m2,
            ixz_kg_m2,
        }
    }
}

const RIDER: Row = Row {
    mass_kg: 80.0,
    centre_m: [0.39, 1.06],
    inertia_kg_m2: [10.4737, 10.9094, 2.17315, 0.10307],
};

/// Bicycle with rigid rider.
#[allow(non_snake_case)]
pub(crate) fn bicycle(number: Number, options: Options) -> Result<Bicycle, BicycleError> {
    let one = number == Number::One;
    let (w, c, head_rad, mR, mF) = if one {
        (1.150, 0.041, 1.21, 4.01, 3.34)
    } else {
        (1.125, 0.112, 1.18, 4.22, 3.72)
    };
    let (rear, fork) = if one {
        (
            Row {
                mass_kg: 8.30,
                centre_m: [0.320, 0.590],
                inertia_kg_m2: [0.694, 1.105, 0.509, -0.103],
            },
            Row {
                mass_kg: 2.42,
                centre_m: [0.980, 0.720],
                inertia_kg_m2: [0.168, 0.158, 0.046, 0.067],
            },
        )
    } else {
        (
            Row {
                mass_kg: 8.62,
                centre_m: [0.334, 0.466],
                inertia_kg_m2: [0.506, 0.214, 0.612, -0.117],
            },
            Row {
                mass_kg: 3.72,
                centre_m: [0.907, 0.808],
                inertia_kg_m2: [0.272, 0.214, 0.178, 0.146],
            },
        )
    };
    let r = 0.350;
    let spin = |mass: f64| options.wheel_k * mass * r * r;
    let h = fork.body(options.products);
    let mut p = Parameters {
        w,
        c,
        lam: FRAC_PI_2 - head_rad,
        g: 9.81,
        rR: r,
        mR,
        IRxx: 0.5 * spin(mR),
        IRyy: spin(mR),
        mH: h.mass_kg,
        xH: h.x_m,
        zH: h.z_m,
        IHxx: h.ixx_kg_m2,
        IHyy: h.iyy_kg_m2,
        IHzz: h.izz_kg_m2,
        IHxz: h.ixz_kg_m2,
        rF: r,
        mF,
        IFxx: 0.5 * spin(mF),
        IFyy: spin(mF),
        ..Parameters::ZERO
    };
    rear.body(options.products)
        .and(RIDER.body(options.products))
        .store_rear_body(&mut p);
    let name = if one {
        "bulsink2017_bicycle1"
    } else {
        "bulsink2017_bicycle2"
    };
    let source = "V. E. Bulsink (2017), Bicycling stability, University of Twente, table A.1";
    let mut bicycle = Bicycle::new(name, source, p)?;
    let reading = match options.products {
        Products::Tensor => "as the usual tensor, -∫xz dm (products=tensor)",
        Products::Adams => "by the table's footnote, +∫xz dm (products=adams)",
    };
    bicycle
        .remarks
        .push(format!("products of inertia read {reading}"));
    bicycle.remarks.push(format!(
        "wheel inertias are not published: Iyy = {} m R^2, Ixx = Iyy/2 (wheel_k)",
        options.wheel_k
    ));
    if !one {
        bicycle.remarks.push(
            "rider variable in the table: bicycle 1's rider, 80 kg at (0.39, 1.06) m".to_owned(),
        );
        bicycle.remarks.push("Iyy of the rear frame, 0.214 kg m^2, repeats the fork's in the table; it has no influence here".to_owned());
    }
    Ok(bicycle)
}
