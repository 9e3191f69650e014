//! What a comparison found, as it is printed, drawn and written as JSON.

use super::kinematics::Relation;
use super::{HORIZONS_S, MAIN_HORIZON, words};
use crate::data::{Finding, RideData};
use crate::quantity::Quantity;
use crate::study::Study;
use serde::Serialize;
use std::collections::BTreeMap;
use twinhub_ident::forecast::{Forecast, Growth, Score};
use twinhub_ident::{NoiseEstimate, Track};

/// Length of the stretch that is called the worst.
const WORST_S: f64 = 2.0;

/// One horizon of one channel.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct HorizonResult {
    pub vaf: Option<f64>,
    pub rmse: f64,
    /// At the end of the runs only.
    pub rmse_at_end: Option<f64>,
    /// The yardstick: the last reading before the run, held.
    pub held_vaf: Option<f64>,
    pub held_rmse: Option<f64>,
    pub readings: usize,
}

/// One output channel.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ChannelResult {
    pub column: String,
    /// At 0.5 s.
    pub vaf: Option<f64>,
    pub rmse: Option<f64>,
    /// By horizon in seconds; null where no window is longer than the horizon.
    pub horizons: BTreeMap<String, Option<HorizonResult>>,
    /// White noise of the sensor, given or estimated.
    pub noise_sd: f64,
    /// Correlation of predicted and measured change over 0.5 s: below zero, it moves the other way.
    pub change_correlation: Option<f64>,
}

/// The stretch where predictions err most, relative to each channel's spread.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Worst {
    pub ride: String,
    #[serde(skip)]
    pub ride_index: usize,
    pub start_s: f64,
    pub end_s: f64,
    /// The channel that errs most there.
    pub channel: String,
    /// Root mean square error over the channels, each relative to its standard deviation.
    pub error_ratio: f64,
}

/// Estimated noise of the two equations.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Noise {
    pub roll_nm_sqrt_s: f64,
    pub steer_nm_sqrt_s: f64,
    /// Mean normalised innovation squared: 1 if the predictor knows how uncertain it is.
    pub consistency: f64,
    pub converged: bool,
    /// Levels that stand at the end of their range.
    pub at_limit: Vec<String>,
}

/// Everything that `compare` found.
#[derive(Clone, Debug, Serialize)]
pub struct Comparison {
    pub schema_version: u32,
    pub study: String,
    pub file: String,
    pub rides: Vec<String>,
    pub channels: BTreeMap<String, ChannelResult>,
    pub worst: Option<Worst>,
    pub mean_speed_m_s: f64,
    /// Of the fastest growing mode at the mean speed; negative: it decays.
    pub growth_rate_1_s: f64,
    pub growth_omega_rad_s: f64,
    pub noise: Noise,
    pub relations: Vec<Relation>,
    pub findings: Vec<Finding>,
    /// How wrong the model is, in words.
    pub statements: Vec<String>,
    #[serde(skip)]
    pub traces: Vec<RideTrace>,
}

/// One ride's signals for the report.
#[derive(Clone, Debug)]
pub struct RideTrace {
    pub ride: String,
    pub windows_s: Vec<[f64; 2]>,
    pub channels: Vec<Trace>,
}

/// One channel's signals.
#[derive(Clone, Debug)]
pub struct Trace {
    pub quantity: Quantity,
    pub column: String,
    /// Time and reading.
    pub measured: Vec<[f64; 2]>,
    /// Time, prediction up to 0.5 s ahead, reading, time since the run's start.
    pub predicted: Vec<[f64; 4]>,
    /// Time and value of one longer free run at the worst stretch.
    pub free_run: Vec<[f64; 2]>,
}

/// Sums of one channel over all rides.
#[derive(Default)]
pub(super) struct Scores {
    model: [Score; HORIZONS_S.len()],
    end: [Score; HORIZONS_S.len()],
    held: [Score; HORIZONS_S.len()],
    change: [f64; 3],
    noise_sd: f64,
}

impl Scores {
    pub fn add(&mut self, track: &Track, sensor: usize, forecasts: &[Forecast], noise_sd: f64) {
        self.noise_sd = noise_sd;
        for (k, forecast) in forecasts.iter().enumerate() {
            let mine = || {
                forecast
                    .predictions
                    .iter()
                    .filter(|p| track.readings[p.reading].sensor == sensor)
            };
            let value = |reading: usize| track.readings[reading].value;
            let pairs: Vec<(f64, f64)> = mine().map(|p| (value(p.reading), p.predicted)).collect();
            self.model[k].add(&pairs);
            let ends: Vec<(f64, f64)> = mine()
                .filter(|p| p.last)
                .map(|p| (value(p.reading), p.predicted))
                .collect();
            self.end[k].add(&ends);
            let held: Vec<(f64, f64)> = mine()
                .filter_map(|p| Some((value(p.reading), p.held?)))
                .collect();
            self.held[k].add(&held);
            if k == MAIN_HORIZON {
                for p in mine().filter(|p| p.last) {
                    let Some(held) = p.held else { continue };
                    let (said, was) = (p.predicted - held, value(p.reading) - held);
                    self.change[0] += said * was;
                    self.change[1] += said * said;
                    self.change[2] += was * was;
                }
            }
        }
    }

    fn result(&self, column: &str) -> ChannelResult {
        let horizon = |k: usize| {
            Some(HorizonResult {
                vaf: self.model[k].vaf(),
                rmse: self.model[k].rmse()?,
                rmse_at_end: self.end[k].rmse(),
                held_vaf: self.held[k].vaf(),
                held_rmse: self.held[k].rmse(),
                readings: self.model[k].count(),
            })
        };
        let [xy, xx, yy] = self.change;
        ChannelResult {
            column: column.to_owned(),
            vaf: self.model[MAIN_HORIZON].vaf(),
            rmse: self.model[MAIN_HORIZON].rmse(),
            horizons: HORIZONS_S
                .iter()
                .enumerate()
                .map(|(k, h)| (h.to_string(), horizon(k)))
                .collect(),
            noise_sd: self.noise_sd,
            change_correlation: (xx > 0.0 && yy > 0.0).then(|| xy / (xx * yy).sqrt()),
        }
    }
}

fn spread(values: impl Iterator<Item = f64> + Clone) -> f64 {
    let count = values.clone().count().max(1) as f64;
    let mean = values.clone().sum::<f64>() / count;
    (values.map(|v| (v - mean) * (v - mean)).sum::<f64>() / count).sqrt()
}

/// Looks for the worst stretch in steps of a twentieth of its length.
pub(super) fn worst_stretch(traces: &[RideTrace]) -> Option<Worst> {
    let mut worst: Option<Worst> = None;
    for (ride_index, trace) in traces.iter().enumerate() {
        let spreads: Vec<f64> = trace
            .channels
            .iter()
            .map(|c| spread(c.measured.iter().map(|m| m[1])))
            .collect();
        for &[start, end] in &trace.windows_s {
            let length = WORST_S.min(end - start);
            let count = ((end - start - length) / (WORST_S / 20.0) + 1e-9) as usize;
            for k in 0..=count {
                let from = start + k as f64 * WORST_S / 20.0;
                let mut ratios: Vec<(f64, usize)> = vec![];
                for (index, (channel, sd)) in trace.channels.iter().zip(&spreads).enumerate() {
                    let begin = channel.predicted.partition_point(|p| p[0] < from);
                    let stop = channel.predicted.partition_point(|p| p[0] < from + length);
                    let part = &channel.predicted[begin..stop];
                    let read = |t: f64| channel.measured.partition_point(|m| m[0] < t);
                    // A stretch that is hardly predicted at all is not judged.
                    if part.len() * 2 < read(from + length) - read(from)
                        || part.is_empty()
                        || *sd == 0.0
                    {
                        continue;
                    }
                    let square = part
                        .iter()
                        .map(|p| (p[1] - p[2]) * (p[1] - p[2]))
                        .sum::<f64>()
                        / part.len() as f64;
                    ratios.push((square / (sd * sd), index));
                }
                let Some(most) = ratios
                    .iter()
                    .copied()
                    .reduce(|p, q| if q.0 > p.0 { q } else { p })
                else {
                    continue;
                };
                let ratio = (ratios.iter().map(|r| r.0).sum::<f64>() / ratios.len() as f64).sqrt();
                if worst.as_ref().is_none_or(|w| ratio > w.error_ratio) {
                    worst = Some(Worst {
                        ride: trace.ride.clone(),
                        ride_index,
                        start_s: from,
                        end_s: from + length,
                        channel: trace.channels[most.1].quantity.name().to_owned(),
                        error_ratio: ratio,
                    });
                }
            }
        }
    }
    worst
}

#[allow(clippy::too_many_arguments)]
pub(super) fn assemble(
    study: &Study,
    data: &[RideData],
    scores: BTreeMap<(Quantity, String), Scores>,
    traces: Vec<RideTrace>,
    worst: Option<Worst>,
    growth: Growth,
    mean_speed_m_s: f64,
    estimate: &NoiseEstimate,
    free: &[(Quantity, String)],
    relations: Vec<Relation>,
) -> Comparison {
    let twice = |q: Quantity| scores.keys().filter(|k| k.0 == q).count() > 1;
    let name = |(q, column): &(Quantity, String)| {
        if twice(*q) {
            format!("{q} ({column})")
        } else {
            q.name().to_owned()
        }
    };
    let channels: BTreeMap<String, ChannelResult> = scores
        .iter()
        .map(|(key, s)| (name(key), s.result(&key.1)))
        .collect();
    let level_name = |i: usize| match i {
        0 => "roll torque".to_owned(),
        1 => "steer torque".to_owned(),
        _ => free[i - 2].1.clone(),
    };
    let at_limit = estimate
        .at_limit
        .iter()
        .enumerate()
        .filter(|(_, at)| **at)
        .map(|(i, _)| level_name(i));
    let mut comparison = Comparison {
        schema_version: 1,
        study: study.name.clone(),
        file: study.file.display().to_string(),
        rides: data.iter().map(|d| d.spec.file.clone()).collect(),
        channels,
        worst,
        mean_speed_m_s,
        growth_rate_1_s: growth.rate_1_s,
        growth_omega_rad_s: growth.omega_rad_s,
        noise: Noise {
            roll_nm_sqrt_s: estimate.levels[0],
            steer_nm_sqrt_s: estimate.levels[1],
            consistency: estimate.consistency,
            converged: estimate.converged,
            at_limit: at_limit.collect(),
        },
        relations,
        findings: data.iter().flat_map(|d| d.findings.clone()).collect(),
        statements: vec![],
        traces,
    };
    comparison.statements = words::statements(&comparison);
    comparison
}
