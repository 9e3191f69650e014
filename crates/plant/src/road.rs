//! What: the surface that a bicycle rides on: slope, bank, bumps, and friction that changes.
//!
//! Equation: height(x, y) = x tan(slope) - y tan(bank) + Σ bumps(x), upwards; friction is that of
//! the last patch that covers the spot, else that of the road, blended over the patch's edge.
//!
//! Source: bump shapes are elementary; random roughness is ISO 8608:2016,
//! Gd(n) = Gd(n0) (n0 / n)² with n0 = 0.1 cycles/m (road class A: 16e-6 m³, C: 256e-6 m³).
//!
//! Assumes and ignores: bumps run across the whole width; the tyre touches at one point, so a
//! bump shorter than the contact patch (about 0.1 m) is felt sharper than in reality.
//!
//! Valid for: slope and bank up to 0.35 rad (20°).
//!
//! Checked by: gradients against differences (1e-6), variance of the roughness against the
//! integral of its spectrum (10 %), TOML round trip, refusal of impossible roads.

mod bump;

pub(crate) use bump::uniform;
pub use bump::{BUMPS, Bump, BumpModel, CosineBump, Roughness, Step};

use crate::Scalar;
use serde::{Deserialize, Serialize};
use thiserror::Error;

/// A road. World axes: x along the road, y to the right, heights upwards.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Road {
    /// Friction coefficient where no patch is.
    pub friction_ratio: f64,
    /// Positive climbs along x, rad.
    #[serde(default)]
    pub slope_rad: f64,
    /// Positive falls to the right, rad.
    #[serde(default)]
    pub bank_rad: f64,
    /// Patches of other friction; where two overlap, the later one holds.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub patches: Vec<Patch>,
    /// Bumps; heights add up.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub bumps: Vec<Bump>,
}

/// A rectangle of other friction. A road that is slippery on one side only is a patch with
/// `y_m = [0.0, 10.0]`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Patch {
    /// Where it begins and ends along the road, m.
    pub x_m: [f64; 2],
    /// Where it begins and ends across, left to right, m; absent: the whole width.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub y_m: Option<[f64; 2]>,
    /// Friction coefficient.
    pub friction_ratio: f64,
    /// Length over which friction changes, centred on the border, m.
    pub edge_m: f64,
}

/// Why a road is refused.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum RoadError {
    /// A parameter lies outside its range.
    #[error("road: {parameter} is {found}; accepted: {accepted}")]
    OutOfRange {
        /// Name of the parameter.
        parameter: &'static str,
        /// What was found.
        found: f64,
        /// What would be accepted.
        accepted: &'static str,
    },
}

/// Height of the road at a spot, with its gradient.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surface<T> {
    /// Height, upwards, m.
    pub height_m: T,
    /// Its slope along x.
    pub along_ratio: T,
    /// Its slope along y (to the right).
    pub across_ratio: T,
}

impl Road {
    /// A level, smooth road.
    pub const fn level(friction_ratio: f64) -> Self {
        Self {
            friction_ratio,
            slope_rad: 0.0,
            bank_rad: 0.0,
            patches: Vec::new(),
            bumps: Vec::new(),
        }
    }

    /// True if height is zero everywhere.
    #[inline]
    pub fn is_level(&self) -> bool {
        self.slope_rad == 0.0 && self.bank_rad == 0.0 && self.bumps.is_empty()
    }

    /// Height and gradient at (`x_m`, `y_m`).
    #[inline]
    pub fn surface<T: Scalar>(&self, x_m: T, y_m: T) -> Surface<T> {
        let zero = T::zero();
        let mut spot = Surface {
            height_m: zero,
            along_ratio: zero,
            across_ratio: zero,
        };
        if self.is_level() {
            return spot;
        }
        let (rise, fall) = (libm::tan(self.slope_rad), libm::tan(self.bank_rad));
        spot.height_m = x_m.scale(rise) - y_m.scale(fall);
        spot.along_ratio = T::from_f64(rise);
        spot.across_ratio = T::from_f64(-fall);
        for bump in &self.bumps {
            let (height_m, slope_ratio) = bump.profile(x_m);
            spot.height_m += height_m;
            spot.along_ratio += slope_ratio;
        }
        spot
    }

    /// Height at (`x_m`, `y_m`), upwards, m.
    #[inline]
    pub fn height_m<T: Scalar>(&self, x_m: T, y_m: T) -> T {
        self.surface(x_m, y_m).height_m
    }

    /// Friction coefficient at (`x_m`, `y_m`).
    #[inline]
    pub fn friction_ratio<T: Scalar>(&self, x_m: T, y_m: T) -> T {
        let mut friction = T::from_f64(self.friction_ratio);
        for patch in &self.patches {
            let mut share = inside(x_m, patch.x_m, patch.edge_m);
            if let Some(width) = patch.y_m {
                share = share * inside(y_m, width, patch.edge_m);
            }
            friction = friction + share * (T::from_f64(patch.friction_ratio) - friction);
        }
        friction
    }

    /// Refuses a road that cannot be.
    pub fn validate(&self) -> Result<(), RoadError> {
        friction("friction_ratio", self.friction_ratio)?;
        within(
            "slope_rad",
            self.slope_rad,
            -0.35,
            0.35,
            "-0.35 to 0.35 rad",
        )?;
        within("bank_rad", self.bank_rad, -0.35, 0.35, "-0.35 to 0.35 rad")?;
        for patch in &self.patches {
            friction("patches.friction_ratio", patch.friction_ratio)?;
            within(
                "patches.edge_m",
                patch.edge_m,
                0.0,
                f64::MAX,
                "finite, zero or above",
            )?;
            for [from, to] in [Some(patch.x_m), patch.y_m].into_iter().flatten() {
                within("patches.from", from, f64::MIN, f64::MAX, "finite")?;
                within(
                    "patches.to",
                    to,
                    from,
                    f64::MAX,
                    "finite, not before its beginning",
                )?;
            }
        }
        self.bumps.iter().try_for_each(Bump::validate)
    }
}

/// 0 below zero, 1 above one, a cubic between: smooth to the first derivative. With its slope.
#[inline]
fn smooth_step<T: Scalar>(s: T) -> (T, T) {
    let s = s.clamp(T::zero(), T::one());
    (
        s * s * (T::from_f64(3.0) - s.scale(2.0)),
        s.scale(6.0) * (T::one() - s),
    )
}

/// 1 inside `[from, to]`, 0 outside, blended over `edge_m`.
#[inline]
fn inside<T: Scalar>(at: T, [from, to]: [f64; 2], edge_m: f64) -> T {
    let past = |border: f64| {
        let beyond = at - T::from_f64(border);
        if edge_m > 0.0 {
            smooth_step(beyond.scale(1.0 / edge_m) + T::from_f64(0.5)).0
        } else {
            beyond.select(T::one(), T::zero())
        }
    };
    past(from) * (T::one() - past(to))
}

fn within(
    parameter: &'static str,
    found: f64,
    low: f64,
    high: f64,
    accepted: &'static str,
) -> Result<(), RoadError> {
    if found >= low && found <= high {
        Ok(())
    } else {
        Err(RoadError::OutOfRange {
            parameter,
            found,
            accepted,
        })
    }
}

fn friction(parameter: &'static str, found: f64) -> Result<(), RoadError> {
    within(parameter, found, 0.01, 2.0, "0.01 (wet ice) to 2")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rough() -> Road {
        toml::from_str(
            r#"
            friction_ratio = 0.9
            slope_rad = 0.05
            bank_rad = -0.03
            patches = [
                { x_m = [10.0, 20.0], friction_ratio = 0.3, edge_m = 0.5 },
                { x_m = [12.0, 14.0], y_m = [0.0, 3.0], friction_ratio = 0.1, edge_m = 0.0 },
            ]
            bumps = [
                { cosine = { start_m = 3.0, length_m = 1.0, height_m = 0.05 } },
                { step = { start_m = 6.0, length_m = 0.2, height_m = -0.1 } },
                { roughness = { seed = 4, start_m = -100.0, fade_m = 1.0, roughness_m3 = 64e-6, wavelength_m = [0.5, 50.0], lines = 40 } },
            ]
            "#,
        )
        .unwrap()
    }

    #[test]
    fn friction_follows_patches_and_sides() {
        let road = rough();
        for (x, y, expected) in [
            (5.0, 0.0, 0.9),
            (11.0, 1.0, 0.3),
            (13.0, 1.0, 0.1),
            (13.0, -1.0, 0.3),
            (13.0, 4.0, 0.3),
            (20.0, 0.0, 0.6),
            (21.0, 0.0, 0.9),
        ] {
            let found: f64 = road.friction_ratio(x, y);
            assert!(
                (found - expected).abs() < 1e-12,
                "{found} at {x}, {y}, expected {expected}"
            );
        }
    }

    #[test]
    fn uphill_is_up_and_a_right_bank_is_low_on_the_right() {
        let road = Road {
            slope_rad: 0.1,
            bank_rad: 0.2,
            ..Road::level(1.0)
        };
        assert!(road.height_m(1.0, 0.0) > 0.0 && road.height_m(0.0, 1.0) < 0.0);
        assert_eq!(Road::level(1.0).height_m(3.0, 4.0), 0.0);
    }

    #[test]
    fn gradients_agree_with_differences() {
        let road = rough();
        let h = 1e-5;
        for i in 0..400 {
            let (x, y) = (0.0503 * f64::from(i) - 1.0, 0.01 * f64::from(i) - 2.0);
            let spot = road.surface(x, y);
            let along = (road.height_m(x + h, y) - road.height_m(x - h, y)) / (2.0 * h);
            let across = (road.height_m(x, y + h) - road.height_m(x, y - h)) / (2.0 * h);
            assert!(
                (spot.along_ratio - along).abs() < 1e-5,
                "{} {along} at {x}",
                spot.along_ratio
            );
            assert!((spot.across_ratio - across).abs() < 1e-8);
        }
    }

    #[test]
    fn toml_goes_round_and_typos_are_refused() {
        let road = rough();
        road.validate().unwrap();
        assert_eq!(
            toml::from_str::<Road>(&toml::to_string(&road).unwrap()).unwrap(),
            road
        );
        let error = toml::from_str::<Road>("friction_ratio = 1.0\nslop_rad = 0.1").unwrap_err();
        assert!(error.to_string().contains("slop_rad"), "{error}");
    }

    #[test]
    fn impossible_roads_are_refused() {
        let patch = Patch {
            x_m: [2.0, 1.0],
            y_m: None,
            friction_ratio: 0.5,
            edge_m: 0.1,
        };
        for (road, parameter) in [
            (Road::level(0.0), "friction_ratio"),
            (Road::level(f64::NAN), "friction_ratio"),
            (
                Road {
                    slope_rad: 0.5,
                    ..Road::level(1.0)
                },
                "slope_rad",
            ),
            (
                Road {
                    patches: vec![patch],
                    ..Road::level(1.0)
                },
                "patches.to",
            ),
        ] {
            let error = road.validate().unwrap_err().to_string();
            assert!(error.contains(parameter), "{error}");
        }
    }
}
