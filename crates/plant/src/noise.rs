//! Seeded noise: one named stream for each source, so that adding a source changes no other.

use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64;

/// The random stream of the source called `name` in the ride with seed `seed`.
pub fn stream(seed: u64, name: &str) -> Gaussian {
    let hash = twinhub_types::wire::hash_str(twinhub_types::wire::HASH_START, name);
    let hash = twinhub_types::wire::hash_u64(hash, seed);
    Gaussian {
        rng: Pcg64::seed_from_u64(hash),
        spare: None,
    }
}

/// Standard normal deviates by the polar method of Box and Muller (1958), with `libm` functions:
/// the same bits on every machine.
#[derive(Clone, Debug)]
pub struct Gaussian {
    rng: Pcg64,
    spare: Option<f64>,
}

impl Gaussian {
    /// Uniform on [0, 1), 53 bits.
    pub fn uniform(&mut self) -> f64 {
        (self.rng.next_u64() >> 11) as f64 * (1.0 / (1u64 << 53) as f64)
    }

    /// Normal with mean 0 and standard deviation 1.
    pub fn normal(&mut self) -> f64 {
        if let Some(spare) = self.spare.take() {
            return spare;
        }
        let radius = libm::sqrt(-2.0 * libm::log(1.0 - self.uniform()));
        let (sin, cos) = libm::sincos(2.0 * core::f64::consts::PI * self.uniform());
        self.spare = Some(radius * sin);
        radius * cos
    }
}

/// First-order Gauss-Markov noise: stationary standard deviation `sd`, correlation time
/// 1 / `bandwidth_rad_s`, exact at any step.
#[derive(Clone, Debug)]
pub struct ColouredNoise {
    sd: f64,
    bandwidth_rad_s: f64,
    value: f64,
    source: Gaussian,
}

impl ColouredNoise {
    /// Starts from the stationary distribution.
    pub fn new(sd: f64, bandwidth_rad_s: f64, mut source: Gaussian) -> Self {
        let value = sd * source.normal();
        Self {
            sd,
            bandwidth_rad_s,
            value,
            source,
        }
    }

    /// The value after another `step_s` seconds.
    pub fn step(&mut self, step_s: f64) -> f64 {
        let keep = libm::exp(-self.bandwidth_rad_s * step_s);
        self.value =
            keep * self.value + self.sd * libm::sqrt(1.0 - keep * keep) * self.source.normal();
        self.value
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coloured_noise_has_its_standard_deviation_and_correlation() {
        let mut noise = ColouredNoise::new(2.0, 10.0, stream(1, "test"));
        let x: Vec<f64> = (0..200_000).map(|_| noise.step(0.01)).collect();
        let var = x.iter().map(|v| v * v).sum::<f64>() / x.len() as f64;
        let cov = x.windows(11).map(|w| w[0] * w[10]).sum::<f64>() / x.len() as f64;
        // 200,000 samples of correlation time 0.1 s: about 10,000 independent ones.
        assert!((var / 4.0 - 1.0).abs() < 0.06, "variance {var}");
        assert!(
            (cov / var - libm::exp(-1.0)).abs() < 0.04,
            "correlation after 0.1 s {}",
            cov / var
        );
    }

    #[test]
    fn streams_differ_by_name_and_seed_and_repeat() {
        let first = |seed, name: &str| stream(seed, name).normal().to_bits();
        assert_eq!(first(1, "a"), first(1, "a"));
        assert_ne!(first(1, "a"), first(1, "b"));
        assert_ne!(first(1, "a"), first(2, "a"));
    }
}
