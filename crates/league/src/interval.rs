//! Intervals of 95 %: resampling for means, Poisson's for rates, Bonett and Price's for paired shares.
//!
//! Source: Garwood (1936), Biometrika 28, 437-442 (rate of a Poisson process); Bonett and Price
//! (2012), Journal of Educational and Behavioral Statistics 37(4), 479-488 (difference of paired
//! proportions).

use serde::{Deserialize, Serialize};
use statrs::distribution::{ChiSquared, ContinuousCDF, Normal};
use twinhub_plant::noise::stream;

/// A number with its 95 % interval.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Estimate {
    /// The number.
    pub value: f64,
    /// Its 95 % interval.
    pub ci95: [f64; 2],
}

const RESAMPLES: usize = 2000;

/// The mean of `values`, resampled; none of nothing.
pub fn mean(values: &[f64]) -> Option<Estimate> {
    ratio(&values.iter().map(|v| (*v, 1.0)).collect::<Vec<_>>())
}

/// Sum of the first over sum of the second, pairs resampled together; none where the second is 0.
pub fn ratio(pairs: &[(f64, f64)]) -> Option<Estimate> {
    let of = |sum: (f64, f64)| sum.0 / sum.1;
    let add = |a: (f64, f64), b: &(f64, f64)| (a.0 + b.0, a.1 + b.1);
    let total = pairs.iter().fold((0.0, 0.0), add);
    if total.1 <= 0.0 {
        return None;
    }
    let ci95 = resampled(pairs.len(), |draw| {
        of((0..pairs.len()).fold((0.0, 0.0), |sum, _| add(sum, &pairs[draw()])))
    });
    Some(Estimate {
        value: of(total),
        ci95,
    })
}

/// The value that a share `part` of `values` stays below, resampled; none of nothing.
pub fn quantile(values: &[f64], part: f64) -> Option<Estimate> {
    let at = |mut values: Vec<f64>| {
        values.sort_by(f64::total_cmp);
        let place = libm::ceil(part * values.len() as f64) as usize;
        values[place.clamp(1, values.len()) - 1]
    };
    if values.is_empty() {
        return None;
    }
    let ci95 = resampled(values.len(), |draw| {
        at((0..values.len()).map(|_| values[draw()]).collect())
    });
    Some(Estimate {
        value: at(values.to_vec()),
        ci95,
    })
}

/// 2.5 and 97.5 % of what `once` gives on resamples of `n` places; `once` is handed a draw of a place.
fn resampled(n: usize, once: impl Fn(&mut dyn FnMut() -> usize) -> f64) -> [f64; 2] {
    let mut noise = stream(n as u64, "league.interval");
    let mut draw = || ((noise.uniform() * n as f64) as usize).min(n - 1);
    let mut found: Vec<f64> = (0..RESAMPLES).map(|_| once(&mut draw)).collect();
    found.retain(|v| v.is_finite());
    found.sort_by(f64::total_cmp);
    match found.len() {
        0 => [f64::NAN; 2],
        m => [0.025, 0.975].map(|part| found[((part * m as f64) as usize).min(m - 1)]),
    }
}

/// `events` in `exposure`: their rate. Exact for independent events.
pub fn rate(events: u64, exposure: f64) -> Option<Estimate> {
    if exposure <= 0.0 {
        return None;
    }
    let half_quantile = |part: f64, freedom: f64| {
        ChiSquared::new(freedom).map_or(f64::NAN, |d| 0.5 * d.inverse_cdf(part))
    };
    let k = events as f64;
    let low = if events == 0 {
        0.0
    } else {
        half_quantile(0.025, 2.0 * k)
    };
    let high = half_quantile(0.975, 2.0 * k + 2.0);
    Some(Estimate {
        value: k / exposure,
        ci95: [low / exposure, high / exposure],
    })
}

/// Difference of two paired shares: of `n` pairs, the event came `only_first` times to the first
/// alone and `only_second` times to the second alone. First less second, with the two-sided interval
/// of `confidence`.
pub fn paired_difference(
    only_first: u64,
    only_second: u64,
    n: u64,
    confidence: f64,
) -> (f64, [f64; 2]) {
    let all = n.max(1) as f64;
    let (first, second) = (only_first as f64, only_second as f64);
    let (p12, p21) = (
        (first + 1.0) / (n as f64 + 2.0),
        (second + 1.0) / (n as f64 + 2.0),
    );
    let middle = p12 - p21;
    let spread = libm::sqrt((p12 + p21 - middle * middle) / (n as f64 + 2.0));
    let z = Normal::standard().inverse_cdf(0.5 + 0.5 * confidence);
    let bounds = [middle - z * spread, middle + z * spread];
    ((first - second) / all, bounds.map(|b| b.clamp(-1.0, 1.0)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rate_has_the_published_limits() {
        // Garwood's limits for 0, 1 and 10 events.
        for (events, low, high) in [(0, 0.0, 3.689), (1, 0.0253, 5.572), (10, 4.795, 18.39)] {
            let rate = rate(events, 1.0).expect("exposed");
            assert!((rate.ci95[0] - low).abs() < 1e-3, "{rate:?}");
            assert!((rate.ci95[1] - high).abs() < 5e-3, "{rate:?}");
        }
        assert!(rate(3, 0.0).is_none());
    }

    #[test]
    fn means_cover_the_truth_as_often_as_they_say() {
        let mut inside = 0;
        for seed in 0..200 {
            let mut noise = stream(seed, "test");
            let values: Vec<f64> = (0..40).map(|_| 3.0 + noise.normal()).collect();
            let found = mean(&values).expect("values");
            inside += usize::from(found.ci95[0] <= 3.0 && 3.0 <= found.ci95[1]);
        }
        assert!((180..=199).contains(&inside), "{inside} of 200");
    }

    #[test]
    fn quantiles_and_ratios() {
        let values: Vec<f64> = (1..=200).map(f64::from).collect();
        let worst = quantile(&values, 0.99).expect("values");
        assert_eq!(worst.value, 198.0);
        assert!(worst.ci95[0] < 198.0 && worst.ci95[1] >= 198.0);
        assert_eq!(ratio(&[(1.0, 2.0), (3.0, 2.0)]).expect("values").value, 1.0);
        assert!(mean(&[]).is_none() && ratio(&[(1.0, 0.0)]).is_none());
    }

    #[test]
    fn paired_shares_follow_bonett_and_price() {
        // 10 against 2 of 100: adjusted shares 11/102 and 3/102.
        let (difference, [low, high]) = paired_difference(10, 2, 100, 0.95);
        assert_eq!(difference, 0.08);
        let middle = 8.0 / 102.0;
        let spread = ((14.0 / 102.0 - middle * middle) / 102.0_f64).sqrt();
        assert!((high - middle - 1.959_964 * spread).abs() < 1e-6);
        assert!((middle - low - 1.959_964 * spread).abs() < 1e-6);
    }
}
