//! Where the residual lies: in which band of an equation, at which order of a turning part, at which time.
//!
//! Bands and orders by `matched`. A moment is a second of a ride whose innovations are too large: their
//! squares sum to chi² with as many degrees as there are readings.

use super::answer::{Answer, Order, Verdict, Where};
use super::greedy::Found;
use super::matched::Filtered;
use super::pictures::Spectrum;
use super::rides::Rides;
use super::thresholds::THRESHOLDS;
use crate::engine::Model;
use statrs::distribution::{ChiSquared, ContinuousCDF};
use std::collections::BTreeMap;
use twinhub_ident::Signal;
use twinhub_mechanism::Equation;

const EQUATIONS: [&str; 2] = ["roll", "steer"];
/// Orders of cranks and front wheel that are looked at.
const ORDERS: [u32; 2] = [1, 2];
/// How far a line stands out of the powers around it, an octave to either side.
const LINE: f64 = 2.0;
/// Length of a moment.
const MOMENT_S: f64 = 1.0;

/// Frequencies from 0.1 to 8 Hz, four a factor of two.
fn frequencies() -> Vec<f64> {
    (0..=25)
        .map(|k| 0.1 * libm::pow(2.0, f64::from(k) / 4.0))
        .collect()
}

/// Power by frequency in one equation: mean over rides and phases, 1 where only noise acts.
fn spectrum(rides: &[Filtered<'_>], axis: usize, grid: &[f64]) -> Vec<f64> {
    let at = |f: &f64| {
        let omega = 2.0 * std::f64::consts::PI * f;
        let power: f64 = rides.iter().map(|r| r.power(axis, |t| omega * t)).sum();
        0.5 * power / rides.len() as f64
    };
    grid.iter().map(at).collect()
}

/// Bands, orders and times for the places of the answer, and the pictures.
pub fn fill(answer: &mut Answer, fit: &Rides, before: &Model, found: &Found) {
    let grid = frequencies();
    let count = 2.0 * fit.0.len() as f64;
    let Ok(null) = ChiSquared::new(count) else {
        return;
    };
    let limit = null.inverse_cdf(0.99) / count;
    let Some(first) = Filtered::all(fit, before) else {
        return;
    };
    let last = if answer.causes.is_empty() {
        None
    } else {
        Filtered::all(fit, &found.baseline.model)
    };
    let last = last.as_ref().unwrap_or(&first);
    for (axis, equation) in EQUATIONS.into_iter().enumerate() {
        let before = spectrum(&first, axis, &grid);
        let after = if answer.causes.is_empty() {
            before.clone()
        } else {
            spectrum(last, axis, &grid)
        };
        let seen = if answer.verdict == Verdict::Unknown {
            &after
        } else {
            &before
        };
        let band = band(seen, &grid, &null, limit);
        for place in answer.places.iter_mut().filter(|p| p.equation == equation) {
            place.band_hz = place.band_hz.or(band);
        }
        answer.pictures.spectra.push(Spectrum {
            equation: equation.to_owned(),
            limit: vec![limit; grid.len()],
            frequency_hz: grid.clone(),
            before,
            after,
        });
    }
    lines(answer, &first, last, &grid, &null);
    if matches!(answer.verdict, Verdict::Unknown | Verdict::Partial)
        && let Some((ride, time_s)) = moment(last)
    {
        for place in &mut answer.places {
            place.ride = Some(ride.clone());
            place.time_s = Some(time_s);
        }
    }
}

/// The band around the strongest frequency, if that is beyond chance.
fn band(seen: &[f64], grid: &[f64], null: &ChiSquared, limit: f64) -> Option<[f64; 2]> {
    let (peak, power) =
        seen.iter().copied().enumerate().fold(
            (0, 0.0),
            |best, (k, p)| if p > best.1 { (k, p) } else { best },
        );
    let p_value = null.sf(power * null.freedom()) * grid.len() as f64;
    if p_value >= THRESHOLDS.band_p_value {
        return None;
    }
    let strong = |k: usize| seen[k] > limit.max(0.3 * power);
    let mut low = peak;
    while low > 0 && strong(low - 1) {
        low -= 1;
    }
    let mut high = peak;
    while high + 1 < grid.len() && strong(high + 1) {
        high += 1;
    }
    let half = libm::pow(2.0, 1.0 / 8.0);
    Some([grid[low] / half, grid[high] * half])
}

/// An order of a turning part in one equation.
struct Line {
    axis: usize,
    order: Order,
    p_value: f64,
    power: f64,
    hz: f64,
}

/// The strongest order of every turning part that is measured in all rides.
fn strongest(rides: &[Filtered<'_>], null: &ChiSquared) -> Vec<Line> {
    let of_wheel = |r: &Filtered<'_>| r.ride.wheel.clone();
    let of_cranks = |r: &Filtered<'_>| r.ride.crank.clone();
    let parts: [(&str, Option<Vec<Signal>>); 2] = [
        ("wheel", rides.iter().map(of_wheel).collect()),
        ("cadence", rides.iter().map(of_cranks).collect()),
    ];
    let mut lines = vec![];
    for (of, angles) in parts {
        let Some(angles) = angles else {
            continue;
        };
        let hz = angles.iter().map(rate_hz).sum::<f64>() / angles.len() as f64;
        let all = ORDERS.iter().flat_map(|n| [(0, *n), (1, *n)]);
        let line = all
            .map(|(axis, n)| {
                let both = rides.iter().zip(&angles);
                let power: f64 = both
                    .map(|(r, angle)| r.power(axis, |t| f64::from(n) * angle.at(t).0))
                    .sum();
                Line {
                    axis,
                    order: Order {
                        of: of.to_owned(),
                        n,
                    },
                    p_value: null.sf(power) * 2.0 * ORDERS.len() as f64,
                    power: power / null.freedom(),
                    hz: f64::from(n) * hz,
                }
            })
            .max_by(|a, b| a.power.total_cmp(&b.power));
        lines.extend(line);
    }
    lines
}

/// Mean rate of an angle.
fn rate_hz(angle: &Signal) -> f64 {
    let (t, a) = (angle.times_s(), angle.values());
    let (t_s, turned) = (t[t.len() - 1] - t[0], a[a.len() - 1] - a[0]);
    if t_s > 0.0 {
        turned.abs() / (2.0 * std::f64::consts::PI * t_s)
    } else {
        0.0
    }
}

/// Orders of causes that turn, and orders that stand out of what is left: a narrow line vanishes in the
/// mean of a band.
fn lines(
    answer: &mut Answer,
    first: &[Filtered<'_>],
    last: &[Filtered<'_>],
    grid: &[f64],
    null: &ChiSquared,
) {
    for line in strongest(first, null) {
        let turns = |with: &str| {
            with == "wheel_imbalance" && line.order.of == "wheel"
                || with == "pedalling_torque" && line.order.of == "cadence"
        };
        let places = answer.places.iter_mut();
        for place in places.filter(|p| p.with.as_deref().is_some_and(turns)) {
            place.order = Some(line.order.clone());
        }
    }
    for line in strongest(last, null) {
        let spectrum = &answer.pictures.spectra[line.axis].after;
        let near = |f: &&f64| (0.5..2.0).contains(&(**f / line.hz));
        let around = grid.iter().zip(spectrum).filter(|(f, _)| near(f));
        let around = around.map(|(_, p)| *p).collect::<Vec<f64>>();
        let mean = around.iter().sum::<f64>() / around.len().max(1) as f64;
        if line.p_value >= THRESHOLDS.unknown_p_value || line.power < LINE * mean.max(1.0) {
            continue;
        }
        let equation = EQUATIONS[line.axis];
        let same = answer.places.iter_mut().find(|p| p.equation == equation);
        match same {
            // What goes with a state and turns with a part is one thing.
            Some(place) if answer.causes.is_empty() => place.order = Some(line.order),
            _ => answer.places.push(Where {
                equation: equation.to_owned(),
                band_hz: None,
                order: Some(line.order),
                time_s: None,
                ride: None,
                p_value: line.p_value,
                with: None,
            }),
        }
        for cause in &mut answer.causes {
            cause.confirmed &= !judged_by(&cause.mechanism, equation);
        }
        match answer.verdict {
            Verdict::NoEffect => answer.verdict = Verdict::Unknown,
            // The names may be right, and are not all.
            Verdict::Cause | Verdict::Causes => answer.verdict = Verdict::Partial,
            _ => {}
        }
    }
}

/// Whether a cause is confirmed only where this equation is clean: one of its own, for a sensor any.
fn judged_by(mechanism: &str, equation: &str) -> bool {
    twinhub_mechanism::find(mechanism).is_some_and(|m| {
        let own = m.card().equations;
        own.iter()
            .any(|e| *e == Equation::Sensor || e.name() == equation)
    })
}

/// The ride and the stretch that hold most of what is too large, if it is confined to one: a patch of the
/// road, a kick, a slip.
fn moment(rides: &[Filtered<'_>]) -> Option<(String, [f64; 2])> {
    // By ride and second: excess of squares over readings, and readings.
    let mut seconds: BTreeMap<(usize, i64), [f64; 2]> = BTreeMap::new();
    for (ride, filtered) in rides.iter().enumerate() {
        for (reading, e) in filtered.course().readings.iter().zip(&filtered.white) {
            let second = libm::floor(reading.t_s / MOMENT_S) as i64;
            let sum = seconds.entry((ride, second)).or_default();
            *sum = [sum[0] + e * e - 1.0, sum[1] + 1.0];
        }
    }
    let large = |[excess, count]: &[f64; 2]| {
        ChiSquared::new(*count)
            .is_ok_and(|chance| chance.sf(excess + count) * (seconds.len() as f64) < 1e-6)
    };
    let hot: Vec<((usize, i64), f64)> = (seconds.iter())
        .filter(|(_, sum)| large(sum))
        .map(|(key, sum)| (*key, sum[0]))
        .collect();
    let (first, last) = (hot.first()?.0, hot.last()?.0);
    // One stretch of one ride, seconds side by side.
    let is_one = first.0 == last.0 && last.1 - first.1 < hot.len() as i64 + 1;
    is_one.then(|| {
        let from_s = first.1 as f64 * MOMENT_S;
        let to_s = (last.1 + 1) as f64 * MOMENT_S;
        (rides[first.0].ride.file.clone(), [from_s, to_s])
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_band_is_what_stands_out_around_the_peak() {
        let grid = frequencies();
        let null = ChiSquared::new(8.0).unwrap();
        let mut seen = vec![1.0; grid.len()];
        assert_eq!(band(&seen, &grid, &null, 2.5), None);
        seen[10..13].copy_from_slice(&[20.0, 30.0, 12.0]);
        let [low, high] = band(&seen, &grid, &null, 2.5).unwrap();
        assert!(low < grid[10] && low > grid[9] && high > grid[12] && high < grid[13]);
    }
}
