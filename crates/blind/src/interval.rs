//! Intervals: Wilson's for shares, the bootstrap's for medians, and the test for uniform p-values.

use rand::{Rng, SeedableRng};
use rand_pcg::Pcg32;

/// Standard normal quantile of a 95 % interval.
const Z: f64 = 1.959_963_984_540_054;
const RESAMPLES: usize = 2000;

/// Wilson's 95 % interval of a share (Wilson 1927).
pub fn wilson(hits: usize, of: usize) -> [f64; 2] {
    if of == 0 {
        return [0.0, 1.0];
    }
    let (n, p) = (of as f64, hits as f64 / of as f64);
    let middle = p + Z * Z / (2.0 * n);
    let half = Z * (p * (1.0 - p) / n + Z * Z / (4.0 * n * n)).sqrt();
    let scale = 1.0 + Z * Z / n;
    [
        ((middle - half) / scale).max(0.0),
        ((middle + half) / scale).min(1.0),
    ]
}

/// Median; none of nothing.
pub fn median(values: &[f64]) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let n = sorted.len();
    match n {
        0 => None,
        _ if n % 2 == 1 => Some(sorted[n / 2]),
        _ => Some(0.5 * (sorted[n / 2 - 1] + sorted[n / 2])),
    }
}

/// 95 % interval of the median by resampling.
pub fn bootstrap_median(values: &[f64]) -> Option<[f64; 2]> {
    if values.is_empty() {
        return None;
    }
    let mut rng = Pcg32::seed_from_u64(values.len() as u64);
    let mut draw = || values[(rng.next_u32() as usize) % values.len()];
    let mut medians: Vec<f64> = (0..RESAMPLES)
        .filter_map(|_| median(&(0..values.len()).map(|_| draw()).collect::<Vec<_>>()))
        .collect();
    medians.sort_by(f64::total_cmp);
    let at = |part: f64| medians[((part * RESAMPLES as f64) as usize).min(RESAMPLES - 1)];
    Some([at(0.025), at(0.975)])
}

/// p-value of Kolmogorov's test that the values are uniform on [0, 1] (asymptotic, with Stephens'
/// correction; good from about ten values).
pub fn uniform_p(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let n = sorted.len() as f64;
    let distance = sorted.iter().enumerate().fold(0.0_f64, |d, (k, x)| {
        d.max((x - k as f64 / n).abs())
            .max(((k + 1) as f64 / n - x).abs())
    });
    let root = n.sqrt();
    let lambda = (root + 0.12 + 0.11 / root) * distance;
    if lambda < 0.2 {
        return 1.0;
    }
    let term = |k: i32| {
        f64::from(1 - 2 * ((k + 1) % 2)) * (-2.0 * f64::from(k * k) * lambda * lambda).exp()
    };
    (2.0 * (1..=100).map(term).sum::<f64>()).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wilson_as_published() {
        // Newcombe (1998), Statistics in Medicine 17, 857-872, table I: 81 of 263, 15 of 148, 0 of 20.
        for (hits, of, low, high) in [
            (81, 263, 0.2553, 0.3662),
            (15, 148, 0.0624, 0.1605),
            (0, 20, 0.0, 0.1611),
        ] {
            let [a, b] = wilson(hits, of);
            assert!(
                (a - low).abs() < 5e-5 && (b - high).abs() < 5e-5,
                "{hits} of {of}: {a} {b}"
            );
        }
    }

    #[test]
    fn medians() {
        assert_eq!(median(&[3.0, 1.0, 2.0]), Some(2.0));
        assert_eq!(median(&[4.0, 1.0]), Some(2.5));
        assert_eq!(median(&[]), None);
        let values: Vec<f64> = (0..101).map(f64::from).collect();
        let [low, high] = bootstrap_median(&values).unwrap();
        // Order statistics 41 and 61 for n = 101.
        assert!(
            (35.0..46.0).contains(&low) && (55.0..66.0).contains(&high),
            "{low} {high}"
        );
    }

    #[test]
    fn uniform_values_pass_and_others_do_not() {
        let even: Vec<f64> = (0..100).map(|k| (f64::from(k) + 0.5) / 100.0).collect();
        assert!(uniform_p(&even) > 0.99);
        let small: Vec<f64> = even.iter().map(|x| x * x).collect();
        assert!(uniform_p(&small) < 0.001);
        // Kolmogorov's distribution: D sqrt(n) = 1.358 at 5 %.
        let d = 1.358 / (100.0f64.sqrt() + 0.12 + 0.011);
        let moved: Vec<f64> = even.iter().map(|x| (x + d - 0.005).min(1.0)).collect();
        assert!(
            (uniform_p(&moved) - 0.05).abs() < 0.01,
            "{}",
            uniform_p(&moved)
        );
    }
}
