//! What shows that data is bad: before the fit channel against channel, after it inputs that do not
//! act.

use super::answer::Fault;
use super::fitting::Baseline;
use super::rides::Rides;
use super::score::Bench;
use super::thresholds::THRESHOLDS;
use crate::compare::relations;
use crate::data::RideData;
use crate::study::Role;
use twinhub_ident::Equations;
use twinhub_linear::Bicycle;

/// A channel that follows another one so many times too strongly has a wrong unit.
const UNIT: f64 = 3.0;
/// Share of samples at the very extreme, in runs, from which a channel counts as saturated.
const SATURATED_SHARE: f64 = 0.03;
/// Share of samples that stand alone off their neighbours from which a channel counts as spiky.
const SPIKE_SHARE: f64 = 0.003;

/// Faults that need no model fit.
pub fn before_fit(bicycle: &Bicycle, data: &[RideData]) -> Vec<Fault> {
    let mut faults = vec![];
    let equations = Equations::new(bicycle).ok();
    for ride in data {
        let mut tell = |channel: &str, reason: String| {
            faults.push(Fault {
                channel: channel.to_owned(),
                ride: Some(ride.spec.file.clone()),
                reason,
            });
        };
        for channel in &ride.channels {
            if channel.spec.role != Role::Output {
                continue;
            }
            let values: Vec<f64> = channel
                .samples
                .iter()
                .filter(|s| {
                    ride.windows
                        .iter()
                        .any(|w| (w.start_s..w.end_s).contains(&s.0))
                })
                .map(|s| s.1)
                .collect();
            let name = channel.spec.quantity.name();
            if values.len() < 10 {
                continue;
            }
            if values.windows(2).all(|p| p[0] == p[1]) {
                tell(
                    name,
                    format!("column {} does not change: dead", channel.spec.column),
                );
            } else if saturated_share(&values) > SATURATED_SHARE {
                tell(
                    name,
                    format!(
                        "column {} stands at its extreme: saturated",
                        channel.spec.column
                    ),
                );
            } else if spike_share(&values, channel.spec.quantum) > SPIKE_SHARE {
                tell(
                    name,
                    format!("column {} is full of isolated spikes", channel.spec.column),
                );
            }
        }
        let Some(equations) = &equations else {
            continue;
        };
        for relation in relations(equations, ride) {
            if relation.r < -0.5 {
                tell(
                    &relation.measured,
                    format!(
                        "has the wrong sign against {} (r = {:.2})",
                        relation.expected, relation.r
                    ),
                );
            } else if relation.r > 0.8 && !(1.0 / UNIT..UNIT).contains(&relation.slope) {
                tell(
                    &relation.measured,
                    format!(
                        "is {:.3} times what {} says: wrong unit or scale",
                        relation.slope, relation.expected
                    ),
                );
            }
        }
    }
    faults
}

fn saturated_share(values: &[f64]) -> f64 {
    let (low, high) = values
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| {
            (a.min(*x), b.max(*x))
        });
    let mut count = 0;
    let mut run = 0;
    for v in values {
        if *v == low || *v == high {
            run += 1;
        } else {
            if run >= 10 {
                count += run;
            }
            run = 0;
        }
    }
    f64::from(count + if run >= 10 { run } else { 0 }) / values.len() as f64
}

fn spike_share(values: &[f64], quantum: f64) -> f64 {
    let off: Vec<f64> = values
        .windows(5)
        .map(|w| {
            let mut sorted = [w[0], w[1], w[2], w[3], w[4]];
            sorted.sort_by(f64::total_cmp);
            (w[2] - sorted[2]).abs()
        })
        .collect();
    // What is usual: nine of ten steps between samples are smaller. Most steps of a coarse channel
    // are zero; the others show its quantum, declared or not.
    let mut steps: Vec<f64> = values.windows(2).map(|w| (w[1] - w[0]).abs()).collect();
    steps.sort_by(f64::total_cmp);
    let moving = &steps[steps.partition_point(|step| *step == 0.0)..];
    let usual = steps[steps.len() * 9 / 10]
        .max(moving.get(moving.len() * 3 / 4).copied().unwrap_or(0.0))
        .max(quantum);
    let count = off
        .iter()
        .filter(|x| **x > 12.0 * usual && usual > 0.0)
        .count();
    count as f64 / values.len() as f64
}

/// Inputs to which the outputs do not answer.
pub fn dead_inputs(fit: &Rides, baseline: &Baseline) -> Vec<Fault> {
    let Some(bench) = Bench::new(fit, baseline) else {
        return vec![];
    };
    let mut faults = vec![];
    for (name, channel) in [
        ("steer_torque_gain", "steer_torque_nm"),
        ("lateral_force_gain", "lateral_force_n"),
        ("front_motor_gain", "front_brake_nm"),
        ("rear_motor_gain", "rear_traction_nm"),
    ] {
        let drives = fit.0.iter().any(|r| {
            r.ride.drives.iter().any(|d| d.quantity.name() == channel)
                || (channel == "front_brake_nm" && r.ride.front_brake.is_some())
                || (channel == "rear_traction_nm" && r.ride.rear_traction.is_some())
        });
        let score = twinhub_mechanism::find(name)
            .filter(|_| drives)
            .and_then(|m| bench.score(m));
        let Some(score) = score else { continue };
        let gain = 1.0 + score.first_size();
        let sd = score.unit.abs() * (score.widening / score.information[0]).sqrt();
        // A gain that is neither is the model's business.
        let reason = if gain.abs() < THRESHOLDS.dead_input_gain {
            "the bicycle does not answer to it: shifted in time, or of another ride?"
        } else if (gain + 1.0).abs() < THRESHOLDS.dead_input_gain {
            "the bicycle answers to it the other way round: wrong sign?"
        } else {
            continue;
        };
        if (1.0 - gain) / sd > THRESHOLDS.dead_input_z {
            faults.push(Fault {
                channel: channel.to_owned(),
                ride: None,
                reason: format!("{reason} (gain {gain:.2} with standard error {sd:.2})"),
            });
        }
    }
    faults
}

#[cfg(test)]
mod tests {
    use super::*;

    fn swing(k: usize) -> f64 {
        0.02 * libm::sin(k as f64 * 0.05)
    }

    #[test]
    fn a_coarse_encoder_is_no_spike_and_a_spike_is() {
        let coarse = |k: usize| libm::round(swing(k) / 0.0015) * 0.0015;
        let mut values: Vec<f64> = (0..2000).map(coarse).collect();
        // It flickers between neighbours now and then.
        for k in (0..2000).step_by(150) {
            values[k] += 0.0015;
        }
        assert_eq!(spike_share(&values, 0.0), 0.0);
        for k in (10..2000).step_by(150) {
            values[k] += 0.2;
        }
        assert!(spike_share(&values, 0.0) > SPIKE_SHARE);
        let mut smooth: Vec<f64> = (0..2000).map(swing).collect();
        assert_eq!(spike_share(&smooth, 0.0), 0.0);
        for k in (10..2000).step_by(150) {
            smooth[k] += 0.2;
        }
        assert!(spike_share(&smooth, 0.0) > SPIKE_SHARE);
    }
}
