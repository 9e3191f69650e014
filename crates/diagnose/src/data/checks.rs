//! Checks on what was read: windows within the data, inputs without gaps, jumps that no bicycle makes.

use super::{Channel, DataError, Finding};
use crate::quantity::Quantity;
use crate::study::{RideSpec, Role, WindowSpec};
use std::path::Path;

/// An input may be missing for this many of its sample intervals, at least for `SHORT_GAP_S`.
const GAP_INTERVALS: f64 = 5.0;
const SHORT_GAP_S: f64 = 0.05;
/// A bicycle changes its speed by less than this; brakes reach 10, a treadmill's start 5.
const MOST_ACCEL_M_S2: f64 = 20.0;
/// Jump from which a single speed sample counts as a spike, whatever the sampling rate.
const SPIKE_M_S: f64 = 0.2;
/// As many readings at one extreme value in a row as make a saturated channel.
const SATURATED: usize = 20;

fn interval_s(samples: &[(f64, f64)]) -> f64 {
    let mut steps: Vec<f64> = samples.windows(2).map(|p| p[1].0 - p[0].0).collect();
    steps.sort_by(f64::total_cmp);
    steps.get(steps.len() / 2).copied().unwrap_or(0.0)
}

/// The windows of the ride, each inside the data.
pub fn windows(
    spec: &RideSpec,
    path: &Path,
    channels: &[Channel],
) -> Result<Vec<WindowSpec>, DataError> {
    let edges = channels
        .iter()
        .filter(|c| c.spec.role != Role::Check)
        .filter_map(|c| {
            let (first, last) = (c.samples.first()?, c.samples.last()?);
            Some((first.0, last.0 + interval_s(&c.samples)))
        });
    let (first, last) = edges.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), (x, y)| {
        (a.min(x), b.max(y))
    });
    if first > last {
        return Err(DataError::File {
            path: path.to_owned(),
            found: "no value in any channel".to_owned(),
            accepted: "at least one".to_owned(),
        });
    }
    let Some(windows) = &spec.windows else {
        return Ok(vec![WindowSpec {
            start_s: first,
            end_s: last,
            usage: spec.usage,
            place: spec.place.clone(),
        }]);
    };
    let tolerance = 1e-6
        + 1e-3 * (last - first)
            / channels
                .iter()
                .map(|c| c.samples.len())
                .max()
                .unwrap_or(1)
                .max(1) as f64;
    for window in windows {
        if window.start_s < first - tolerance || window.end_s > last + tolerance {
            return Err(DataError::Value {
                place: window.place.clone(),
                found: format!("window [{}, {}] s", window.start_s, window.end_s),
                accepted: format!("windows inside the data, {first} to {last:.6} s"),
            });
        }
    }
    Ok(windows.clone())
}

/// Checks each channel within the windows; drops spikes of the speed and says so.
pub fn channels(
    path: &Path,
    channels: &mut [Channel],
    windows: &[WindowSpec],
    findings: &mut Vec<Finding>,
) -> Result<(), DataError> {
    for channel in channels.iter_mut() {
        let mut tell = |text: String| {
            findings.push(Finding {
                column: channel.spec.column.clone(),
                text,
            })
        };
        if channel.missing > 0 {
            tell(format!("{} missing values, skipped", channel.missing));
        }
        if channel.spec.role == Role::Check {
            continue;
        }
        if channel.spec.quantity == Quantity::Speed && channel.spec.role == Role::Input {
            let spikes = drop_spikes(&mut channel.samples);
            if let Some((t, jump)) = spikes
                .iter()
                .copied()
                .reduce(|p, q| if q.1.abs() > p.1.abs() { q } else { p })
            {
                let count = spikes.len();
                tell(format!(
                    "{count} isolated samples that no bicycle can follow, left out; the largest {jump:+.2} m/s at {t:.3} s"
                ));
            }
            if let Some((t, v)) = channel.samples.iter().find(|(_, v)| v.abs() > 60.0) {
                return Err(DataError::Value {
                    place: channel.spec.place.clone(),
                    found: format!("speed {v} m/s at {t} s in {}", path.display()),
                    accepted: "speeds within 60 m/s (scale turns km/h into m/s)".to_owned(),
                });
            }
        }
        let angle = matches!(channel.spec.quantity, Quantity::Roll | Quantity::Steer);
        if let Some((t, v)) = channel.samples.iter().find(|(_, v)| angle && v.abs() > 3.2) {
            return Err(DataError::Value {
                place: channel.spec.place.clone(),
                found: format!(
                    "{} = {v} at {t} s in {}",
                    channel.spec.quantity,
                    path.display()
                ),
                accepted: "angles within pi rad (scale turns degrees into radians)".to_owned(),
            });
        }
        if let Some((t, v)) = saturated(&channel.samples) {
            tell(format!(
                "stands at its extreme {v} for {SATURATED} samples or more from {t:.3} s: saturated or dead?"
            ));
        }
        let interval = interval_s(&channel.samples);
        let longest = (GAP_INTERVALS * interval).max(SHORT_GAP_S);
        for window in windows {
            let inside: Vec<f64> = channel
                .samples
                .iter()
                .map(|s| s.0)
                .filter(|t| (window.start_s..window.end_s).contains(t))
                .collect();
            let edges = [window.start_s]
                .into_iter()
                .chain(inside.iter().copied())
                .chain([window.end_s])
                .collect::<Vec<_>>();
            let gap = edges
                .windows(2)
                .map(|p| (p[0], p[1]))
                .find(|(a, b)| b - a > longest);
            let Some((from, to)) = gap else { continue };
            if channel.spec.role == Role::Input {
                return Err(DataError::Value {
                    place: channel.spec.place.clone(),
                    found: format!(
                        "input {} has no value from {from:.3} to {to:.3} s in {}",
                        channel.spec.column,
                        path.display()
                    ),
                    accepted: format!(
                        "gaps of an input up to {longest:.3} s; end the window before it and begin another one after it"
                    ),
                });
            }
            tell(format!("no value from {from:.3} to {to:.3} s"));
        }
    }
    Ok(())
}

/// Removes single samples or pairs that leave their neighbours on both sides faster than a bicycle
/// can, and gives their times and jumps.
fn drop_spikes(samples: &mut Vec<(f64, f64)>) -> Vec<(f64, f64)> {
    let mut spikes = vec![];
    let old = std::mem::take(samples);
    for (index, &(t, v)) in old.iter().enumerate() {
        // Median of the seven samples about it.
        let near = &old[index.saturating_sub(3)..(index + 4).min(old.len())];
        let mut values: Vec<f64> = near.iter().map(|s| s.1).collect();
        values.sort_by(f64::total_cmp);
        let jump = v - values[values.len() / 2];
        let reach = near.last().map_or(0.0, |s| s.0) - near.first().map_or(0.0, |s| s.0);
        match jump.abs() > SPIKE_M_S + MOST_ACCEL_M_S2 * reach * 0.5 {
            true => spikes.push((t, jump)),
            false => samples.push((t, v)),
        }
    }
    spikes
}

fn saturated(samples: &[(f64, f64)]) -> Option<(f64, f64)> {
    let (least, most) = samples
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), s| {
            (a.min(s.1), b.max(s.1))
        });
    let mut run = 0;
    for (index, (_, v)) in samples.iter().enumerate() {
        let extreme = (*v == least || *v == most) && least < most;
        run = if extreme && index > 0 && samples[index - 1].1 == *v {
            run + 1
        } else {
            0
        };
        if run + 1 >= SATURATED {
            return Some((samples[index + 1 - SATURATED].0, *v));
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spikes_go_and_braking_stays() {
        // Full braking from 8 m/s at 9 m/s², 100 Hz, one sample wrong.
        let mut samples: Vec<(f64, f64)> = (0..80)
            .map(|k| (k as f64 * 0.01, 8.0 - 0.09 * k as f64))
            .collect();
        let clean = samples.clone();
        assert!(drop_spikes(&mut samples).is_empty());
        assert_eq!(samples, clean);
        samples[40].1 += 1.2;
        let spikes = drop_spikes(&mut samples);
        assert_eq!(spikes.len(), 1);
        assert_eq!(spikes[0].0, 0.4);
        assert_eq!(samples.len(), 79);
    }

    #[test]
    fn saturation() {
        let wave = |k: usize| libm::sin(k as f64 * 0.1);
        let free: Vec<(f64, f64)> = (0..500).map(|k| (k as f64, wave(k))).collect();
        assert_eq!(saturated(&free), None);
        let stuck: Vec<(f64, f64)> = (0..500).map(|k| (k as f64, wave(k).min(0.3))).collect();
        assert!(saturated(&stuck).is_some());
    }
}
