//! Bumps: height profiles along the road, a registry.

use super::{RoadError, smooth_step, within};
use crate::Scalar;
use crate::explain::Explain;
use core::f64::consts::PI;
use serde::{Deserialize, Serialize};

/// A height profile along the road.
pub trait BumpModel {
    /// Height (upwards, m) and its slope at `x_m`.
    fn profile<T: Scalar>(&self, x_m: T) -> (T, T);
    /// Refuses what cannot be.
    fn validate(&self) -> Result<(), RoadError>;
    /// What `twinhub explain` says.
    fn explain(&self) -> Explain;
}

twinhub_types::registry! {
    /// Every kind of bump.
    #[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
    #[serde(rename_all = "snake_case")]
    pub enum Bump: BumpModel {
        /// One wave of a cosine: a speed bump (or a dip, with negative height).
        Cosine(CosineBump) = "cosine",
        /// A kerb with its edge rounded.
        Step(Step) = "step",
        /// Random roughness as a sum of sines.
        Roughness(Roughness) = "roughness",
    }
    fn profile[T: Scalar](&self, x_m: T) -> (T, T);
    fn validate(&self) -> Result<(), RoadError>;
    fn explain(&self) -> Explain;
}

/// One example of every bump, with a sentence.
pub const BUMPS: [(&str, Bump); 3] = [
    (
        "a speed bump of 5 cm on 1 m",
        Bump::Cosine(CosineBump {
            start_m: 10.0,
            length_m: 1.0,
            height_m: 0.05,
        }),
    ),
    (
        "a kerb of 3 cm",
        Bump::Step(Step {
            start_m: 10.0,
            length_m: 0.1,
            height_m: 0.03,
        }),
    ),
    (
        "a road of class B",
        Bump::Roughness(Roughness {
            seed: 1,
            start_m: 0.0,
            fade_m: 5.0,
            roughness_m3: 64e-6,
            wavelength_m: [0.2, 20.0],
            lines: 100,
        }),
    ),
];

/// height/2 (1 - cos(2π s / length)) between start and start + length.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CosineBump {
    /// Where it begins, m.
    pub start_m: f64,
    /// How long it is, m.
    pub length_m: f64,
    /// How high it is, m; negative: a dip.
    pub height_m: f64,
}

impl BumpModel for CosineBump {
    #[inline]
    fn profile<T: Scalar>(&self, x_m: T) -> (T, T) {
        let s = (x_m - T::from_f64(self.start_m)).scale(1.0 / self.length_m);
        let (sin, cos) = s.clamp(T::zero(), T::one()).scale(2.0 * PI).sin_cos();
        (
            (T::one() - cos).scale(0.5 * self.height_m),
            sin.scale(PI * self.height_m / self.length_m),
        )
    }
    fn explain(&self) -> Explain {
        Explain {
            name: "cosine",
            what: "one wave of a cosine across the road: a speed bump, or a dip",
            equation: "h(x) = height/2 (1 - cos(2π (x - start)/length)) between start and start + length",
            source: "elementary",
            assumes: "the tyre touches at one point: shorter than the contact patch (0.1 m) it is felt too sharp",
        }
    }
    fn validate(&self) -> Result<(), RoadError> {
        shape(self.start_m, self.length_m, self.height_m)
    }
}

/// Rises by height over length, by a cubic, and stays there.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Step {
    /// Where the rise begins, m.
    pub start_m: f64,
    /// Length of the rise, m; at least the contact patch (0.1 m) for a wheel to follow it.
    pub length_m: f64,
    /// Height afterwards, m; negative goes down.
    pub height_m: f64,
}

impl BumpModel for Step {
    #[inline]
    fn profile<T: Scalar>(&self, x_m: T) -> (T, T) {
        let s = (x_m - T::from_f64(self.start_m)).scale(1.0 / self.length_m);
        let (rise, slope) = smooth_step(s);
        (
            rise.scale(self.height_m),
            slope.scale(self.height_m / self.length_m),
        )
    }
    fn explain(&self) -> Explain {
        Explain {
            name: "step",
            what: "a kerb with its edge rounded",
            equation: "height times the cubic s² (3 - 2 s), s = (x - start)/length held in 0 to 1",
            source: "elementary",
            assumes: "no side wall: a wheel always climbs it",
        }
    }
    fn validate(&self) -> Result<(), RoadError> {
        shape(self.start_m, self.length_m, self.height_m)
    }
}

/// Random roughness with the spectrum of ISO 8608: a sum of sines, one in each of `lines` equal
/// bands of spatial frequency, at a random place in its band and with a random phase. A pure
/// function of place: the same seed is the same road.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Roughness {
    /// Chooses frequencies and phases.
    pub seed: u64,
    /// Where it begins, m.
    pub start_m: f64,
    /// Length over which it fades in, m.
    pub fade_m: f64,
    /// Displacement spectrum at 0.1 cycles/m, m³ (class A 16e-6, B 64e-6, C 256e-6).
    pub roughness_m3: f64,
    /// Shortest and longest wave, m.
    pub wavelength_m: [f64; 2],
    /// Number of sines, 1 to 1000.
    pub lines: u32,
}

impl BumpModel for Roughness {
    #[inline]
    fn profile<T: Scalar>(&self, x_m: T) -> (T, T) {
        let x = x_m - T::from_f64(self.start_m);
        let (fade, fade_slope) = smooth_step(x.scale(1.0 / self.fade_m));
        let [short, long] = self.wavelength_m;
        let low = 1.0 / long;
        let band = (1.0 / short - low) / f64::from(self.lines);
        // A = √(2 Gd(n) Δn), Gd(n) = Gd(n0) (n0 / n)²
        let at_1_per_m = 0.1 * libm::sqrt(2.0 * self.roughness_m3 * band);
        let (mut height, mut slope) = (T::zero(), T::zero());
        for line in 0..self.lines {
            let n = low + (f64::from(line) + uniform(self.seed, 2 * line)) * band;
            let phase = 2.0 * PI * uniform(self.seed, 2 * line + 1);
            let (sin, cos) = (x.scale(2.0 * PI * n) + T::from_f64(phase)).sin_cos();
            height += sin.scale(at_1_per_m / n);
            slope += cos.scale(2.0 * PI * at_1_per_m);
        }
        (
            fade * height,
            fade * slope + height * fade_slope.scale(1.0 / self.fade_m),
        )
    }
    fn explain(&self) -> Explain {
        Explain {
            name: "roughness",
            what: "random roughness of the road",
            equation: "sum of sines, one in each of equal bands of spatial frequency, with the spectrum Gd(n) = Gd(n0) (n0/n)², n0 = 0.1 cycles/m",
            source: "ISO 8608:2016; class A 16e-6 m³, B 64e-6, C 256e-6",
            assumes: "the same over the whole width; a finite number of waves",
        }
    }
    fn validate(&self) -> Result<(), RoadError> {
        within("bumps.start_m", self.start_m, f64::MIN, f64::MAX, "finite")?;
        within(
            "bumps.fade_m",
            self.fade_m,
            1e-3,
            f64::MAX,
            "0.001 m or more",
        )?;
        within(
            "bumps.roughness_m3",
            self.roughness_m3,
            0.0,
            0.1,
            "0 to 0.1 m³",
        )?;
        let [short, long] = self.wavelength_m;
        within(
            "bumps.wavelength_m[0]",
            short,
            0.01,
            f64::MAX,
            "0.01 m or more",
        )?;
        within(
            "bumps.wavelength_m[1]",
            long,
            short,
            1e4,
            "the shortest wave to 10000 m",
        )?;
        within(
            "bumps.lines",
            f64::from(self.lines),
            1.0,
            1000.0,
            "1 to 1000",
        )
    }
}

fn shape(start_m: f64, length_m: f64, height_m: f64) -> Result<(), RoadError> {
    within("bumps.start_m", start_m, f64::MIN, f64::MAX, "finite")?;
    within(
        "bumps.length_m",
        length_m,
        1e-3,
        f64::MAX,
        "0.001 m or more",
    )?;
    within("bumps.height_m", height_m, -1.0, 1.0, "-1 to 1 m")
}

/// Number `index` of the uniform numbers on [0, 1) that belong to `seed`: SplitMix64 (Steele, Lea
/// and Flood 2014), which needs no state.
#[inline]
pub(crate) fn uniform(seed: u64, index: u32) -> f64 {
    let step = 0x9e37_79b9_7f4a_7c15_u64;
    let mut z = seed.wrapping_add(step.wrapping_mul(u64::from(index) + 1));
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((z ^ (z >> 31)) >> 11) as f64 * (1.0 / (1u64 << 53) as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    const ROUGH: Roughness = Roughness {
        seed: 7,
        start_m: 0.0,
        fade_m: 1.0,
        roughness_m3: 64e-6,
        wavelength_m: [0.5, 20.0],
        lines: 200,
    };

    #[test]
    fn roughness_has_the_variance_of_its_spectrum() {
        // ∫ Gd(n0) (n0/n)² dn from 0.05 to 2 = 64e-6 x 0.01 x (20 - 0.5)
        let expected = 64e-6 * 0.01 * 19.5;
        let samples = 200_000;
        let sum: f64 = (0..samples)
            .map(|i| ROUGH.profile(10.0 + 0.05 * f64::from(i)).0)
            .map(|height| height * height)
            .sum();
        let found = sum / f64::from(samples);
        assert!(
            (found / expected - 1.0).abs() < 0.1,
            "variance {found:e}, expected {expected:e}"
        );
    }

    #[test]
    fn another_seed_is_another_road_and_the_same_seed_the_same() {
        let other = Roughness { seed: 8, ..ROUGH };
        assert_ne!(ROUGH.profile(30.0), other.profile(30.0));
        assert_eq!(ROUGH.profile(30.0), { ROUGH }.profile(30.0));
        assert_eq!(ROUGH.profile(-1.0), (0.0, 0.0), "flat before it begins");
    }

    #[test]
    fn a_kerb_stays_up_and_a_speed_bump_comes_down() {
        let kerb = Step {
            start_m: 1.0,
            length_m: 0.2,
            height_m: 0.1,
        };
        let bump = CosineBump {
            start_m: 1.0,
            length_m: 0.2,
            height_m: 0.1,
        };
        assert_eq!(kerb.profile(0.9).0, 0.0);
        assert!((kerb.profile(5.0).0 - 0.1_f64).abs() < 1e-15);
        assert!((bump.profile(1.1).0 - 0.1_f64).abs() < 1e-15);
        assert!(f64::abs(bump.profile(5.0).0) < 1e-15);
    }

    #[test]
    fn roughness_that_cannot_be_is_refused() {
        for bad in [
            Roughness { lines: 0, ..ROUGH },
            Roughness {
                wavelength_m: [2.0, 1.0],
                ..ROUGH
            },
            Roughness {
                roughness_m3: f64::NAN,
                ..ROUGH
            },
            Roughness {
                fade_m: 0.0,
                ..ROUGH
            },
        ] {
            assert!(bad.validate().is_err(), "{bad:?}");
        }
    }
}
