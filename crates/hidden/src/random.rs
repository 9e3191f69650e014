//! Random streams, one for each source: a new source changes no other.

use rand::{Rng, SeedableRng};
use rand_pcg::Pcg32;

/// A stream of uniform and normal numbers.
#[derive(Clone, Debug)]
pub struct Stream(Pcg32);

impl Stream {
    /// The stream of source `name` of the set with `seed`.
    pub fn new(seed: u64, name: &str) -> Self {
        // FNV-1a, so that neighbouring seeds and names lie far apart.
        let bytes = seed.to_le_bytes().into_iter().chain(name.bytes());
        let hash = bytes.fold(0xcbf2_9ce4_8422_2325_u64, |h, b| {
            (h ^ u64::from(b)).wrapping_mul(0x0000_0100_0000_01b3)
        });
        Self(Pcg32::seed_from_u64(hash))
    }

    /// Uniform on [0, 1).
    pub fn uniform(&mut self) -> f64 {
        f64::from(self.0.next_u32()) / 4_294_967_296.0
    }

    /// Uniform on [a, b).
    pub fn between(&mut self, a: f64, b: f64) -> f64 {
        a + (b - a) * self.uniform()
    }

    /// -1 or 1.
    pub fn sign(&mut self) -> f64 {
        if self.uniform() < 0.5 { -1.0 } else { 1.0 }
    }

    /// One of `count` things.
    pub fn index(&mut self, count: usize) -> usize {
        ((self.uniform() * count as f64) as usize).min(count - 1)
    }

    /// Standard normal, by Marsaglia's polar method.
    pub fn normal(&mut self) -> f64 {
        loop {
            let (a, b) = (self.between(-1.0, 1.0), self.between(-1.0, 1.0));
            let s = a * a + b * b;
            if s > 0.0 && s < 1.0 {
                return a * libm::sqrt(-2.0 * libm::log(s) / s);
            }
        }
    }

    /// Normal, drawn again beyond `limit` standard deviations.
    pub fn normal_within(&mut self, limit: f64) -> f64 {
        loop {
            let x = self.normal();
            if x.abs() <= limit {
                return x;
            }
        }
    }
}

/// Noise of first order: standard deviation `sd`, correlation time `time_s`.
#[derive(Clone, Debug)]
pub struct Coloured {
    value: f64,
    keep: f64,
    kick: f64,
    stream: Stream,
}

impl Coloured {
    pub fn new(sd: f64, time_s: f64, step_s: f64, mut stream: Stream) -> Self {
        let keep = libm::exp(-step_s / time_s);
        Self {
            value: sd * stream.normal(),
            keep,
            kick: sd * libm::sqrt(1.0 - keep * keep),
            stream,
        }
    }

    /// The next value, one step later.
    pub fn step(&mut self) -> f64 {
        self.value = self.keep * self.value + self.kick * self.stream.normal();
        self.value
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn normal_numbers_have_the_right_moments() {
        let mut stream = Stream::new(3, "moments");
        let values: Vec<f64> = (0..40_000).map(|_| stream.normal()).collect();
        let mean = values.iter().sum::<f64>() / 40_000.0;
        let square = values.iter().map(|x| x * x).sum::<f64>() / 40_000.0;
        let fourth = values.iter().map(|x| x.powi(4)).sum::<f64>() / 40_000.0;
        // Four standard errors: 1/sqrt(n), sqrt(2/n), sqrt(96/n).
        assert!(mean.abs() < 0.02 && (square - 1.0).abs() < 0.029 && (fourth - 3.0).abs() < 0.2);
    }

    #[test]
    fn streams_repeat_and_differ() {
        let first = |seed, name| Stream::new(seed, name).uniform();
        assert_eq!(first(1, "a"), first(1, "a"));
        assert_ne!(first(1, "a"), first(1, "b"));
        assert_ne!(first(1, "a"), first(2, "a"));
    }

    #[test]
    fn coloured_noise_keeps_its_level_and_forgets() {
        let mut noise = Coloured::new(2.0, 0.1, 0.01, Stream::new(5, "c"));
        let x: Vec<f64> = (0..60_000).map(|_| noise.step()).collect();
        let product = |lag: usize| (0..50_000).map(|k| x[k] * x[k + lag]).sum::<f64>() / 50_000.0;
        assert!((product(0) - 4.0).abs() < 0.3, "{}", product(0));
        assert!((product(10) / product(0) - (-1.0f64).exp()).abs() < 0.06);
    }
}
