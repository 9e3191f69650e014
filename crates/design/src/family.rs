//! What: the bicycles that a certificate speaks of: one bicycle and what may differ from it.
//!
//! Equation: x' = A x + b T_steer with A and b of the multibody model at each corner of a box in
//! mass, tyre load and twisting torque, at a speed and a pair.
//!
//! Source: `twinhub_plant::rider::LateralBicycle`.
//!
//! Assumes and ignores: mass is that of the rider, masses and inertias alike; tyre load is a factor
//! on every side force and moment of both tyres; the twisting torque has a factor of its own.
//! Friction does not enter the matrices: it limits the pair.
//!
//! Valid for: straight riding at steady speed.
//!
//! Checked by: `tests/certificate.rs`.

use crate::DesignError;
use nalgebra::{DMatrix, DVector, RowDVector};
use serde::{Deserialize, Serialize};
use twinhub_plant::multibody::{Body, Multibody, Parameters};
use twinhub_plant::rider::LateralBicycle;
use twinhub_plant::tyre::Tyre;

/// Least half width of a box in which a Lyapunov matrix is looked for, as a share.
const LEAST_SHARE: f64 = 0.05;
/// Least ratio of twisting torque from its middle.
const LEAST_RATIO: f64 = 1.1;

/// Factors on a bicycle: 1 is the bicycle as it is.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Factors {
    /// On the mass and inertia of the rider.
    pub mass: f64,
    /// On side forces and moments of both tyres.
    pub load: f64,
    /// On the twisting torque of both tyres.
    pub twisting: f64,
}

/// A box of factors, from and to.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FactorBox {
    /// On the mass and inertia of the rider.
    pub mass: [f64; 2],
    /// On side forces and moments of both tyres.
    pub load: [f64; 2],
    /// On the twisting torque of both tyres.
    pub twisting: [f64; 2],
}

impl FactorBox {
    /// Its corners: each once, in a fixed order.
    pub fn corners(&self) -> Vec<Factors> {
        let ends = |[a, b]: [f64; 2]| if a == b { vec![a] } else { vec![a, b] };
        let mut corners = Vec::new();
        for mass in ends(self.mass) {
            for load in ends(self.load) {
                for twisting in ends(self.twisting) {
                    corners.push(Factors {
                        mass,
                        load,
                        twisting,
                    });
                }
            }
        }
        corners
    }

    /// The box cut into `parts` along mass, load and twisting: evenly, twisting by equal ratios.
    pub fn split(&self, parts: [usize; 3]) -> Vec<Self> {
        // The last part ends where the whole does, whatever the rounding.
        let cut = |n: usize, end: f64, at: &dyn Fn(f64) -> f64| -> Vec<[f64; 2]> {
            let at = |i: usize| at(i as f64);
            (0..n)
                .map(|i| [at(i), if i + 1 == n { end } else { at(i + 1) }])
                .collect()
        };
        let even = |[a, b]: [f64; 2], n: usize| cut(n, b, &|i| a + (b - a) * i / n as f64);
        let ratio = |[a, b]: [f64; 2], n: usize| cut(n, b, &|i| a * libm::pow(b / a, i / n as f64));
        let mut boxes = Vec::new();
        for mass in even(self.mass, parts[0]) {
            for load in even(self.load, parts[1]) {
                for twisting in ratio(self.twisting, parts[2]) {
                    boxes.push(Self {
                        mass,
                        load,
                        twisting,
                    });
                }
            }
        }
        boxes
    }

    /// The box, no narrower than [`LEAST_SHARE`] and [`LEAST_RATIO`] about its middle: what is found for
    /// it holds for less, and a matrix that bears some change suits the next speed too.
    pub fn widened(&self) -> Self {
        let even = |[a, b]: [f64; 2]| {
            let (middle, half) = (0.5 * (a + b), 0.5 * (b - a));
            let half = half.max(LEAST_SHARE * middle);
            [middle - half, middle + half]
        };
        let [a, b] = self.twisting;
        let (middle, ratio) = (libm::sqrt(a * b), libm::sqrt(b / a).max(LEAST_RATIO));
        Self {
            mass: even(self.mass),
            load: even(self.load),
            twisting: [middle / ratio, middle * ratio],
        }
    }

    /// Its middle.
    pub fn middle(&self) -> Factors {
        let middle = |[a, b]: [f64; 2]| 0.5 * (a + b);
        Factors {
            mass: middle(self.mass),
            load: middle(self.load),
            twisting: middle(self.twisting),
        }
    }
}

/// The lateral part of a bicycle, as a rider meets it.
#[derive(Clone, Debug)]
pub struct Vehicle {
    /// State matrix, n by n.
    pub a: DMatrix<f64>,
    /// What a torque on the bar does, n.
    pub b: DVector<f64>,
    /// Rows for roll, roll rate, steer and steer rate, n each.
    pub perceived: [RowDVector<f64>; 4],
}

/// A bicycle that can be had with other factors.
#[derive(Clone, Debug)]
pub struct Family {
    parameters: Parameters,
}

impl Family {
    /// Around this bicycle.
    pub fn new(parameters: Parameters) -> Self {
        Self { parameters }
    }

    /// The bicycle itself.
    pub fn parameters(&self) -> &Parameters {
        &self.parameters
    }

    /// The bicycle with these factors.
    ///
    /// # Errors
    /// If a parameter leaves its range.
    pub fn member(&self, factors: &Factors) -> Result<Member, DesignError> {
        let mut p = self.parameters.clone();
        let rider = &mut p.rider;
        for body in [&mut rider.pelvis, &mut rider.trunk, &mut rider.forearms] {
            scale_body(body, factors.mass);
        }
        let (leg, f) = (&mut rider.leg, factors.mass);
        for value in [
            &mut leg.mass_kg,
            &mut leg.inertia_xx_kg_m2,
            &mut leg.inertia_yy_kg_m2,
            &mut leg.inertia_zz_kg_m2,
            &mut leg.inertia_xy_kg_m2,
            &mut leg.inertia_xz_kg_m2,
            &mut leg.inertia_yz_kg_m2,
        ] {
            *value *= f;
        }
        for tyre in [&mut p.tyre.rear, &mut p.tyre.front] {
            scale_tyre(tyre, factors);
        }
        let model = Multibody::new(&p).map_err(|e| DesignError::Model(e.to_string()))?;
        Ok(Member { model })
    }
}

/// One bicycle of a family.
pub struct Member {
    model: Multibody,
}

impl Member {
    /// Its lateral part at a speed and a pair.
    ///
    /// # Errors
    /// If there is no steady state there.
    pub fn at(&self, speed_m_s: f64, pair_nm: f64) -> Result<Vehicle, DesignError> {
        let lateral = LateralBicycle::new(&self.model, speed_m_s, pair_nm).map_err(|e| {
            DesignError::Model(format!("at {speed_m_s} m/s under {pair_nm} Nm: {e}"))
        })?;
        Ok(Vehicle {
            a: lateral.state_matrix().clone(),
            b: lateral.steer_torque().clone(),
            perceived: lateral.perceived(),
        })
    }
}

fn scale_body(body: &mut Body, factor: f64) {
    for value in [
        &mut body.mass_kg,
        &mut body.inertia_xx_kg_m2,
        &mut body.inertia_yy_kg_m2,
        &mut body.inertia_zz_kg_m2,
        &mut body.inertia_xz_kg_m2,
    ] {
        *value *= factor;
    }
}

fn scale_tyre(tyre: &mut Tyre, factors: &Factors) {
    let (load, twisting) = (factors.load, factors.load * factors.twisting);
    match tyre {
        Tyre::MagicFormula(t) => {
            t.cornering_gain *= load;
            t.camber_gain *= load;
            t.trail_gain *= load;
            t.overturning_gain *= load;
            t.twisting_gain *= twisting;
        }
        Tyre::MagicFormula1989(t) => {
            t.cornering_gain *= load;
            t.camber_gain *= load;
            t.trail_gain *= load;
            t.twisting_gain *= twisting;
        }
        Tyre::Linear(t) => {
            t.cornering_stiffness_per_rad *= load;
            t.camber_stiffness_per_rad *= load;
            t.twisting_m_per_rad *= twisting;
        }
        // Forces of constraints do not read these.
        Tyre::NoSlip(_) => {}
    }
}
